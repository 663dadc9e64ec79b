// The command line without any database: files in, files out, exit codes.
#include <gmock/gmock.h>

#include "tests/cli/command_line.h"

namespace axiscal {
namespace {

using ::testing::HasSubstr;
using testing::Outcome;
using testing::Source;

class FilesOnly : public testing::CommandLine {
 protected:
  FilesOnly() {
    std::filesystem::copy(Source("deploy/examples/integrex/machine.json"), folder_);
    Write("errors.json", R"({"EA0B": -101.2, "EX0C": 53.1})");
    Write("in.nc",
          "%\nO1 (PART)\nN1 G90 G21 G01 X-390.0000 Y0.0000 Z-112.2605 B0.0000 C0.0000 F2000\nN2 X-380. (X "
          "ONLY)\nM30\n%\n");
  }
  Outcome Compensate(const std::string& more) const {
    return Run("compensate --machine machine.json --errors errors.json --dialect fanuc --tool-tip '0 0 -350' " + more);
  }
};

TEST_F(FilesOnly, HelpAndUsageErrors) {
  const Outcome help = Run("--help");
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_THAT(help.out, HasSubstr("Exit codes: 0 done, 1 failed, 2 wrong command line, 3 bad input"));
  EXPECT_EQ(Run("compensate --help").exit_code, 0);
  EXPECT_EQ(Run("").exit_code, 2);
  EXPECT_EQ(Run("compensat").exit_code, 2);
  EXPECT_EQ(Run("compensate in.nc -o out.nc").exit_code, 2);
  EXPECT_EQ(Run("machine show a --revision -1").exit_code, 2);
  EXPECT_THAT(Run("jobs list --state asleep").err, HasSubstr("asleep"));
  EXPECT_EQ(Run("--version").exit_code, 0);
  const Outcome json = Run("compensate in.nc -o out.nc --json");
  EXPECT_EQ(json.exit_code, 2);
  const auto error = nlohmann::json::parse(json.err, nullptr, false);
  ASSERT_TRUE(error.is_object()) << json.err;
  EXPECT_EQ(error["error"]["exit_code"], 2);
  EXPECT_EQ(error["error"]["reason"], "USAGE");
}

// Of two values for one thing the last would win in silence.
TEST_F(FilesOnly, WhatIsStatedTwiceIsRefused) {
  const auto refused = [this](const std::string& options, const std::string& text) {
    const Outcome outcome = Compensate("in.nc -o out.nc " + options);
    EXPECT_EQ(outcome.exit_code, 3) << options;
    EXPECT_THAT(outcome.err, HasSubstr(text)) << options;
  };
  refused("--start 'X=1 X=2'", "--start: X stands twice");
  refused("--offset 'G54 X=1' --offset 'G54 Y=2'", "--offset: G54 stands twice");
  refused("--offset 'G54 X=1 X=2'", "--offset: X stands twice");
  refused("--tool-length H1=10 --tool-length D1=20", "--tool-length: H1 stands twice");
  EXPECT_FALSE(Exists("out.nc"));
}

TEST_F(FilesOnly, ExplainNeedsNoDatabase) {
  const Outcome text = Run("machine explain --file machine.json");
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("X+ moves the tool to +X"));
  EXPECT_THAT(text.out, HasSubstr("its tip swings to -X"));
  const Outcome json = Run("machine explain --file machine.json --json");
  EXPECT_EQ(json.Json()["axes"].size(), 5u);
  EXPECT_EQ(json.Json()["axes"][4]["carries"], "workpiece");
  EXPECT_EQ(Run("machine explain").exit_code, 3);
  EXPECT_FALSE(Exists("axiscal.db"));
}

// The table stands 53.1 um to +X and the tilted tool's tip 35.4 um to -Y: the same numbers that compensate takes off
// the words of this block (below), within the words' rounding.
TEST_F(FilesOnly, ErrorsAreThoseThatCompensateTakesOff) {
  Write("poses.csv", "X_mm,Y_mm,Z_mm,B_deg,C_deg\n-390,0,-112.2605,0,0\n-390,0,-112.2605,0,90\n");
  const Outcome outcome =
      Run("predict --machine machine.json --errors errors.json --tool-tip '0 0 -350' poses.csv -o out.csv --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.Json()["rows"], 2);
  EXPECT_EQ(outcome.Json()["has_sigma"], false);
  EXPECT_EQ(outcome.Json()["notes"][0], "no sigmas: the errors have no covariance");
  EXPECT_THAT(Read("out.csv"), HasSubstr("\n-53.100000,-35.420000,0.00"));
  EXPECT_THAT(Read("out.csv"), HasSubstr("-101.200000,0.000000,0.000000,,,,,,\n"));
  Write("known.json",
        R"({"EA0B": -101.2, "EX0C": 53.1, "covariance": {"of": ["EX0C"], "sigma": [0.5], "correlation": [[]]}})");
  const Outcome known =
      Run("predict --machine machine.json --errors known.json --tool-tip '0 0 -350' poses.csv -o out.csv");
  ASSERT_EQ(known.exit_code, 0) << known.err;
  EXPECT_THAT(known.out, HasSubstr("taken for exact, the covariance does not name them: EA0B"));
  EXPECT_THAT(Read("out.csv"), HasSubstr("-101.200000,0.000000,0.000000,0.500000,0.000000,0.000000,"));
  // Compensation takes the same file.
  EXPECT_EQ(
      Run("compensate --machine machine.json --errors known.json --tool-tip '0 0 -350' in.nc -o out.nc").exit_code, 0);
}

TEST_F(FilesOnly, PredictSaysWhatItWants) {
  Write("poses.csv", "X_mm,Y_mm,Z_mm,B_deg,C_deg\n-390,0,x,0,0\n");
  const auto refused = [this](const std::string& options, const std::string& text) {
    const Outcome outcome = Run("predict --machine machine.json --errors errors.json " + options);
    EXPECT_EQ(outcome.exit_code, 3) << options;
    EXPECT_THAT(outcome.err, HasSubstr(text)) << options;
  };
  refused("--tool-tip '0 0 -350' poses.csv -o out.csv", "poses.csv: line 2, column 3 (Z_mm): 'x' is no number");
  refused("poses.csv -o out.csv", "expected --tool-tip with POSES");
  refused("--tool-tip '0 0 350' poses.csv -o out.csv", "--tool-tip");
  refused("--tool-tip '0 0 -350' -o out.csv", "expected either POSES or --instrument SESSION");
  refused("--tool-tip '0 0 -350' poses.csv -o poses.csv", "--output");
  EXPECT_FALSE(Exists("out.csv"));
}

TEST_F(FilesOnly, AProgramIsRewrittenAndReported) {
  const Outcome outcome = Compensate("in.nc -o out.nc --report report.json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("2 of "));
  const std::string program = Read("out.nc");
  // The table stands 53.1 um to +X; a tool of 350 mm tilted by -101.2 urad about X stands 35.4 um to -Y.
  EXPECT_THAT(program, HasSubstr("\nN1 G90 G21 G01 X-389.9469 Y0.0354 Z-112.2605 B0.0000 C0.0000 F2000\n"));
  EXPECT_THAT(program, HasSubstr("(X ONLY)"));
  EXPECT_NE(program, Read("in.nc"));
  const auto report = nlohmann::json::parse(Read("report.json"), nullptr, false);
  ASSERT_TRUE(report.is_object());
  EXPECT_GT(report["tool_point_error"]["before"]["max_um"], 10.0);
  EXPECT_LT(report["tool_point_error"]["after"]["max_um"], 0.2);  // the words' rounding
  EXPECT_FALSE(Exists("axiscal.db"));
  const Outcome verified =
      Run("verify --machine machine.json --errors errors.json --tool-tip '0 0 -350' in.nc out.nc --json");
  ASSERT_EQ(verified.exit_code, 0) << verified.err;
  EXPECT_NEAR(verified.Json()["end"]["before"]["max_um"].get<double>(),
              report["tool_point_error"]["before"]["max_um"].get<double>(), 1e-6);
  EXPECT_LT(verified.Json()["end"]["after"]["max_um"].get<double>(), 0.2);
  // Once is enough: the mark in the output is seen.
  EXPECT_EQ(
      Run("compensate --machine machine.json --errors errors.json --tool-tip '0 0 -350' out.nc -o twice.nc").exit_code,
      3);
  EXPECT_FALSE(Exists("twice.nc"));
}

// A head that leans about Y (B turns it back) and about X (C turns it back where B is turned, and near B = 0 it
// cannot).
TEST_F(FilesOnly, OrientationIsCorrectedReportedAndVerified) {
  Write("errors.json", R"({"EB0B": 100.0, "EA0B": 20.0})");
  Write("in.nc", "G90 G21 G0 X0. Y0. Z0. B30. C0.\nG1 X10. B60. C150. F500\nC-20.\nB0.\nM30\n");
  const std::string verify =
      "verify --machine machine.json --errors errors.json --dialect fanuc --tool-tip '0 0 -350' in.nc out.nc ";
  ASSERT_EQ(Compensate("in.nc -o out.nc").exit_code, 0);
  const auto point_only = Run(verify + "--json").Json();
  EXPECT_GT(point_only["end_tilt"]["after"]["max_urad"].get<double>(), 90.0);
  EXPECT_EQ(Read("out.nc").find("B29.9943"), std::string::npos);
  // The correction inserts words of rotary axes, and turns them across 0.
  const Outcome asked = Compensate("in.nc -o out.nc --orientation");
  EXPECT_EQ(asked.exit_code, 5);
  EXPECT_THAT(asked.err, HasSubstr("state in machine.json how the axis counts (roll_over)"));
  auto machine = nlohmann::json::parse(Read("machine.json"));
  for (const char* axis : {"B", "C"}) machine["axes"][axis]["roll_over"] = "none";
  Write("machine.json", machine.dump());

  const Outcome outcome = Compensate("in.nc -o out.nc --orientation --report report.json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(Read("out.nc"), HasSubstr("B29.9943 C"));
  EXPECT_THAT(outcome.out, HasSubstr("tool direction error after"));
  EXPECT_THAT(outcome.out,
              HasSubstr("direction not reached in 1 block (no rotary command changes by more than 0.05 deg"));
  EXPECT_THAT(outcome.out, HasSubstr("line 4: B0.  (the tool's direction is 20 urad off: "));
  const auto report = nlohmann::json::parse(Read("report.json"), nullptr, false);
  ASSERT_TRUE(report.is_object());
  EXPECT_EQ(report["orientation"]["not_reached"][0]["line"], 4);
  EXPECT_LT(report["orientation"]["correction"]["B"]["max_urad"], 101.0);

  const Outcome verified = Run(verify + "--orientation --json");
  ASSERT_EQ(verified.exit_code, 0) << verified.err;
  const auto json = verified.Json();
  EXPECT_GT(json["end_tilt"]["before"]["max_urad"].get<double>(), 100.0);
  EXPECT_NEAR(json["end_tilt"]["after"]["max_urad"].get<double>(), 20.0, 1.0);  // of B = 0; a word is 1.7 urad
  EXPECT_LT(json["end"]["after"]["max_um"].get<double>(), 0.1);
  EXPECT_LT(json["path"]["after"]["max_um"].get<double>(), 1.2);
  EXPECT_THAT(Run(verify + "--orientation").out, HasSubstr("tool direction error"));
  // A verification that does not know of it finds rotary words that are not the original's.
  EXPECT_EQ(Run(verify).exit_code, 3);
  EXPECT_EQ(Compensate("in.nc -o out.nc --orientation --max-rotary-correction-deg 9").exit_code, 2);
}

TEST_F(FilesOnly, AProgramWithoutAUnitAsksForIt) {
  Write("in.nc", "G90 G01 X-390.0000 Y0.0000 Z-112.2605 B0.0000 C0.0000 F2000\n");
  const Outcome asked = Compensate("in.nc -o out.nc");
  EXPECT_EQ(asked.exit_code, 5);
  EXPECT_THAT(asked.err, HasSubstr("line 1"));
  EXPECT_THAT(asked.err, HasSubstr("--unit mm or --unit inch"));
  EXPECT_FALSE(Exists("out.nc"));
  ASSERT_EQ(Compensate("in.nc -o out.nc --unit mm").exit_code, 0);
  EXPECT_THAT(Read("out.nc"), HasSubstr("X-389.9469 Y0.0354 Z-112.2605"));
  const std::string verify =
      "verify --machine machine.json --errors errors.json --dialect fanuc --tool-tip '0 0 -350' in.nc out.nc ";
  EXPECT_EQ(Run(verify + "--unit mm").exit_code, 0);
  EXPECT_EQ(Compensate("in.nc -o out.nc --unit cm").exit_code, 2);
}

TEST_F(FilesOnly, MCodesOfTheBuilderAndWaysOfAxesAreStated) {
  Write("in.nc", "G90 G21 G1 X0. Y0. Z0. B0. C350. F500\nM47\nG1 X0. Y0. Z0. B0. C10.\nM120\n");
  const Outcome asked = Compensate("in.nc -o out.nc");
  EXPECT_EQ(asked.exit_code, 5);
  EXPECT_THAT(asked.err, HasSubstr("state --harmless-m 47"));
  const Outcome way = Compensate("in.nc -o out.nc --harmless-m 47,120-129");
  EXPECT_EQ(way.exit_code, 5);
  EXPECT_THAT(way.err, HasSubstr("roll_over"));
  std::string machine = Read("machine.json");
  const std::string point = R"("point_mm": [-490, 0, 0])";
  machine.replace(machine.find(point), point.size(), point + R"(, "roll_over": "shortest")");
  Write("machine.json", machine);
  EXPECT_EQ(Compensate("in.nc -o out.nc --harmless-m 47,120-129").exit_code, 0);
  EXPECT_EQ(Compensate("in.nc -o out.nc --harmless-m 47,x").exit_code, 3);
  EXPECT_EQ(Compensate("in.nc -o out.nc --harmless-m 9-4").exit_code, 3);
  EXPECT_THAT(Compensate("in.nc -o out.nc --harmless-m 98").err, HasSubstr("M98 is known to dialect 'fanuc'"));
}

TEST_F(FilesOnly, NoErrorsGiveTheSameBytes) {
  Write("errors.json", "{}");
  ASSERT_EQ(Compensate("in.nc -o out.nc").exit_code, 0);
  EXPECT_EQ(Read("out.nc"), Read("in.nc"));
}

TEST_F(FilesOnly, WhatIsRefusedWritesNothing) {
  Write("cycle.nc", "G90 G21 G01 X0 Y0 Z0 B0 C0 F100\nG81 X10. Y0. Z-5. R2.\nG80\nM98 P7\n");
  Write("out.nc", "what was there");
  const Outcome cycle = Compensate("cycle.nc -o out.nc --report report.json");
  EXPECT_EQ(cycle.exit_code, 5);
  EXPECT_THAT(cycle.err, HasSubstr("line 2"));
  EXPECT_THAT(cycle.err, HasSubstr("line 4"));
  EXPECT_EQ(Read("out.nc"), "what was there");
  EXPECT_THAT(Read("report.json"), HasSubstr("G81"));
  const Outcome json = Compensate("cycle.nc -o out.nc --json");
  const auto error = nlohmann::json::parse(json.err, nullptr, false);
  EXPECT_EQ(error["error"]["code"], "FAILED_PRECONDITION");
  EXPECT_EQ(error["error"]["exit_code"], 5);
  const Outcome stop = Compensate("cycle.nc -o out.nc --on-unsupported stop");
  EXPECT_EQ(stop.exit_code, 5);
  EXPECT_THAT(stop.err, ::testing::Not(HasSubstr("line 4")));
  EXPECT_EQ(Compensate("cycle.nc -o passed.nc --on-unsupported pass").exit_code, 0);
  EXPECT_TRUE(Exists("passed.nc"));
}

// With pass the reports list the lines that were not corrected, and verify says that it does not judge them.
TEST_F(FilesOnly, WhatIsPassedIsListedByLinesAndNotJudged) {
  Write("passed.nc", "G90 G21 G01 X0 Y0 Z0 B0 C0 F100\nG87 X10. Y0. Z-5. R2.\nX20.\nG80\nG1 X1. Y0. Z0. B0. C0.\n");
  const Outcome passed = Compensate("passed.nc -o out.nc --on-unsupported pass --report report.json");
  ASSERT_EQ(passed.exit_code, 0) << passed.err;
  EXPECT_THAT(passed.out, HasSubstr("not corrected: 1 range of lines\n  lines 2 to 3: G87 (boring cycle from behind, "
                                    "or with a way out by hand: program its moves)\n"));
  const auto report = nlohmann::json::parse(Read("report.json"), nullptr, false);
  EXPECT_EQ(report["ranges_not_corrected"], 1);
  EXPECT_EQ(report["not_corrected"][0]["first"], 2);
  EXPECT_EQ(report["not_corrected"][0]["last"], 3);
  const std::string verify =
      "verify --machine machine.json --errors errors.json --dialect fanuc --tool-tip '0 0 -350' passed.nc out.nc "
      "--on-unsupported pass";
  const Outcome verified = Run(verify);
  EXPECT_EQ(verified.exit_code, 5);
  EXPECT_THAT(verified.out, HasSubstr("not judged: 1 range of lines\n  lines 2 to 3: G87 (boring cycle from behind, or "
                                      "with a way out by hand: program its moves)\n"));
  EXPECT_THAT(verified.err, HasSubstr("not all is judged: 2 blocks are passed as they are"));
  const Outcome json = Run(verify + " --json --report verify.json");
  EXPECT_EQ(json.exit_code, 5);
  EXPECT_EQ(json.Json()["ranges_not_judged"], 1);
  EXPECT_EQ(json.Json()["not_judged"][0]["last"], 3);
  EXPECT_THAT(Read("verify.json"), HasSubstr("not_judged"));
}

TEST_F(FilesOnly, OffsetsAndToolLengthsAreStated) {
  Write("offset.nc", "G90 G21 G55 G43 H2 G01 X0. Y0. Z0. B0. C0. F100\nG54.1 P3 X1. Y0. Z0. B0. C0.\n");
  EXPECT_EQ(Compensate("offset.nc -o out.nc").exit_code, 5);
  const std::string stated = " --offset 'G55=-390 0 -112 0 0' --offset 'G54.1 P3 X=-390 C=10' --tool-length H2=0";
  ASSERT_EQ(Compensate("offset.nc -o out.nc" + stated).exit_code, 0);
  // As in AProgramIsRewrittenAndReported: 53.1 um and 35.4 um.
  EXPECT_THAT(Read("out.nc"), HasSubstr("G90 G21 G55 G43 H2 G01 X0.0531 Y0.0354 Z0. B0. C0. F100\n"));
  // The program's name may follow an option that may be given again.
  ASSERT_EQ(Compensate("-o behind.nc" + stated + " offset.nc").exit_code, 0);
  EXPECT_EQ(Read("behind.nc"), Read("out.nc"));
  EXPECT_EQ(Compensate("offset.nc -o out.nc --offset 'G55=1 2'").exit_code, 3);
  EXPECT_EQ(Compensate("offset.nc -o out.nc --tool-length H2").exit_code, 3);
  EXPECT_EQ(Compensate("offset.nc -o out.nc --tool-length H0=5").exit_code, 3);
}

TEST_F(FilesOnly, NoOutputTakesThePlaceOfWhatTheUserBrought) {
  const std::string program = Read("in.nc"), machine = Read("machine.json"), errors = Read("errors.json");
  Write("axiscal.db", "a database");
  for (const char* outputs :
       {"-o out.nc --report in.nc", "-o out.nc --report ./in.nc", "-o out.nc --report machine.json", "-o machine.json",
        "-o errors.json", "-o out.nc --report errors.json", "-o out.nc --report ./out.nc", "-o axiscal.db"}) {
    const Outcome outcome = Compensate(std::string("in.nc ") + outputs);
    EXPECT_EQ(outcome.exit_code, 3) << outputs;
    EXPECT_THAT(outcome.err, HasSubstr("expected another file for --")) << outputs;
  }
  EXPECT_EQ(Run("verify --machine machine.json --errors errors.json --tool-tip '0 0 -350' in.nc in.nc --report in.nc")
                .exit_code,
            3);
  EXPECT_EQ(Read("in.nc"), program);
  EXPECT_EQ(Read("machine.json"), machine);
  EXPECT_EQ(Read("errors.json"), errors);
  EXPECT_EQ(Read("axiscal.db"), "a database");
  EXPECT_FALSE(Exists("out.nc"));
}

// Nobody writes into these pipes: opening one would wait for ever.
TEST_F(FilesOnly, APipeIsNoProgram) {
  ASSERT_EQ(Run("--version; mkfifo pipe.nc").exit_code, 0);
  for (const char* command :
       {"compensate --machine machine.json --errors errors.json --tool-tip '0 0 -350' pipe.nc -o out.nc",
        "verify --machine machine.json --errors errors.json --tool-tip '0 0 -350' in.nc pipe.nc"}) {
    const Outcome outcome = Run(command);
    EXPECT_EQ(outcome.exit_code, 3) << command;
    EXPECT_THAT(outcome.err, HasSubstr("pipe.nc: is not a file")) << command;
  }
  EXPECT_FALSE(Exists("out.nc"));
}

TEST_F(FilesOnly, AReportThatCannotBeWrittenStopsTheWork) {
  EXPECT_EQ(Compensate("in.nc -o out.nc --report missing/report.json").exit_code, 4);
  EXPECT_EQ(Compensate("in.nc -o out.nc --report .").exit_code, 3);
  EXPECT_FALSE(Exists("out.nc"));
}

TEST_F(FilesOnly, TheLoopWritesPicturesAndSaysWhatToMeasureNext) {
  const std::string loop = "close-loop " + Source("tests/data/loop/case-003");
  const Outcome done = Run(loop + " --plot pictures --report report.json");
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("measure next:"));
  EXPECT_THAT(Read("report.json"), HasSubstr("\"next_measurement\": [\n  {\n   \"effect\": \"EZC:harmonic(2)\""));
  for (const char* picture :
       {"residual-X.svg", "residual-time.svg", "trace-CA.svg", "trace-check-BZ.svg", "ranking.svg"})
    EXPECT_THAT(Read(std::string("pictures/") + picture), HasSubstr("</svg>")) << picture;
  const Outcome refused = Run(loop + " --plot machine.json --report other.json");
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, HasSubstr("--plot machine.json"));
  EXPECT_FALSE(Exists("other.json"));
}

TEST_F(FilesOnly, BadInputIsNamed) {
  EXPECT_EQ(Compensate("missing.nc -o out.nc").exit_code, 4);
  EXPECT_EQ(Compensate(". -o out.nc").exit_code, 3);
  EXPECT_EQ(Compensate("in.nc -o in.nc").exit_code, 3);
  EXPECT_EQ(Compensate("in.nc -o missing/out.nc").exit_code, 4);
  EXPECT_THAT(Compensate("in.nc -o out.nc --start X=a").err, HasSubstr("--start: 'X=a', expected an axis"));
  EXPECT_EQ(Compensate("in.nc -o out.nc --offset 'G54 Q=1'").exit_code, 3);
  EXPECT_EQ(Run("compensate --machine machine.json --errors errors.json --tool-tip '0 0 -350' in.nc -o out.nc "
                "--dialect klingon")
                .exit_code,
            3);
  EXPECT_EQ(Run("compensate --machine machine.json --errors errors.json --tool-tip '0 0' in.nc -o out.nc").exit_code,
            3);
  EXPECT_EQ(Run("compensate --machine nowhere.json --errors errors.json --tool-tip '0 0 0' in.nc -o out.nc").exit_code,
            4);
  Write("errors.json", R"({"EA0Q": 1})");
  const Outcome axis = Compensate("in.nc -o out.nc");
  EXPECT_EQ(axis.exit_code, 3);
  EXPECT_THAT(axis.err, HasSubstr("errors.json: "));
  Write("errors.json", R"({"EA0B": 1, "EA0B": 2})");
  EXPECT_EQ(Compensate("in.nc -o out.nc").exit_code, 3);
  EXPECT_FALSE(Exists("out.nc"));
}

}  // namespace
}  // namespace axiscal
