// Touch patterns: what is planned is a touch session of this machine, and its program touches what was planned, by the
// chain, and nothing else.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "core/base/units.h"
#include "core/instruments/run.h"
#include "core/instruments/touch/touch_bind.h"
#include "core/instruments/touch/touch_model.h"
#include "core/machine/chain.h"
#include "core/machine/testing/machines.h"
#include "core/plan/program.h"
#include "core/plan/test.h"
#include "core/session/read_session.h"

namespace axiscal::plan {
namespace {

using ::testing::HasSubstr;

Situation Situated(const machine::Machine& machine) {
  Mounted mounted;
  mounted.tips_mm = {{0, 0, -350}};
  mounted.balls_mm = {{20, 0, 60}};
  mounted.stylus_radius_mm = 2.5;
  return SituationOfMachine(machine, mounted);
}

std::vector<machine::Machine> Machines() {
  return {machine::testing::MultiTasking(), machine::testing::TiltingTable(), machine::testing::SwivelHead()};
}

std::vector<PlannedSession> AllTouches(const Situation& situation) {
  std::vector<PlannedSession> planned;
  for (const char* name : {"touch-sphere", "touch-plate", "touch-columns", "touch-blocks"}) {
    std::vector<PlannedSession> of_test = FindTest(name)->plan(situation);
    EXPECT_FALSE(of_test.empty()) << situation.machine->id << ' ' << name;
    for (PlannedSession& one : of_test) planned.push_back(std::move(one));
  }
  return planned;
}

TEST(TouchTests, EveryPatternIsATouchSessionOfItsMachine) {
  for (const machine::Machine& machine : Machines()) {
    for (const PlannedSession& one : AllTouches(Situated(machine))) {
      const auto read = session::ReadSessionText(ToTable(one.session), "plan.csv");
      ASSERT_TRUE(read.ok()) << read.status();
      EXPECT_EQ(read->columns.back().texts, one.session.columns.back().texts);
      const auto run = instruments::BindSession(*read, machine);  // gated: approach, distance, radius
      ASSERT_TRUE(run.ok()) << machine.id << ' ' << run.status();
      EXPECT_EQ(run->touches.stylus_radius_mm, 2.5);
      const double no_setup[instruments::kMaxSetupParameters] = {};
      for (int k = 0; k < run->reading_count(); ++k) {
        double gap_mm = NAN;
        touch::Predict<double>(machine, *run, k, run->PositionsOf(k), {}, no_setup, &gap_mm);
        EXPECT_NEAR(gap_mm, 0.0, 2e-3) << machine.id << ' ' << run->session << ' '
                                       << k;  // decimals on the tool's lever
      }
    }
  }
}

struct Block {
  std::string code;
  std::vector<double> positions;
};

std::vector<Block> Blocks(const machine::Machine& machine, const std::string& program) {
  std::vector<Block> blocks;
  std::istringstream in(program);
  for (std::string text; std::getline(in, text);) {
    const std::string code = text.substr(0, text.find(' '));
    if (code != "G00" && code != "G31" && code != "G38.2") continue;
    Block block{code, std::vector<double>(machine.axis_count(), NAN)};
    for (int i = 0; i < machine.axis_count(); ++i) {
      const size_t at = text.find(" " + machine.axes[i].name);
      EXPECT_NE(at, std::string::npos);
      const bool is_rotary = machine.axes[i].kind == machine::AxisKind::kRotary;
      block.positions[i] = std::stod(text.substr(at + 2)) * (is_rotary ? base::kRadPerDeg : 1.0);
    }
    blocks.push_back(std::move(block));
  }
  return blocks;
}

// How far the stylus ball stands off all features: for planes of a box, outside of the box means outside of one face.
double ClearanceMm(const machine::Machine& machine, const instruments::MeasuringRun& run,
                   const std::vector<double>& positions, const std::string& plan) {
  const auto pose = machine::EvaluateChain<double>(machine, positions.data(), {});
  const Eigen::Vector3d stylus_mm = pose.bed_from_table.Inverse() * (pose.bed_from_tool * run.tip_mm);
  double least_mm = INFINITY;
  std::map<std::string, double> outside_mm;  // by artefact: the largest distance from one of its faces
  for (const touch::Feature& feature : run.touches.features) {
    double off_mm = 0.0;
    if (feature.is_sphere) {
      off_mm = (stylus_mm - feature.point_mm).norm() - feature.radius_mm;
      least_mm = std::min(least_mm, off_mm);
      continue;
    }
    off_mm = feature.normal.dot(stylus_mm - feature.point_mm);
    const std::string box = feature.name.substr(0, feature.name.size() - 2);
    const auto [at, is_new] = outside_mm.emplace(box, off_mm);
    if (!is_new) at->second = std::max(at->second, off_mm);
  }
  // A box of which only some faces are touched is larger than it is: judged where all but the bottom are.
  if (plan == "touch-columns") {
    for (const auto& [box, off_mm] : outside_mm) least_mm = std::min(least_mm, off_mm);
  }
  return least_mm - run.touches.stylus_radius_mm;
}

TEST(TouchTests, ProgramsTouchWhatWasPlannedAndElseKeepClear) {
  for (const machine::Machine& machine : Machines()) {
    const std::vector<PlannedSession> planned = AllTouches(Situated(machine));
    for (const PlannedSession& one : planned) {
      ProgramOptions options;
      options.dialect = "linuxcnc";
      const auto program = ToProgram(machine, one.session, options);
      ASSERT_TRUE(program.ok()) << machine.id << ' ' << program.status();
      const auto run = instruments::BindSession(one.session, machine).value();
      const std::vector<Block> blocks = Blocks(machine, *program);
      const std::string plan = run.session.substr(0, 13);
      int touches = 0;
      for (size_t i = 0; i < blocks.size(); ++i) {
        if (blocks[i].code != "G00") {
          EXPECT_EQ(blocks[i].code, "G38.2");
          ASSERT_LT(touches, run.reading_count());
          // The planned contact lies on the way, 8 mm from the begin and 5 mm from the end.
          const double* contact = run.PositionsOf(touches++);
          for (int axis = 0; axis < machine.axis_count(); ++axis) {
            const double before = blocks[i - 1].positions[axis], after = blocks[i].positions[axis];
            EXPECT_NEAR(contact[axis], before + 8.0 / 13.0 * (after - before), 2e-3);
          }
          EXPECT_EQ(blocks[i + 1].positions, blocks[i - 1].positions);
          continue;
        }
        if (i == 0 || blocks[i - 1].code != "G00") continue;
        bool is_turn = false;
        for (int axis = 0; axis < machine.axis_count(); ++axis) {
          is_turn |= machine.axes[axis].kind == machine::AxisKind::kRotary &&
                     blocks[i].positions[axis] != blocks[i - 1].positions[axis];
        }
        for (double share = 0.0; share <= 1.0 && !is_turn; share += 0.1) {
          std::vector<double> positions = blocks[i].positions;
          for (size_t axis = 0; axis < positions.size(); ++axis)
            positions[axis] += share * (blocks[i - 1].positions[axis] - positions[axis]);
          EXPECT_GT(ClearanceMm(machine, run, positions, plan), 0.9) << machine.id << ' ' << run.session << ' ' << i;
        }
      }
      EXPECT_EQ(touches, run.reading_count());
    }
  }
}

TEST(TouchTests, DialectsPrintWhatReduceReads) {
  const machine::Machine machine = machine::testing::MultiTasking();  // its chain has Z, Y, X, B, C
  const PlannedSession one = FindTest("touch-sphere")->plan(Situated(machine))[0];
  ProgramOptions options;
  for (const char* dialect : {"fanuc", "mazak", "haas"}) {
    options.dialect = dialect;
    const auto program = ToProgram(machine, one.session, options);
    ASSERT_TRUE(program.ok()) << program.status();
    EXPECT_THAT(*program, HasSubstr("DPRNT[X#5001[4 4]*Y#5002[4 4]*Z#5003[4 4]*B#5004[4 4]*C#5005[4 4]]\n"));
    EXPECT_THAT(*program, HasSubstr(absl::StrCat("DPRNT[Number*of*Points*", one.session.reading_count(), "]\n")));
    EXPECT_THAT(*program, HasSubstr("\nG31 "));
  }
  options.dialect = "linuxcnc";
  const auto program = ToProgram(machine, one.session, options);
  ASSERT_TRUE(program.ok());
  EXPECT_THAT(*program, HasSubstr("(PROBEOPEN touch-sphere-B.txt)\n"));
  EXPECT_THAT(*program, HasSubstr("(PROBECLOSE)\n"));
  EXPECT_THAT(*program, ::testing::Not(HasSubstr("DPRNT")));
  options.dialect = "sinumerik";
  const auto sinumerik = ToProgram(machine, one.session, options);
  ASSERT_TRUE(sinumerik.ok()) << sinumerik.status();
  EXPECT_EQ(sinumerik->find("DEF INT ERR\n"), sinumerik->find("\nDEF ") + 1);
  EXPECT_LT(sinumerik->find("DEF STRING[32] LOG=\"AXISCAL_LOG\"\n"), sinumerik->find("G71 "));
  EXPECT_THAT(*sinumerik,
              HasSubstr(absl::StrCat("WRITE(ERR,LOG,\"Number of Points ", one.session.reading_count(), "\")\n")));
  EXPECT_THAT(*sinumerik, HasSubstr("\nMEAS=1 G01 "));
  EXPECT_THAT(*sinumerik, HasSubstr("\nSTOPRE\nIF $AC_MEA[1]==0 GOTOF NO_TOUCH\n"
                                    "WRITE(ERR,LOG,SPRINT(\"X%.4F Y%.4F Z%.4F B%.4F C%.4F\",$AA_MM[X],$AA_MM[Y],"
                                    "$AA_MM[Z],$AA_MM[B],$AA_MM[C]))\n"));
  EXPECT_THAT(*sinumerik, HasSubstr("\nM30\nNO_TOUCH:\n"));
  EXPECT_THAT(*sinumerik, ::testing::Not(HasSubstr("(MEASURING")));
  options.dialect = "heidenhain";
  const absl::Status klartext = ToProgram(machine, one.session, options).status();
  EXPECT_EQ(klartext.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(klartext.message()), HasSubstr("axiscal reduce --plan"));
  options.dialect = "mazak";
  options.probing.overtravel_mm = -1.0;
  EXPECT_EQ(ToProgram(machine, one.session, options).status().code(), absl::StatusCode::kInvalidArgument);
}

// A machine without a rotary axis has no such test, and says nothing of it.
TEST(TouchTests, NothingToTurnNothingToPlan) {
  const machine::Machine machine = machine::testing::Make(
      "mill",
      {machine::testing::Linear("X", machine::testing::kX), machine::testing::Linear("Y", machine::testing::kY),
       machine::testing::Linear("Z", machine::testing::kZ)},
      {}, {});
  for (const char* name : {"touch-sphere", "touch-plate", "touch-columns", "touch-blocks"})
    EXPECT_TRUE(FindTest(name)->plan(SituationOfMachine(machine, {})).empty()) << name;
}

}  // namespace
}  // namespace axiscal::plan
