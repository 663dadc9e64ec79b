// axiscal reduce: a controller's log becomes a session that identify takes.
#include <gmock/gmock.h>

#include "tests/cli/command_line.h"

namespace axiscal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::Source;

class Reduce : public testing::CommandLine {
 protected:
  static std::string Example(const std::string& name) {
    return " '" + Source("deploy/examples/integrex/" + name) + "' ";
  }
  static std::string Machine() { return " --machine" + Example("machine.json"); }
};

TEST_F(Reduce, TheExampleOfTheDocs) {
  const auto outcome = Run("reduce" + Example("fig-5.13-touch-log.txt") + "--template" + Example("fig-5.13.template") +
                           Machine() + "-o ball.csv");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out,
            "ball.csv: session ball-B0, touch, 21 readings from lines 4 to 24\n"
            "note: the log has no times: t_s counts 6 s per reading\n"
            "note: line 2 of the log announces 40 readings, 21 are there\n");
  EXPECT_FALSE(Exists("axiscal.db"));
  std::stringstream docs;
  docs << std::ifstream(Source("docs/logs.md")).rdbuf();
  EXPECT_THAT(docs.str(), HasSubstr(outcome.out));
  // The session is a session: stored, and a plan of the same touches.
  ASSERT_EQ(Run("machine add" + Example("machine.json")).exit_code, 0);
  EXPECT_EQ(Run("upload ball.csv").exit_code, 0);
  Write("again.txt", "Z-  81.5000 X-390.0000 Y   0.0000 C0.0000 B0.0000\nX-392.3406 Y0.0000 Z-81.8");
  const auto planned = Run("reduce again.txt --template dprnt --plan ball.csv --session again -o again.csv --json");
  ASSERT_EQ(planned.exit_code, 0) << planned.err;
  EXPECT_EQ(planned.Json()["readings"], 1);
  EXPECT_EQ(planned.Json()["cut_line"]["line"], 2);
  EXPECT_THAT(Read("again.csv"), HasSubstr("# session: again\n"));
  EXPECT_THAT(Read("again.csv"), HasSubstr("# cut_line: line 2 of the log: 'X-392.3406 Y0.0000 Z-81.8'\n"));
}

// What `reduce` makes here, the service makes of the log itself, and keeps it.
TEST_F(Reduce, ALogIsUploadedAsItIs) {
  ASSERT_EQ(Run("machine add" + Example("machine.json")).exit_code, 0);
  const std::string form = "--template" + Example("fig-5.13.template");
  auto outcome = Run("upload" + Example("fig-5.13-touch-log.txt") + form + "--json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json stored = outcome.Json()["sessions"][0];
  EXPECT_EQ(stored["readings"], 21);
  EXPECT_EQ(stored["was_there"], false);
  EXPECT_THAT(stored["notes"].dump(), HasSubstr("announces 40 readings, 21 are there"));
  ASSERT_EQ(Run("program get " + stored["log_program"].dump() + " -o raw.log").exit_code, 0);
  std::stringstream log;
  log << std::ifstream(Source("deploy/examples/integrex/fig-5.13-touch-log.txt"), std::ios::binary).rdbuf();
  EXPECT_EQ(Read("raw.log"), log.str());
  EXPECT_THAT(Run("upload" + Example("fig-5.13-touch-log.txt") + form).out, HasSubstr("was there"));
  Write("wrong.log",
        "X-390.0 Y0.0 Z-464.5 B0.0 C0.0\nX-390.0 Y0.0 Q-464.5 B0.0 C0.0\nX-390.0 Y0.0 Z-464.5 B0.0 C0.0\n");
  outcome = Run("upload wrong.log " + form);
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("wrong.log: line 2, column 14"));
  EXPECT_EQ(Run("upload wrong.log --template dprnt").exit_code, 3);
  EXPECT_THAT(Run("upload wrong.log --template dprnt").err, HasSubstr("expected --machine"));
  EXPECT_EQ(Run("upload wrong.log --template none.txt").exit_code, 4);
  EXPECT_NE(Run("upload wrong.log --plan none.csv").exit_code, 0) << "without a template";
}

TEST_F(Reduce, BadInputChangesNothing) {
  Write("log.txt", "X1.0 Y2.0\nX1.0 Q2.0\nX1.0 Y2.0\n");
  Write("t.txt", "# machine: integrex-i200\nline: X{X_mm} Y{Y_mm}\n");
  auto outcome = Run("reduce log.txt --template t.txt -o s.csv");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("t.txt: line 2: header key session is missing"));
  outcome = Run("reduce log.txt --template nothing.txt -o s.csv");
  EXPECT_EQ(outcome.exit_code, 4);
  EXPECT_THAT(outcome.err, HasSubstr("expected a template or one of dprnt, linuxcnc-probe"));
  EXPECT_EQ(Run("reduce nothing.log --template dprnt -o s.csv").exit_code, 4);
  EXPECT_THAT(Run("reduce log.txt --template dprnt -o s.csv").err, HasSubstr("no header lines"));
  EXPECT_EQ(Run("reduce log.txt --template t.txt -o log.txt").exit_code, 3);
  EXPECT_THAT(Read("log.txt"), HasSubstr("Q2.0"));
  // Touches against the gates: the ball's radius is 1 mm wrong.
  std::stringstream text;
  text << std::ifstream(Source("deploy/examples/integrex/fig-5.13.template")).rdbuf();
  std::string wrong = text.str();
  wrong.replace(wrong.find("-472 5"), 6, "-472 6");
  Write("wrong.txt", wrong);
  outcome = Run("reduce" + Example("fig-5.13-touch-log.txt") + "--template wrong.txt" + Machine() + "-o s.csv");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("lie on a radius of 7.9106 mm, expected 8.9106"));
  EXPECT_FALSE(Exists("s.csv"));
}

// From the plan of measuring rods to the reference, and what is asked for where neither plan nor log holds it.
TEST_F(Reduce, APlanOfReadingsIsFilledByTheLog) {
  ASSERT_EQ(Run("toolsetter plan '" + Source("deploy/examples/fang-tool-setter/tool-setter-aligned.csv") +
                "' --readouts 2 -o rods.csv")
                .exit_code,
            0);
  Write("z.txt", "-376.586\n-376.585\n-349.701\n-349.702\n-330.521\n-330.520\n");
  Write("z.template", "line: {Z_mm}\n");
  const auto reduced = Run("reduce z.txt --template z.template --plan rods.csv -o setter.csv");
  ASSERT_EQ(reduced.exit_code, 0) << reduced.err;
  EXPECT_THAT(Read("setter.csv"), HasSubstr("\nrod,readout,Z_mm\nstandard,1,-376.586\nstandard,2,-376.585\nrod-1,1,"));
  EXPECT_EQ(Run("toolsetter reference setter.csv").exit_code, 0);
  const std::string plan = "plan" + Machine() + "--ball \"40 0 60\" --tool-tip \"0 0 -350\" --travel \"B -30 120\" ";
  ASSERT_EQ(Run(plan + "sphere-B -o sphere.csv").exit_code, 0);
  Write("touch.txt", "X0.0000 Y0.0000 Z0.0000 B0.0000 C0.0000\n");
  EXPECT_THAT(Run("reduce touch.txt --template dprnt --plan sphere.csv -o s.csv").err,
              HasSubstr("expected the fields or --machine"));
  ASSERT_EQ(Run(plan + "ballbar-circle -o circle.csv").exit_code, 0);
  EXPECT_THAT(Run("reduce touch.txt --template dprnt --plan circle.csv" + Machine() + "-o s.csv").err,
              HasSubstr("has no field {dL_mm}, which instrument ballbar reads"));
  EXPECT_FALSE(Exists("s.csv"));
}

}  // namespace
}  // namespace axiscal
