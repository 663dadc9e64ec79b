// The loop from files, in the process on a database, and on a server: one report. Then what a technician does with it.
#include <gmock/gmock.h>

#include "tests/cli/command_line.h"
#include "tests/end_to_end/testing/process.h"

namespace axiscal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::Outcome;
using testing::ServerProcess;
using testing::Source;

class CloseLoop : public testing::CommandLine {
 protected:
  // Stores a case's sessions, the fit's as 1 to 5, then the check's.
  void Store(const std::string& name, const std::string& global = "") const {
    const std::string folder = Source("tests/data/loop/" + name);
    for (const std::string& upload : {folder, folder + "/check/*.csv"}) {
      const Outcome outcome = Run(global + "upload " + upload);
      ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    }
  }
  static std::string Job(const std::string& more = "") {
    return "close-loop --machine mt --fit 1,2,3,4,5 --check 6,7,8,9 " + more;
  }
};

TEST_F(CloseLoop, FilesDatabaseAndServerGiveOneReport) {
  const Outcome files =
      Run("close-loop " + Source("tests/data/loop/case-003") + " --report files.json" +
          " --errors files-errors.json --residuals residuals.csv");
  ASSERT_EQ(files.exit_code, 0) << files.err;
  EXPECT_THAT(files.out, HasSubstr("EXX:backlash"));
  const std::string residuals = Read("residuals.csv");
  EXPECT_THAT(residuals, ::testing::StartsWith("part,session,row,reading,predicted_mm,residual_um,weight_per_um2,"
                                               "whitened,set_aside\nfit,"));
  EXPECT_THAT(residuals, HasSubstr("\ncheck,"));
  // The errors come with their covariance, and predict has sigmas.
  Write("poses.csv", "t_s,X_mm,Y_mm,Z_mm,B_deg,C_deg,temp_C\n0,100,0,300,10,20,20\n");
  const Outcome predicted = Run("predict --machine " + Source("tests/data/loop/case-003/machine.json") +
                                " --errors files-errors.json --tool-tip '0 0 -350' poses.csv -o predicted.csv --json");
  ASSERT_EQ(predicted.exit_code, 0) << predicted.err;
  EXPECT_EQ(predicted.Json()["has_sigma"], true);

  Store("case-003");
  const Outcome embedded = Run(Job("--report embedded.json --errors embedded-errors.json"));
  ASSERT_EQ(embedded.exit_code, 0) << embedded.err;

  const auto server = ServerProcess::Start((folder_ / "server.db").string(), "127.0.0.1:0", (folder_ / "log").string());
  ASSERT_TRUE(server.ok()) << server.status();
  const std::string global = "--server " + server->address() + " ";
  Store("case-003", global);
  const Outcome served = Run(global + Job("--report served.json --errors served-errors.json"));
  ASSERT_EQ(served.exit_code, 0) << served.err;

  const std::string report = Read("files.json");
  ASSERT_FALSE(report.empty());
  EXPECT_EQ(Read("embedded.json"), report);
  EXPECT_EQ(Read("served.json"), report);
  EXPECT_EQ(Read("embedded-errors.json"), Read("files-errors.json"));
  EXPECT_EQ(Read("served-errors.json"), Read("files-errors.json"));
  EXPECT_EQ(embedded.out, files.out);
  EXPECT_EQ(served.out, files.out);
}

// What the service refuses of uploads and jobs, files do not get past.
TEST_F(CloseLoop, FilesThatProveNothingAreRefused) {
  const auto refused = [&](const char* folder, const char* text) {
    const Outcome outcome = Run(std::string("close-loop ") + folder + " --report report.json");
    EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(text));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "report.json"));
  };
  const std::filesystem::path source(Source("tests/data/loop/case-003"));
  const auto copy = [&](const char* folder) {
    std::filesystem::copy(source, folder_ / folder, std::filesystem::copy_options::recursive);
    return folder_ / folder;
  };
  const std::filesystem::path leak = copy("leak");
  std::filesystem::copy_file(leak / "fit/01-BY.csv", leak / "check/09-BY.csv");
  refused("leak", "check session 'BY' holds the same readings as fit session 'BY'");

  const std::filesystem::path turned = copy("turned");
  std::string session = Read("turned/check/02-CR.csv");
  const size_t tip = session.find("# tool_tip_mm: 0 0 -");
  ASSERT_NE(tip, std::string::npos);
  Write("turned/check/02-CR.csv", session.erase(tip + 19, 1));
  refused("turned", "turned/check/02-CR.csv: session 'CR': tool tip 0 0 ");
  refused("turned", "on the other side than tool_direction 0 0 -1 of machine mt points to");
}

// The simulation of `identify`, over the model that the loop ended with: the same in a folder and as a job.
TEST_F(CloseLoop, MonteCarloOverTheExtendedModel) {
  Write("budget.json", R"({"axiscal": "budget/1", "sources": [
      {"name": "squareness of Y", "symbol": "EC0Y", "sigma": 10, "drawn": "session", "sessions": ["BX", "CR"]}]})");
  const std::string simulated = "--monte-carlo 60 --budget budget.json --seed 5 ";
  const std::string folder = Source("tests/data/loop/case-003");
  const Outcome files = Run("close-loop " + folder + " " + simulated + "--report files.json");
  ASSERT_EQ(files.exit_code, 0) << files.err;
  EXPECT_THAT(files.out, HasSubstr("Monte Carlo, 60 runs, seed 5:"));
  Store("case-003");
  ASSERT_EQ(Run(Job(simulated + "--report job.json")).exit_code, 0);
  EXPECT_EQ(Read("job.json"), Read("files.json"));
  const auto report = nlohmann::json::parse(Read("files.json"));
  EXPECT_EQ(report["budget"]["sources"].size(), 1u);
  bool has_effect = false;
  for (const auto& error : report["monte_carlo"]["errors"]) {
    if (error["name"] == "EXX:backlash") {  // no set-up's prior, which the simulation leaves where it is, holds it
      has_effect = true;
      EXPECT_GE(error["sigma"], 0.7 * error["linear_sigma"].get<double>()) << error;
    }
    EXPECT_LT(std::abs(error["mean"].get<double>() - error["value"].get<double>()), 1.0 * error["sigma"].get<double>())
        << error;
  }
  EXPECT_TRUE(has_effect);
  // The simulation changes nothing of the loop's own report.
  ASSERT_EQ(Run("close-loop " + folder + " --report plain.json").exit_code, 0);
  auto without = report;
  without.erase("budget");
  without.erase("monte_carlo");
  EXPECT_EQ(without, nlohmann::json::parse(Read("plain.json")));

  Write("unknown.json", R"({"axiscal": "budget/1", "sources": [
      {"name": "a", "symbol": "EC0Y", "sigma": 10, "drawn": "session", "sessions": ["nobody"]}]})");
  const auto refused = [&](const std::string& arguments, const std::string& text) {
    const Outcome outcome = Run("close-loop " + arguments);
    EXPECT_EQ(outcome.exit_code, 3) << arguments << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(text)) << arguments;
  };
  refused(folder + " --monte-carlo 10 --budget unknown.json", "nobody");
  refused(folder + " --seed 3", "--seed: expected --monte-carlo with it");
  refused(folder + " --budget budget.json", "--budget: expected --monte-carlo with it");
  Write("bad.json",
        R"({"axiscal": "budget/1", "sources": [{"name": "a", "symbol": "EC0Q", "sigma": 1, "drawn": "run"}]})");
  refused(folder + " --monte-carlo 10 --budget bad.json", "has no axis Q");
  refused("--machine mt --fit 1 --monte-carlo 10 --budget bad.json", "params.close_loop.budget_json");
  EXPECT_EQ(Run("close-loop " + folder + " --monte-carlo 0").exit_code, 2);
}

TEST_F(CloseLoop, TheCandidateHoldsItsProvenanceAndCompensationUsesItOnceApproved) {
  Store("case-003");
  const Outcome loop = Run(Job("--json"));
  ASSERT_EQ(loop.exit_code, 0) << loop.err;
  EXPECT_EQ(loop.Json()["verdict"], "extended");
  const Outcome shown = Run("calibration show 1 --json");
  const auto calibration = shown.Json();
  EXPECT_EQ(calibration["state"], "candidate");
  EXPECT_EQ(calibration["machine_revision"], 1);
  EXPECT_EQ(calibration["sessions"].size(), 5u);
  ASSERT_EQ(calibration["options"]["check"].size(), 4u);
  EXPECT_EQ(calibration["options"]["check"][0]["session"], "BZ");
  EXPECT_EQ(calibration["options"]["fit"][0]["hash"].get<std::string>().size(), 64u);
  EXPECT_FALSE(calibration["options"].contains("max_effects"));  // nobody capped it
  EXPECT_FALSE(calibration["engine_version"].get<std::string>().empty());
  EXPECT_EQ(calibration["report"]["steps"].size(), loop.Json()["steps"].size());
  EXPECT_THAT(Run("calibration show 1").out, HasSubstr("verdict: the model was extended"));

  ASSERT_EQ(Run("approve 1").exit_code, 0);
  // The same place reached in both senses: backlash of X is taken out by the sense of the motion.
  Write("in.nc",
        "%\nG90 G21\nN1 G01 X-10.0000 Y0.0000 Z0.0000 B0.0000 C0.0000 F2000\nN2 X0.0000\nN3 X10.0000\nN4 "
        "X0.0000\nM30\n%\n");
  const Outcome done = Run("compensate --machine mt --tool-tip '0 0 -350' in.nc -o out.nc --json");
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_LT(done.Json()["tool_point_error"]["after"]["max_um"], 0.2);
  EXPECT_THAT(done.Json()["notes"].dump(), HasSubstr("harmonic(2) from "));
  const std::string out = Read("out.nc");
  // Where a block ends: its last piece, the lost motion taken up before.
  const auto word = [&out](const std::string& block, const std::string& next) {
    const size_t end = out.find(next), at = out.rfind('X', end);
    return out.find(block) < at && at < end ? std::stod(out.substr(at + 1)) : std::nan("");
  };
  EXPECT_NEAR(std::abs(word("N2", "N3") - word("N4", "M30")) * 1e3, 2.9, 0.15) << out;
}

TEST_F(CloseLoop, StructureWithoutANameIsSaidWhereItIsApproved) {
  Store("case-004");
  const Outcome loop = Run("close-loop --machine tt --fit 1,2,3,4,5,6,7,8 --check 9,10,11,12,13,14,15 --json");
  ASSERT_EQ(loop.exit_code, 0) << loop.err;
  ASSERT_EQ(loop.Json()["verdict"], "unexplained");
  EXPECT_THAT(Run("calibration show 1").out, HasSubstr("unexplained:"));
  const Outcome approved = Run("approve 1");
  EXPECT_EQ(approved.exit_code, 0) << approved.err;
  EXPECT_THAT(approved.out, HasSubstr("unexplained:"));
}

TEST_F(CloseLoop, WhatCannotBeUsedIsNotApproved) {
  std::string machine;
  {
    std::stringstream text;
    text << std::ifstream(Source("tests/data/loop/case-000/machine.json")).rdbuf();
    machine = text.str();
  }
  const size_t declared = machine.find("\"declared\"");
  ASSERT_NE(declared, std::string::npos);
  const size_t open = machine.find('[', declared), close = machine.find(']', declared);
  machine.replace(open, close - open + 1, "[]");
  Write("machine.json", machine);
  ASSERT_EQ(Run("machine add machine.json").exit_code, 0);
  ASSERT_EQ(Run("upload " + Source("tests/data/loop/case-000/fit/00-BX.csv")).exit_code, 0);
  ASSERT_EQ(Run("identify --machine mt --all").exit_code, 0);
  const Outcome empty = Run("approve 1");
  EXPECT_EQ(empty.exit_code, 5);
  EXPECT_THAT(empty.err, HasSubstr("calibration 1 holds no error: nothing was declared"));

  ASSERT_EQ(Run("identify --machine mt --all --declare EZ0T").exit_code, 0);
  const size_t direction = machine.find('1', machine.find("\"direction\""));
  ASSERT_NE(direction, std::string::npos);
  Write("turned.json", std::string(machine).replace(direction, 1, "-1"));
  ASSERT_EQ(Run("machine update turned.json").exit_code, 0);
  const Outcome outdated = Run("approve 2");
  EXPECT_EQ(outdated.exit_code, 5);
  EXPECT_THAT(outdated.err, HasSubstr("were changed since calibration 2"));
  ASSERT_EQ(Run("machine update machine.json").exit_code, 0);
  EXPECT_EQ(Run("approve 2").exit_code, 0);
}

TEST_F(CloseLoop, BadInputIsNamed) {
  Store("case-000");
  const auto refused = [this](const std::string& arguments, int exit_code, const std::string& text) {
    const Outcome outcome = Run("close-loop " + arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << arguments << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(text)) << arguments;
  };
  refused("", 3, "either a case folder or --machine");
  refused(". --machine mt --fit 1", 3, "either a case folder or --machine");
  refused(". --fit 1", 3, "need --machine");
  refused("--machine mt", 3, "expected --fit");
  refused("--machine mt --fit 1,1", 3, "1 stands twice");
  refused("--machine mt --fit 1,2 --check 2", 3, "a session that was fitted proves nothing");
  refused("--machine mt --fit BX --check 6", 3, "2 sessions of machine mt are called 'BX'");
  refused("--machine mt --fit 1 --check nothing", 4, "--check: machine mt has no complete session 'nothing'");
  refused("--machine mt --fit 99", 4, "99");
  refused("--machine nobody --fit 1", 4, "nobody");
  refused("--machine mt --fit 1 --max-effects 0", 2, "max-effects");
  refused("--machine mt --fit 1 --report axiscal.db", 3, "expected another file for --report");
  refused("--machine mt --fit 1 --no-wait --report r.json", 3, "nothing yet for --report");
  refused("--machine mt --fit 1 --plot pictures", 3, "--plot needs a case folder");
  EXPECT_EQ(Run("jobs list --json").Json()["jobs"].size(), 0u);
}

// What the user brought is never replaced.
TEST_F(CloseLoop, TheCasesOwnFilesAreNotOverwritten) {
  std::filesystem::copy(Source("tests/data/loop/case-000"), folder_ / "case", std::filesystem::copy_options::recursive);
  for (const char* file : {"machine.json", "fit/00-BX.csv", "check/00-BZ.csv"}) {
    const std::string name = std::string("case/") + file, before = Read(name);
    ASSERT_FALSE(before.empty()) << name;
    for (const char* option : {" --report ", " --errors "}) {
      const Outcome outcome = Run("close-loop case" + (option + name));
      EXPECT_EQ(outcome.exit_code, 3) << option << name;
      EXPECT_THAT(outcome.err, HasSubstr("expected another file for --"));
    }
    EXPECT_EQ(Read(name), before);
  }
}

// From no declared error: what the thesis' ladder needed hands for (1299 -> 19.6 -> 12.2 -> 2.97 um).
TEST_F(CloseLoop, MeasuredSphereCentresLeadToTheToolLengthAndTheTilts) {
  std::filesystem::copy(Source("deploy/examples/integrex"), folder_);
  ASSERT_EQ(Run("machine add machine.json").exit_code, 0);
  ASSERT_EQ(Run("upload B-*.csv").exit_code, 0);
  const Outcome loop =
      Run("close-loop --machine integrex-i200 --fit B-short-run1,B-long-run1,B-short-run2,B-long-run2 --json");
  ASSERT_EQ(loop.exit_code, 0) << loop.err;
  const auto report = loop.Json();
  EXPECT_NEAR(report["fit"]["before"]["rms_um"].get<double>(), 1299, 13);
  ASSERT_GE(report["steps"].size(), 3u);
  EXPECT_EQ(report["steps"][0]["name"], "EZ0T");
  EXPECT_NEAR(report["steps"][0]["rms_um"].get<double>(), 19.6, 0.2);
  EXPECT_LT(report["fit"]["after"]["rms_um"].get<double>(), 3.3);
  // With B's location error EB0B, which these sessions do not tell from the squareness, it is 3182.5 um.
  EXPECT_NEAR(report["effects"][0]["amplitude"].get<double>(), 3145.0, 5.0);
  EXPECT_EQ(report["effects"][1]["symbol"], "EB0X");
  EXPECT_NE(report["effects"][1]["equivalent"].dump().find("EB0B"), std::string::npos);
}

}  // namespace
}  // namespace axiscal
