#include "core/plan/setter_program.h"

#include <gmock/gmock.h>

#include "core/machine/testing/machines.h"
#include "core/plan/program.h"
#include "core/session/read_session.h"

namespace axiscal::plan {
namespace {

using ::testing::HasSubstr;

session::Session Rods() {
  return session::ReadPlanText(
             "# machine: mt\n# session: rods\n# instrument: tool-setter\n# sigma_um: 0.5\n# tool_tip_mm: 0 0 0\n"
             "# beam: 0.2 0 0\n# rod one: 5 0.03 90 0 133.702 0\n# rod two@30: 5 0.03 89.9 127 160.591 30\n"
             "# rod two: 5 0.03 89.9 127 160.591 0\nrod,readout,Z_mm\none,1,\none,2,\ntwo@30,1,\n",
             "plan.csv")
      .value();
}

session::Session Curve(const std::string& rpm = "1000") {
  return session::ReadPlanText(
             "# machine: mt\n# session: starts\n# instrument: tool-curve\n# sigma_um: 1\n# tool_tip_mm: 0 0 0\n"
             "# tool_radius_mm: 10\n# insert_radius_mm: 6\n# inserts: 2\n# radial_angle_deg: -8\n# axial_angle_deg: "
             "-5\n"
             "# offset_d_mm: 4\n# beam_radius_mm: 0.2\n# spindle_rpm: " +
                 rpm + "\n# feed_mm_min: 30\n# start_height_mm: 0.5\nstart_deg,length_mm\n0,\n90,\n180,\n270,\n",
             "plan.csv")
      .value();
}

ProgramOptions Options(const std::string& dialect) {
  ProgramOptions options;
  options.dialect = dialect;
  options.setter.beam_at_mm = {{"X", 100}, {"Y", -20}, {"Z", -510.5}};
  return options;
}

// Z' = beam + length: 2 mm above it the feed begins, 2 mm below it ends; 50 mm over the longest rod all else happens.
TEST(SetterProgram, Rods) {
  const auto program = ToProgram(machine::testing::MultiTasking(), Rods(), Options("fanuc"));
  ASSERT_TRUE(program.ok()) << program.status();
  EXPECT_THAT(*program, HasSubstr("DPRNT[Number*of*Points*3]\nDPRNT[Feature*Model*TRIGGER]\n"
                                  "G00 Z-297.9090\nG00 Y-20.0000 X100.0000 B0.0000 C0.0000\n"
                                  "M00\nM19 R0.0000\nG00 Z-374.7980\nG31 Z-378.7980 F4.0000\nDPRNT["));
  EXPECT_THAT(*program, HasSubstr("M00\nM19 R30.0000\nG00 Z-347.9090\nG31 Z-351.9090 F4.0000\n"));
  size_t stops = 0;
  for (size_t at = program->find("M00\n"); at != std::string::npos; at = program->find("M00\n", at + 1)) ++stops;
  EXPECT_EQ(stops, 2u) << "one for each rod that is mounted";
  const auto sinumerik = ToProgram(machine::testing::MultiTasking(), Rods(), Options("sinumerik"));
  ASSERT_TRUE(sinumerik.ok()) << sinumerik.status();
  EXPECT_THAT(*sinumerik, HasSubstr("SPOS=30.0000\n"));
  EXPECT_THAT(*sinumerik, HasSubstr("MEAS=1 G01 Z-351.9090 F4.0000\nSTOPRE\n"));
}

// Above zero the mill turns counter-clockwise seen from above: M04.
TEST(SetterProgram, StartsOfTheSpindle) {
  const auto program = ToProgram(machine::testing::MultiTasking(), Curve(), Options("linuxcnc"));
  ASSERT_TRUE(program.ok()) << program.status();
  EXPECT_THAT(*program,
              HasSubstr("M19 R90.0000\nG00 Z-510.0000\nS1000 M04\nG38.2 Z-512.5000 F30.0000\nM05\nG00 Z-460.0000\n"));
  EXPECT_THAT(*program, ::testing::Not(HasSubstr("M00\n")));
}

TEST(SetterProgram, RefusesWithWhatWasExpected) {
  const machine::Machine machine = machine::testing::MultiTasking();
  ProgramOptions options = Options("fanuc");
  options.setter.beam_at_mm.erase("Y");
  EXPECT_THAT(ToProgram(machine, Rods(), options).status().message(), HasSubstr("position of Y over the beam"));
  options = Options("fanuc");
  options.setter.clearance_mm = NAN;
  EXPECT_THAT(ToProgram(machine, Rods(), options).status().message(), HasSubstr("clearance_mm = nan"));
  EXPECT_EQ(ToProgram(machine, Rods(), Options("heidenhain")).status().code(), absl::StatusCode::kFailedPrecondition);
  machine::Machine low = machine;
  low.axes[machine::FindAxis(low, "Z")].min_position = -600.0;
  low.axes[machine::FindAxis(low, "Z")].max_position = -400.0;
  EXPECT_THAT(ToProgram(low, Rods(), Options("fanuc")).status().message(), HasSubstr("beyond its travel"));
}

}  // namespace
}  // namespace axiscal::plan
