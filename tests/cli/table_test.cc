// axiscal table from files: no database, files in and out, exit codes.
#include <gmock/gmock.h>

#include "tests/cli/command_line.h"
#include "tests/end_to_end/testing/process.h"

namespace axiscal {
namespace {

using ::testing::HasSubstr;
using testing::Outcome;
using testing::Source;
using ::testing::StartsWith;

class Tables : public testing::CommandLine {
 protected:
  Tables() {
    std::filesystem::copy(Source("deploy/examples/integrex/machine.json"), folder_);
    Write("errors.json", R"({"terms": [{"symbol": "EXX", "shape": "linear", "amplitude": 10},
                                       {"symbol": "EXX", "shape": "backlash", "amplitude": 4}]})");
  }
  Outcome Make(const std::string& more) const {
    return Run("table --machine machine.json --errors errors.json --range X=-300:300 " + more);
  }
};

TEST_F(Tables, TheListNeedsNothing) {
  const Outcome text = Run("table --list");
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("linuxcnc-comp\n"));
  EXPECT_THAT(text.out, HasSubstr("256 points anywhere, by sense of motion"));
  EXPECT_THAT(text.out, HasSubstr("; assumed: the layout of the data lines"));
  const Outcome json = Run("table --list --json");
  ASSERT_TRUE(json.Json().is_object()) << json.out;
  EXPECT_EQ(json.Json()["formats"][0]["name"], "general");
  EXPECT_FALSE(Exists("axiscal.db"));
}

TEST_F(Tables, ATableIsWrittenWithItsReport) {
  const Outcome outcome = Make("--format linuxcnc-comp --axis X -o x.comp --report x.json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("along the axes, with the table"));
  EXPECT_THAT(Read("x.comp"), StartsWith("-300.0000 0.00100 0.00500\n300.0000 -0.00500 -0.00100\n"));
  EXPECT_THAT(Read("x.comp"), HasSubstr("calibration errors.json"));
  const auto report = nlohmann::json::parse(Read("x.json"), nullptr, false);
  EXPECT_EQ(report["format"], "linuxcnc-comp");
  EXPECT_EQ(Make("--format linuxcnc-comp --axis X -o y.comp --json").Json(), report);
  EXPECT_EQ(Read("y.comp"), Read("x.comp"));
  EXPECT_FALSE(Exists("axiscal.db"));
}

TEST_F(Tables, WhatIsWrongIsNamedAndNothingIsWritten) {
  const auto refused = [this](const std::string& options, int exit_code, const std::string& text) {
    const Outcome outcome = Make(options + " -o x.comp");
    EXPECT_EQ(outcome.exit_code, exit_code) << options;
    EXPECT_THAT(outcome.err, HasSubstr(text)) << options;
    EXPECT_FALSE(Exists("x.comp")) << options;
  };
  refused("", 2, "--format");
  refused("--format fanuk", 3, "format 'fanuk', expected one of general, linuxcnc-comp");
  refused("--format linuxcnc-comp --axis Q", 3, "axis 'Q'");
  refused("--format linuxcnc-comp --axis Y", 3, "axis Y has none");
  refused("--format linuxcnc-comp --range Y=0", 3, "--range: 'Y=0', expected an axis of machine");
  refused("--format linuxcnc-comp --range Y=0:x", 3, "--range: 'Y=0:x'");
  refused("--format linuxcnc-comp --range X=0:5", 3, "range: X stands twice");
  refused("--format linuxcnc-comp --reference X=0:5", 3, "--reference: 'X=0:5'");
  refused("--format linuxcnc-comp --tool-tip '1 2'", 3, "--tool-tip: '1 2'");
  refused("--format linuxcnc-comp --points 300", 3, "points = 300");
  refused("--format linuxcnc-comp --report errors.json", 3, "errors.json: is --errors too");
  EXPECT_EQ(Make("--format linuxcnc-comp -o machine.json").exit_code, 3);
  EXPECT_EQ(Make("--format linuxcnc-comp -o no/such/x.comp").exit_code, 4);
  EXPECT_EQ(Run("table").exit_code, 2);
}

// What the loop found on stored sessions, approved, as a table: embedded and over the wire the same bytes.
TEST_F(Tables, AnApprovedLoopBecomesATableOnEveryWay) {
  const std::string folder = Source("tests/data/loop/case-003");
  ASSERT_EQ(Run("upload " + folder).exit_code, 0);
  const Outcome none = Run("table --machine mt --format linuxcnc-comp -o x.comp --json");
  EXPECT_EQ(none.exit_code, 5);
  EXPECT_THAT(none.err, HasSubstr("CALIBRATION_NOT_APPROVED"));
  ASSERT_EQ(Run("close-loop --machine mt --fit BX,BY,CR,CA,CR-long").exit_code, 0);
  ASSERT_EQ(Run("approve 1").exit_code, 0);

  const Outcome embedded = Run("table --machine mt --format linuxcnc-comp --axis X -o x.comp --report x.json");
  ASSERT_EQ(embedded.exit_code, 0) << embedded.err;
  EXPECT_THAT(embedded.out, HasSubstr("note: ranges that nobody stated are what the calibration's sessions covered: "));
  EXPECT_THAT(Read("x.comp"), HasSubstr("machine mt, calibration mt v1"));
  const auto report = nlohmann::json::parse(Read("x.json"), nullptr, false);
  ASSERT_TRUE(report.is_object());
  // EXX:backlash of -2.92 um: half of it by sense.
  EXPECT_NEAR(report["tables"][0]["largest"].get<double>(), 1.46, 0.1);
  EXPECT_TRUE(report["tables"][0]["by_sense"].get<bool>());
  EXPECT_THAT(report["not_carried"].dump(), HasSubstr("EZC:harmonic(2)"));

  // Every format, before a server holds the file.
  const auto ours = Run("table --list --json").Json()["formats"];
  ASSERT_GE(ours.size(), 5u);
  const auto make = [](const auto& format, const std::string& file) {
    return "table --machine mt --format " + format["name"].template get<std::string>() + " -o " + file;
  };
  std::vector<int> exit_codes;
  for (size_t i = 0; i < ours.size(); ++i)
    exit_codes.push_back(Run(make(ours[i], absl::StrCat("here", i, ".txt"))).exit_code);

  const auto server = testing::ServerProcess::Start((folder_ / "axiscal.db").string(), "127.0.0.1:0",
                                                    (folder_ / "server.log").string());
  ASSERT_TRUE(server.ok()) << server.status();
  const std::string at = "--server " + server->address() + " ";
  const Outcome remote = Run(at + "table --machine mt --format linuxcnc-comp --axis X -o y.comp --report y.json");
  ASSERT_EQ(remote.exit_code, 0) << remote.err;
  EXPECT_EQ(Read("y.comp"), Read("x.comp"));
  EXPECT_EQ(Read("y.json"), Read("x.json"));

  // The list is the server's: one that is not there has none.
  EXPECT_EQ(Run(at + "table --list").out, Run("table --list").out);
  const auto theirs = Run(at + "table --list --json").Json()["formats"];
  ASSERT_EQ(theirs.size(), ours.size());
  for (size_t i = 0; i < ours.size(); ++i) {
    EXPECT_EQ(theirs[i]["name"], ours[i]["name"]);
    EXPECT_EQ(theirs[i]["limits"]["max_points"], ours[i]["limits"]["max_points"]) << ours[i]["name"];
  }
  EXPECT_EQ(Run("--server 127.0.0.1:1 table --list").exit_code, 6);

  const auto refused = [&](const std::string& options, int exit_code, const std::string& reason) {
    const Outcome outcome = Run(at + "table --machine mt -o z.comp --json " + options);
    EXPECT_EQ(outcome.exit_code, exit_code) << options;
    EXPECT_THAT(outcome.err, HasSubstr("\"reason\": \"" + reason + "\"")) << options;
    EXPECT_FALSE(Exists("z.comp"));
  };
  refused("--format fanuk", 3, "TABLE_INVALID");
  refused("--format linuxcnc-comp --axis X --points 999", 3, "TABLE_INVALID");
  refused("--format linuxcnc-comp --calibration 99", 4, "CALIBRATION_NOT_FOUND");
  EXPECT_EQ(Run(at + "table --machine nobody --format general -o z.comp").exit_code, 4);

  // Every format, written or refused alike.
  for (size_t i = 0; i < ours.size(); ++i) {
    const Outcome there = Run(at + make(ours[i], "there.txt"));
    EXPECT_EQ(exit_codes[i], there.exit_code) << ours[i]["name"] << there.err;
    if (exit_codes[i] == 0) {
      EXPECT_EQ(Read(absl::StrCat("here", i, ".txt")), Read("there.txt")) << ours[i]["name"];
    }
  }
}

}  // namespace
}  // namespace axiscal
