// The main job through the command line on an embedded database, on the INTEGREX example files: what ./deploy/demo
// shows, with its exit codes.
#include <gmock/gmock.h>

#include <cmath>

#include "tests/cli/command_line.h"

namespace axiscal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::Outcome;
using testing::Source;

constexpr char kMachine[] = "integrex-i200";

class MainJob : public testing::CommandLine {
 protected:
  void SetUp() override {
    std::filesystem::copy(Source("deploy/examples/integrex"), folder_);
    ASSERT_EQ(Run("machine add machine.json").exit_code, 0);
  }
  nlohmann::json Identify(const std::string& declared,
                          const std::string& sessions = "B-short-run1,B-long-run1,B-short-run2,B-long-run2") const {
    const Outcome outcome =
        Run("identify --machine integrex-i200 --json --sessions " + sessions + " --declare " + declared);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.Json();
  }
};

TEST_F(MainJob, TheLadderOfTableFiveTwo) {
  ASSERT_EQ(Run("upload *.csv").exit_code, 0);
  // Yao 2022, Table 5.2; rms of the 24 numbers of the B set-ups, um, 1 %.
  const auto length = Identify("EZ0T");
  EXPECT_NEAR(length["report"]["nominal"]["rms_um"].get<double>(), 1840, 18.4);
  EXPECT_NEAR(length["rms_before_um"].get<double>(), 1299, 13);
  EXPECT_NEAR(length["rms_after_um"].get<double>(), 19.6, 0.2);
  EXPECT_NEAR(Identify("EZ0T,EX0T")["rms_after_um"].get<double>(), 12.2, 0.13);
  const auto tilts = Identify("EZ0T,EX0T,EA0B,EC0B");
  EXPECT_NEAR(tilts["rms_after_um"].get<double>(), 2.97, 0.03);
  // With two poses of B only their sum shows: no number for either.
  for (const auto& estimate : tilts["estimates"]) {
    const std::string symbol = estimate["symbol"];
    const bool is_tilt = symbol == "EA0B" || symbol == "EC0B";
    EXPECT_EQ(estimate["identifiable"].get<bool>(), !is_tilt) << symbol;
    EXPECT_EQ(estimate["value"].is_null(), is_tilt) << symbol;
  }
}

// A machine is measured again under the same session names: each measurement keeps a set-up of its own.
TEST_F(MainJob, SessionsOfOneNameAreIdentifiedTogether) {
  const std::string folder = Source("tests/data/loop/case-000");
  const Outcome upload = Run("upload --json " + folder);
  ASSERT_EQ(upload.exit_code, 0) << upload.err;
  EXPECT_EQ(upload.Json()["sessions"].size(), 5u);  // check/ stays where it is
  ASSERT_EQ(Run("upload " + folder + "/check/01-BX.csv").exit_code, 0);
  const Outcome identify = Run("identify --machine mt --all --json");
  ASSERT_EQ(identify.exit_code, 0) << identify.err;
  EXPECT_LT(identify.Json()["rms_after_um"].get<double>(), 0.31);
  EXPECT_THAT(identify.out, HasSubstr("BX#"));
}

// A poor fit says so where it would be approved.
TEST_F(MainJob, APoorFitIsShownWithAWarning) {
  ASSERT_EQ(Run("upload " + Source("tests/data/loop/case-003")).exit_code, 0);
  const Outcome poor = Run("identify --machine mt --all");
  EXPECT_EQ(poor.exit_code, 0) << poor.err;
  EXPECT_THAT(poor.out, HasSubstr("warning: the readings scatter by"));
}

// Named sources of error through the whole identification; the same seed is the same report, whatever runs it.
TEST_F(MainJob, MonteCarloOverABudget) {
  ASSERT_EQ(Run("upload " + Source("tests/data/loop/case-000")).exit_code, 0);
  Write("budget.json", R"({"axiscal": "budget/1", "sources": [
      {"name": "C angle", "symbol": "EC0C", "half_width": 50, "drawn": "reading"},
      {"name": "tilt of the spindle", "symbol": "EA0B", "half_width": 30, "drawn": "run"}]})");
  const std::string command = "identify --machine mt --all --budget budget.json --monte-carlo 100 --seed 3";
  const Outcome text = Run(command);
  ASSERT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("Monte Carlo, 100 runs, seed 3:"));
  const auto first = Run(command + " --json").Json()["report"]["monte_carlo"];
  ASSERT_FALSE(first["errors"].empty());
  for (const auto& error : first["errors"]) {
    EXPECT_LT(error["low"].get<double>(), error["high"].get<double>());
    // The tilt goes into EA0B whole: 30 um over root 3, far beyond the readings' noise.
    if (error["name"] == "EA0B") {
      EXPECT_NEAR(error["sigma"].get<double>(), 30.0 / std::sqrt(3.0), 4.0);
    }
  }
  EXPECT_EQ(first, Run(command + " --json").Json()["report"]["monte_carlo"]);
  EXPECT_NE(first, Run(command + "3 --json").Json()["report"]["monte_carlo"]);

  const Outcome alone = Run("identify --machine mt --all --seed 3");
  EXPECT_EQ(alone.exit_code, 3);
  EXPECT_THAT(alone.err, HasSubstr("--seed: expected --monte-carlo with it"));
  EXPECT_NE(Run("identify --machine mt --all --monte-carlo 0").exit_code, 0);
  Write("bad.json",
        R"({"axiscal": "budget/1", "sources": [{"name": "a", "symbol": "EC0Q", "sigma": 1, "drawn": "run"}]})");
  const Outcome bad = Run("identify --machine mt --all --budget bad.json");
  EXPECT_EQ(bad.exit_code, 3);
  EXPECT_THAT(bad.err, HasSubstr("sources[0]: errors: terms[0]: machine 'mt' has no axis Q"));
}

TEST_F(MainJob, FromUploadToTheRewrittenProgram) {
  const Outcome upload = Run("upload . --json");
  ASSERT_EQ(upload.exit_code, 0) << upload.err;
  EXPECT_EQ(upload.Json()["sessions"].size(), 9u);
  const Outcome again = Run("upload B-short-run1.csv --json");
  EXPECT_TRUE(again.Json()["sessions"][0]["was_there"].get<bool>());
  EXPECT_EQ(Run("session list --json").Json()["sessions"].size(), 9u);

  const std::string compensate =
      "compensate --machine integrex-i200 --dialect mazak --unit mm --tool-tip '0 0 -356.3945' fig-4.30-original.nc "
      "-o out.nc ";
  EXPECT_EQ(Run(compensate).exit_code, 5);  // nothing approved yet
  const std::string id = Identify("EZ0T,EX0T,EA0B,EC0B")["id"].dump();
  EXPECT_EQ(Run("approve " + id + " --etag 99").exit_code, 5);  // it changed meanwhile
  ASSERT_EQ(Run("approve " + id).exit_code, 0);
  EXPECT_EQ(Run("calibration show --approved integrex-i200 --json").Json()["state"], "approved");

  EXPECT_EQ(Run(compensate).exit_code, 5);  // 3 mm is above the default limit
  EXPECT_FALSE(Exists("out.nc"));
  // In one stream nothing stays; as a job the same bytes are stored.
  const Outcome streamed = Run(compensate + "--max-correction-um 5000 --report report.json --json");
  ASSERT_EQ(streamed.exit_code, 0) << streamed.err;
  const std::string program = Read("out.nc");
  EXPECT_FALSE(streamed.Json().contains("job"));
  EXPECT_EQ(Run("program list --json").Json()["programs"].size(), 0u) << "nothing is stored";
  EXPECT_EQ(nlohmann::json::parse(Read("report.json")), streamed.Json());
  const Outcome done = Run(compensate + "--max-correction-um 5000 --keep --json");
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_EQ(done.Json()["blocks"]["corrected"], 10);
  EXPECT_GT(done.Json()["tool_point_error"]["before"]["max_um"], 3000.0);
  EXPECT_LT(done.Json()["tool_point_error"]["after"]["max_um"], 0.2);
  EXPECT_EQ(Read("out.nc"), program);
  EXPECT_EQ(Run("program get " + done.Json()["program"].dump() + " -o again.nc").exit_code, 0);
  EXPECT_EQ(Read("again.nc"), program);

  EXPECT_EQ(Run("history --machine integrex-i200 --symbols EZ0T --json").Json()["series"][0]["points"].size(), 1u);
  EXPECT_EQ(Run("history --fleet --json").Json()["machines"].size(), 1u);
  const Outcome drift = Run("drift --machine integrex-i200 --limit EZ0T=-10..10");
  EXPECT_EQ(drift.exit_code, 0) << drift.err;
  EXPECT_THAT(drift.out, AllOf(HasSubstr("1 of 1 calibrations count\n"), HasSubstr("nothing to tell"),
                               HasSubstr("no forecast: ")));
  EXPECT_EQ(Run("drift --machine integrex-i200 --json").Json()["counted"].size(), 1u);
  EXPECT_EQ(Run("jobs list --state succeeded --json").Json()["jobs"].size(), 2u);
  EXPECT_EQ(Run("jobs watch 1").exit_code, 0);
}

TEST_F(MainJob, ABadFileStoresNothing) {
  Write("bad.csv", Read("B-long-run1.csv") + "99,90,0,-493.2,0.03,nan\n");
  const Outcome upload = Run("upload B-short-run1.csv bad.csv");
  EXPECT_EQ(upload.exit_code, 3);
  EXPECT_THAT(upload.err, HasSubstr("bad.csv: line 13, column 6 (cz_mm): 'nan', expected mm"));
  EXPECT_EQ(Run("session list --json").Json()["sessions"].size(), 0u);
  Write("empty.csv", "");
  EXPECT_EQ(Run("upload empty.csv").exit_code, 3);
  EXPECT_EQ(Run("upload missing.csv").exit_code, 4);
  EXPECT_EQ(Run("upload B-short-run1.csv --machine other").exit_code, 3);
  Write("other.csv", "# machine: other\n" + Read("B-short-run1.csv").substr(Read("B-short-run1.csv").find('\n') + 1));
  EXPECT_EQ(Run("upload other.csv").exit_code, 4);
  EXPECT_EQ(Run("session list --json").Json()["sessions"].size(), 0u);
}

TEST_F(MainJob, EveryFailureHasItsExitCode) {
  EXPECT_EQ(Run("machine add machine.json").exit_code, 0);  // the same again
  std::string changed = Read("machine.json");
  changed.replace(changed.find("-490"), 4, "-491");
  Write("changed.json", changed);
  EXPECT_EQ(Run("machine add changed.json").exit_code, 5);
  EXPECT_EQ(Run("machine update changed.json").exit_code, 0);
  EXPECT_THAT(Run("machine show integrex-i200").out, HasSubstr("-491"));
  EXPECT_THAT(Run("machine show integrex-i200 --revision 1").out, HasSubstr("-490"));
  EXPECT_THAT(Run("machine list").out, HasSubstr(kMachine));
  Write("bad.json", "{");
  EXPECT_EQ(Run("machine add bad.json").exit_code, 3);
  EXPECT_EQ(Run("machine show nobody").exit_code, 4);
  EXPECT_EQ(Run("identify --machine integrex-i200 --all").exit_code, 4);
  EXPECT_EQ(Run("identify --machine integrex-i200 --sessions nothing").exit_code, 4);
  EXPECT_EQ(Run("identify --machine integrex-i200").exit_code, 3);
  EXPECT_EQ(Run("approve 77").exit_code, 4);
  EXPECT_EQ(Run("jobs cancel 77").exit_code, 4);
  EXPECT_EQ(Run("program get 77 -o p.nc").exit_code, 4);
  EXPECT_FALSE(Exists("p.nc"));
  for (const char* command : {"program get 77 -o ./axiscal.db", "session get 77 -o axiscal.db"}) {
    const Outcome outcome = Run(command);
    EXPECT_EQ(outcome.exit_code, 3) << command;
    EXPECT_THAT(outcome.err, HasSubstr("is the database too")) << command;
  }
  EXPECT_EQ(Run("history --machine integrex-i200 --from yesterday").exit_code, 3);
  EXPECT_EQ(Run("drift --machine nobody").exit_code, 4);
  for (const char* limit : {"EX0C", "EX0C=5..5", "EX0C=5..", "=1..2", "EX0C=a..b"}) {
    const Outcome outcome = Run(std::string("drift --machine integrex-i200 --limit ") + limit);
    EXPECT_EQ(outcome.exit_code, 3) << limit;
    EXPECT_THAT(outcome.err, HasSubstr("expected ERROR=LOW..HIGH")) << limit;
  }
  const Outcome error = Run("machine show nobody --json");
  EXPECT_EQ(nlohmann::json::parse(error.err, nullptr, false)["error"]["exit_code"], 4);
  EXPECT_EQ(Run("--server 127.0.0.1:1 machine list").exit_code, 6);
}

}  // namespace
}  // namespace axiscal
