#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "core/base/units.h"
#include "core/identify/testing/scenario.h"
#include "core/machine/chain.h"
#include "core/plan/program.h"
#include "core/plan/test.h"

namespace axiscal::plan {
namespace {

struct Line {
  std::string code;
  std::vector<double> positions;  // mm and rad, per axis of the machine
};

ProgramOptions Dialect(const std::string& name) {
  ProgramOptions options;
  options.dialect = name;
  return options;
}

// Reads the blocks as text: the interpreter does not follow G31.
std::vector<Line> Read(const machine::Machine& machine, const std::string& program) {
  std::vector<Line> lines;
  std::istringstream in(program);
  for (std::string text; std::getline(in, text);) {
    if (text.rfind("G00 ", 0) != 0 && text.rfind("G31 ", 0) != 0) continue;
    Line line{text.substr(0, 3), std::vector<double>(machine.axis_count(), NAN)};
    for (int i = 0; i < machine.axis_count(); ++i) {
      const size_t at = text.find(" " + machine.axes[i].name);
      if (at == std::string::npos) continue;
      const bool is_rotary = machine.axes[i].kind == machine::AxisKind::kRotary;
      line.positions[i] = std::stod(text.substr(at + 2)) * (is_rotary ? base::kRadPerDeg : 1.0);
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

// The stylus centre against the sphere's centre in the bed, by the chain: touches go to the centre, from outside;
// nothing else comes nearer than the sum of the radii, not on the way either.
TEST(SphereProbing, StylusTouchesFromFiveSidesAndElseKeepsClear) {
  const machine::Machine machine = machine::testing::MultiTasking();
  Mounted mounted;
  mounted.tips_mm = {{0, 0, -350}};
  mounted.balls_mm = {{90, 0, 60}};
  const auto planned = FindTest("sphere-probing")->plan(SituationOfMachine(machine, mounted));
  ASSERT_EQ(planned.size(), 6u);  // B and C, two styli
  for (const PlannedSession& one : planned) {
    const auto program = ToProgram(machine, one.session, Dialect("mazak"));
    ASSERT_TRUE(program.ok()) << program.status();
    const bool is_long = one.text.find("400 mm") != std::string::npos;
    const Eigen::Vector3d tip_mm(0, 0, is_long ? -400 : -350);
    const auto apart_mm = [&](const std::vector<double>& positions) -> Eigen::Vector3d {
      const auto pose = machine::EvaluateChain<double>(machine, positions.data(), {});
      return pose.bed_from_tool * tip_mm - pose.bed_from_table * Eigen::Vector3d(90, 0, 60);
    };
    const std::vector<Line> lines = Read(machine, *program);
    size_t touches = 0;
    for (size_t i = 0; i < lines.size(); ++i) {
      const Eigen::Vector3d here_mm = apart_mm(lines[i].positions);
      if (lines[i].code == "G31") {
        ++touches;
        EXPECT_LT(here_mm.norm(), 3e-4);                            // decimals of the angles on the lever of the tool
        EXPECT_EQ(lines[i + 1].positions, lines[i - 1].positions);  // back as it came
        continue;
      }
      EXPECT_GT(here_mm.norm(), 15.5 + 8.0 - 1e-3);
      if (i == 0 || lines[i - 1].code == "G31" || lines[i - 1].positions[3] != lines[i].positions[3] ||
          lines[i - 1].positions[4] != lines[i].positions[4])
        continue;
      const Eigen::Vector3d before_mm = apart_mm(lines[i - 1].positions);
      for (double share = 0.0; share <= 1.0; share += 0.05)
        EXPECT_GT((before_mm + share * (here_mm - before_mm)).norm(), 15.5 + 5.0);
    }
    EXPECT_EQ(touches, 5 * one.session.reading_count());
  }
}

TEST(SphereProbing, ProgramIsOfTheFiguresKind) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const auto session = FindTest("sphere-probing")->plan(SituationOfMachine(machine, {}))[0].session;
  const auto program = ToProgram(machine, session, Dialect("mazak"));
  ASSERT_TRUE(program.ok()) << program.status();
  EXPECT_NE(program->find("\nPOPEN\n"), std::string::npos);
  EXPECT_NE(program->find("#5003[4 4]"), std::string::npos);
  EXPECT_NE(program->find("\nPCLOS\n"), std::string::npos);
  EXPECT_EQ(ToProgram(machine, session, Dialect("heidenhain")).status().code(), absl::StatusCode::kFailedPrecondition);
}

}  // namespace
}  // namespace axiscal::plan
