// axiscal identify: stages that hold what an earlier one found, errors of any shape, and what is refused.
#include <gmock/gmock.h>

#include <cmath>

#include "tests/cli/command_line.h"

namespace axiscal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::Outcome;
using testing::Source;

// The swivel head with a table of deploy/examples/liu-blocks.
class IdentifyCommand : public testing::CommandLine {
 protected:
  void SetUp() override {
    std::filesystem::copy(Source("deploy/examples/liu-blocks/swivel-head"), folder_);
    ASSERT_EQ(Run("machine add machine.json").exit_code, 0);
    ASSERT_EQ(Run("upload head.csv table.csv").exit_code, 0);
  }
  static nlohmann::json ErrorOf(const nlohmann::json& calibration, const std::string& symbol) {
    for (const auto& estimate : calibration["estimates"]) {
      if (estimate["symbol"] == symbol) return estimate;
    }
    ADD_FAILURE() << symbol;
    return {};
  }
  static constexpr char kHead[] = "identify --machine rtttr-bc --sessions head --declare EX0B,EY0B,EA0B,EB0B,EC0B";
};

TEST_F(IdentifyCommand, HeadFirstThenTable) {
  const Outcome head = Run(std::string(kHead) + " --json");
  ASSERT_EQ(head.exit_code, 0) << head.err;
  Write("head.json", head.out);
  const std::string table = "identify --machine rtttr-bc --sessions table";
  const Outcome alone = Run(table + " --json --residuals residuals.csv");
  EXPECT_THAT(Read("residuals.csv"), HasSubstr("\nfit,table,1,"));
  EXPECT_TRUE(ErrorOf(alone.Json(), "EX0C")["value"].is_null()) << alone.out;
  const Outcome by_id = Run(table + " --hold 1 --json"),
                by_file = Run(table + " --hold head.json --json --residuals held.csv");
  EXPECT_THAT(Read("held.csv"), HasSubstr("\nfit,table,1,"));
  ASSERT_EQ(by_id.exit_code, 0) << by_id.err;
  ASSERT_EQ(by_file.exit_code, 0) << by_file.err;
  const auto truth = nlohmann::json::parse(Read("truth.json"), nullptr, false);
  for (const std::string symbol : {"EX0C", "EY0C", "EA0C", "EB0C"}) {
    const auto found = ErrorOf(by_id.Json(), symbol);
    EXPECT_EQ(found, ErrorOf(by_file.Json(), symbol));
    EXPECT_NEAR(found["value"].get<double>(), truth[symbol].get<double>(), 4 * found["sigma"].get<double>()) << symbol;
  }
  // The calibration is of the whole machine, and says what it held.
  EXPECT_TRUE(by_id.Json()["model"].contains("EX0B")) << by_id.out;
  EXPECT_TRUE(by_id.Json()["model"].contains("EX0C"));
  EXPECT_EQ(by_id.Json()["report"]["held"]["errors"].size(), 5u);
  EXPECT_EQ(by_id.Json()["options"]["held"]["calibration"], 1);

  // Values alone say nothing of their uncertainty: it is smaller then, and said to be.
  Write("errors.json", head.Json()["model"].dump());
  const Outcome bare = Run(table + " --hold errors.json --json");
  EXPECT_LT(ErrorOf(bare.Json(), "EX0C")["sigma"].get<double>(), ErrorOf(by_id.Json(), "EX0C")["sigma"].get<double>());
  const Outcome bare_text = Run(table + " --hold errors.json"), text = Run(table + " --hold 1");
  EXPECT_THAT(bare_text.out, HasSubstr("is not known: every sigma holds for exactly these values"));
  EXPECT_THAT(text.out, HasSubstr("is part of every sigma"));
  EXPECT_THAT(text.out, Not(HasSubstr("not known")));
}

TEST_F(IdentifyCommand, WhyItWasApprovedIsThereToRead) {
  ASSERT_EQ(Run(kHead).exit_code, 0);
  ASSERT_EQ(Run("approve 1 --reason 'a check by the ball bar agrees'").exit_code, 0);
  ASSERT_EQ(Run("calibration retire 1 --reason 'the head was changed'").exit_code, 0);
  const Outcome shown = Run("calibration show 1");
  EXPECT_THAT(shown.out, ::testing::ContainsRegex("retired [0-9-]+.* by .*: the head was changed\n"
                                                  "approved [0-9-]+.* by .*: a check by the ball bar agrees\n"));
  const nlohmann::json decisions = Run("calibration show 1 --json").Json()["decisions"];
  ASSERT_EQ(decisions.size(), 2u);
  EXPECT_EQ(decisions[1]["state"], "approved");
  EXPECT_EQ(decisions[1]["reason"], "a check by the ball bar agrees");
  EXPECT_THAT(Run("calibration show one").err, HasSubstr("'one', expected a number above 0"));
}

TEST_F(IdentifyCommand, CountsNoSessionTwice) {
  std::string copy = Read("table.csv");
  const size_t name = copy.find("# session: table");
  ASSERT_NE(name, std::string::npos);
  Write("copy.csv", copy.replace(name, 16, "# session: again"));
  ASSERT_EQ(Run("upload copy.csv").exit_code, 0);
  const Outcome twice = Run("identify --machine rtttr-bc --sessions table,again --declare EX0C,EY0C");
  EXPECT_NE(twice.exit_code, 0);
  EXPECT_THAT(twice.err, HasSubstr("holds the same readings as session"));
  EXPECT_THAT(twice.err, HasSubstr("they would count twice"));
}

TEST_F(IdentifyCommand, RefusesWhatCannotBeHeld) {
  ASSERT_EQ(Run(kHead).exit_code, 0);
  ASSERT_EQ(Run("identify --machine rtttr-bc --sessions table").exit_code, 0);  // 2: cannot tell EX0B from EX0C
  const std::string table = "identify --machine rtttr-bc --sessions table";
  const auto refused = [&](const std::string& arguments, int exit_code, const std::string& message) {
    const Outcome outcome = Run(table + arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << arguments << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(message)) << arguments;
  };
  refused(" --hold 2", 3, "has no value of its own");
  refused(" --hold 9", 4, "9");
  refused(" --hold 0", 3, "held_calibration_id");
  refused(" --hold missing.json", 4, "missing.json");
  refused(" --hold 1 --declare EX0B,EX0C", 3, "EX0B is held and asked for too");
  refused(" --hold-only EX0B", 3, "expected --hold with it");
  refused(" --hold 1 --hold-only EX0C", 3, "EX0C is no constant error of what is held");
  refused(" --hold 1 --hold-only wobble", 3, "wobble");
  refused(" --hold 2 --hold-only EX0B", 3, "EX0B has no value of its own");
  Write("bad.json", "{\"EX0B\": 1,}");
  refused(" --hold bad.json", 3, "bad.json: line 1");
  Write("empty.json", "");
  refused(" --hold empty.json", 3, "empty.json: is empty");
  Write("axis.json", R"({"EX0Q": 1})");
  refused(" --hold axis.json", 3, "EX0Q");
  EXPECT_EQ(Run("calibration show 3").exit_code, 4);  // nothing of all this was kept
}

// What a calibration can tell may be held although it cannot tell the rest.
TEST_F(IdentifyCommand, HoldsOnlySomeErrors) {
  ASSERT_EQ(Run("identify --machine rtttr-bc --sessions table").exit_code, 0);  // EA0C and EB0C alone have a number
  const Outcome head =
      Run("identify --machine rtttr-bc --sessions head --declare EX0B,EY0B --hold 1 --hold-only EA0C,EB0C --json");
  ASSERT_EQ(head.exit_code, 0) << head.err;
  EXPECT_EQ(head.Json()["report"]["held"]["errors"].size(), 2u);
  EXPECT_EQ(head.Json()["model"].size(), 5u);  // four errors and their covariance
  EXPECT_TRUE(head.Json()["model"].contains("covariance"));
  EXPECT_FALSE(head.Json()["report"]["held"]["errors"][0]["sigma"].is_null());
}

// Terms of errors.json on the command line: commas inside them separate nothing.
TEST_F(IdentifyCommand, DeclaresTermsOfAnyShape) {
  const Outcome outcome = Run(R"(identify --machine rtttr-bc --sessions head --json )"
                              R"(--declare 'EB0B,{"symbol": "EXX", "shape": "linear"},EA0B')");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  ASSERT_EQ(outcome.Json()["estimates"].size(), 3u) << outcome.out;
  EXPECT_EQ(outcome.Json()["estimates"][1]["symbol"], "EXX:linear/m");
  const Outcome wavy =
      Run(R"(identify --machine rtttr-bc --sessions head --declare 'EB0B,{"symbol": "EXX", "shape": "wavy"}')");
  EXPECT_EQ(wavy.exit_code, 3);
  EXPECT_THAT(wavy.err, HasSubstr("wavy"));
  const Outcome empty = Run("identify --machine rtttr-bc --sessions head --declare EB0B,,EA0B");
  EXPECT_EQ(empty.exit_code, 3) << empty.err;
}

TEST_F(IdentifyCommand, RefusesABadModelFile) {
  const auto refused = [&](const std::string& text, const std::string& message) {
    Write("model.json", text);
    const Outcome outcome = Run("identify --machine rtttr-bc --sessions head --model model.json");
    EXPECT_EQ(outcome.exit_code, 3) << text << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(message)) << text;
  };
  refused("[]", "model.json: expected an object");
  refused("{", "model.json: line 1");
  refused("{}", "model.json: no error in it");
  refused(R"({"EX0Q": 0})", "EX0Q");
  refused(R"({"EX0B": 0, "EX0B": 0})", "'EX0B' is there twice");
  refused(R"({"terms": {}})", "model.json: terms: expected an array");
  refused(R"({"terms": [7]})", "model.json: terms: expected objects");
  refused(R"({"terms": [{"symbol": "EBB", "shape": "wavy"}]})", "wavy");
  EXPECT_EQ(Run("identify --machine rtttr-bc --sessions head --model missing.json").exit_code, 4);
  EXPECT_EQ(Run("calibration show 1").exit_code, 4);
}

}  // namespace
}  // namespace axiscal
