// What compensation leaves, on the machines of tests/data/loop: the tool point of the machine with its errors, where
// both programs bring it by the chain alone (verify.h), for every way in which programs state moves.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/testing/source_path.h"
#include "core/machine/machine_json.h"
#include "core/nc/rewrite.h"
#include "core/nc/testing/yao.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

constexpr double kGoalMm = 1e-4;       // at the ends of blocks, beside the words' rounding
constexpr double kToleranceMm = 1e-3;  // along moves

// Three linear words, each off by half its last digit at most.
double RoundingMm(double grain_mm) { return 0.5 * grain_mm * std::sqrt(3.0); }

struct Case {
  const char* name;
  const char* program;  // $ is the axis that tilts
  double grain_mm = 1e-4;
  int least_split = 0;
};

// Moves of 500 mm, full turns of C, the tilting axis through +-90 deg.
const Case kCases[] = {
    {"linear",
     "G90 G21 G0 X-250. Y-250. Z0. $0. C0.\nG1 X250. F2000\nY250.\nZ-250.\nZ250.\nX-250. Y-250. Z-250.\nC360.\nC-360. "
     "X250.\n"
     "$90.\n$-90.\n$0. C0.\nX250. Y-250. Z200. $90. C720.\nX-250. Y250. Z-200. $-90. C0.\nZ-100.1234 $45.5678 "
     "C33.3333\n",
     1e-4, 5},
    {"incremental",
     "G90 G21 G0 X-250. Y-250. Z0. $0. C0.\nG91 G1 X500. F2000\nY500.\nZ-250.\nX-500. Y-500.\nC360.\nC-720. "
     "X500.\n$90.\n$-180.\n"
     "X-500. Y500. Z200. $180. C720.\nX.0001\nX-.0001 $-90.\nZ.5 C-.0001\n",
     1e-4, 4},
    {"inch",
     "G20 G90 G0 X-9.8 Y-9.8 Z0. $0. C0.\nG1 X9.8 F80.\nY9.8 Z-4.\nC360.\n$90. X0.\n$-90. C0. Y-9.8\nG91 X3.5 "
     "$45.\nC-180. Z1.\n",
     2.54e-4, 3},
    {"inverse time",
     "G90 G21 G0 X-250. Y-250. Z0. $0. C0.\nG93 G1 X250. F2.\nY250. $90. F.5\nC360. F1.\nX-250. Y-250. $-90. C-360. "
     "F.25\nG91 X250. $90. F1.\nG94 Z5. "
     "F100\n",
     1e-4, 3},
    {"arcs",
     "G90 G21 G17 G0 X100. Y0. Z0. $0. C0.\nG2 X0. Y-100. I-100. J0. F2000\nG3 X100. Y0. R100.\nG3 I-100.\nG2 X-100. "
     "Y0. Z-50. R100.\nG3 X100. "
     "Z0. I100. J0. C180.\nG18 G2 X0. Z100. I-100. K0.\nG3 X100. Z0. R-100.\nG19 G2 Y50. Z50. J50. K0.\nG3 Y0. Z0. "
     "R50.\nG17 G1 $60. "
     "C90.\nG2 X0. Y-100. I-100. J0.\nG3 I0. J100.\nG91 G2 X50. Y50. I50. J0.\nG3 X-20. Y-20. R20. Z3.\nG90 G1 X0. "
     "$-90.\nG90.1 G3 X70. Y0. "
     "I0. J0.\n",
     1e-4, 0},
};

machine::ErrorModel ErrorsOf(const machine::Machine& machine) {
  machine::ErrorModel errors = machine::DeclaredModel(machine);
  double sign = 1.0;
  for (auto& term : errors.terms) {
    term.amplitude[0] = sign * (machine::IsAngle(term.component) ? 8e-5 : 0.04);
    sign = -sign;
  }
  const auto add = [&](const std::string& symbol, double amplitude, const shapes::Shape& shape) {
    machine::ErrorTerm term = machine::ConstantTerm(machine, *machine::ParseErrorSymbol(symbol), amplitude);
    term.shape = shape;
    errors.terms.push_back(term);
  };
  const int x = machine::FindAxis(machine, "X"), y = machine::FindAxis(machine, "Y"),
            c = machine::FindAxis(machine, "C");
  add("EX0X", 0.03, shapes::Linear{x, shapes::Linear::kReferenceMm});
  add("EY0X", 0.01, shapes::Quadratic{x, shapes::Quadratic::kReferenceMm});
  add("EZ0Y", 0.004, shapes::Bump{y, 60.0, 40.0});
  add("EC0C", 2e-5, shapes::Harmonic{c, 2.0});
  add("EZ0C", 0.003, shapes::Harmonic{c, 9.0});
  return errors;
}

TEST(Accuracy, EveryWayToStateMovesOnTheThreeStructures) {
  std::vector<std::string> structures;
  for (const char* folder : {"case-000", "case-001", "case-002"}) {
    const auto read =
        machine::ReadMachineFile(base::SourcePath("/tests/data/loop/") + folder + "/machine.json");
    ASSERT_TRUE(read.ok()) << read.status();
    const machine::Machine machine = testing::CountingOn(*read);
    structures.push_back(machine.structure);
    const machine::ErrorModel errors = ErrorsOf(machine);
    const std::string tilt = machine::FindAxis(machine, "B") >= 0 ? "B" : "A";
    VerifyOptions verify;
    verify.reading.unit = ProgramUnit::kMillimetre;
    verify.tool_tip_mm = {0, 0, -150};
    verify.reading.tolerance_mm = kToleranceMm;
    const auto compensator = testing::MustCreate(machine, errors, verify.tool_tip_mm);
    for (const Case& known : kCases) {
      std::string program;
      for (const char* at = known.program; *at != 0; ++at) program += *at == '$' ? tilt : std::string(1, *at);
      SCOPED_TRACE(machine.structure + " " + known.name);
      RewriteReport report;
      const auto text = RewriteText(program, compensator, verify.reading, &report);
      ASSERT_TRUE(text.ok()) << text.status();
      const auto verified = VerifyText(program, *text, machine, errors, verify);
      ASSERT_TRUE(verified.ok()) << verified.status();
      EXPECT_EQ(verified->moves, report.blocks_corrected);
      EXPECT_EQ(verified->moves_unknown + report.blocks_passed, 0);
      EXPECT_GE(report.blocks_split, known.least_split);
      const double rounding_mm = RoundingMm(known.grain_mm);
      EXPECT_LE(verified->end_after.max_mm, kGoalMm + rounding_mm);
      EXPECT_LE(verified->path_after.max_mm, kToleranceMm + rounding_mm) << "line " << verified->worst_line;
      EXPECT_GT(verified->end_before.max_mm, 0.05);
      EXPECT_GT(verified->path_before.max_mm, 0.05);
    }
  }
  EXPECT_THAT(structures, ::testing::UnorderedElementsAre("w-C'bZYXB(C1)-t", "w-C'A'Y'bXZ(C1)-t", "w-C'Y'X'bZB(C1)-t"));
}

}  // namespace
}  // namespace axiscal::nc
