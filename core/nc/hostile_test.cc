// Programs that break readers, in tests/data/nc: NAME.nc as it is, NAME.txt with its dialect, what it is run with and
// what must come out: each block that refuses it with its reason, and the bytes of the output with --on-unsupported
// pass. The machine is testing::LeaningHead: at B = 0 X needs 0.0417 mm more, at B = 90 Z 0.0417 mm less.
//
// After a change that is meant: AXISCAL_ACCEPT=1 nc_test --gtest_filter='Hostile*' rewrites the NAME.txt; read them
// all.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "core/base/testing/source_path.h"
#include "core/base/units.h"
#include "core/nc/testing/rewritten.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

namespace fs = std::filesystem;

const fs::path kFolder = fs::path(base::SourcePath("")) / "tests/data/nc";

std::string ReadAll(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file.good()) << path;
  return std::string(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
}

std::vector<fs::path> Programs() {
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(kFolder)) {
    if (entry.path().extension() == ".nc") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

// The first line of NAME.txt: "fanuc split offsets".
RewriteOptions OptionsOf(const std::string& line) {
  std::istringstream words(line);
  RewriteOptions options = testing::InMm();
  words >> options.dialect;
  options.tolerance_mm = std::numeric_limits<double>::infinity();
  for (std::string word; words >> word;) {
    if (word == "clamps") options.harmless_m = {107, 108};
    if (word == "unstated") options.unit = ProgramUnit::kUnstated;
    if (word == "inch") options.unit = ProgramUnit::kInch;
    if (word == "split") options.tolerance_mm = 0.005;
    if (word == "fine") options.tolerance_mm = 0.001;
    if (word == "increments") options.integer_words = IntegerWords::kLeastIncrement;
    if (word == "tools") options.tool_lengths = {{1, 10.0}, {5, 10.0}};
    if (word == "offsets") {
      options.work_offsets = {
          {"G54", {}}, {"G55", {{"X", 100.0}, {"B", 10 * base::kRadPerDeg}}}, {"G54.1 P5", {{"X", 5.0}}}};
    }
    if (word == "turning") options.orientation = true;
  }
  return options;
}

std::string Findings(const std::vector<Finding>& findings) {
  std::string text;
  for (const Finding& finding : findings) absl::StrAppend(&text, "  ", finding.line, ": ", finding.reason, "\n");
  return text;
}

std::string Outcome(const std::string& head, const std::string& program) {
  RewriteOptions options = OptionsOf(head);
  RewriteReport refused, passed;
  const auto all = RewriteText(program, testing::LeaningHead(), options, &refused);
  options.on_unsupported = OnUnsupported::kPass;
  const auto text = RewriteText(program, testing::LeaningHead(), options, &passed);
  std::string outcome = head + "\n";
  absl::StrAppend(&outcome, "refused: ", refused.blocks_refused, " blocks\n", Findings(refused.refused));
  absl::StrAppend(&outcome, "never touched, or left for an unknown position:\n", Findings(refused.passed));
  if (all.ok()) outcome += "not refused\n";
  if (!text.ok()) return absl::StrCat(outcome, "refused with pass: ", std::string(text.status().message()), "\n");
  if (!all.ok()) {
    absl::StrAppend(&outcome, "passed: ", passed.blocks_passed, " blocks, corrected ", passed.blocks_corrected, "\n",
                    Findings(passed.passed));
  }
  for (const std::string& note : TextsOf(passed.notes)) absl::StrAppend(&outcome, "note: ", note, "\n");
  return outcome + "output:\n" + *text;
}

TEST(Hostile, EveryProgramComesOutAsWrittenDown) {
  const bool accepts = std::getenv("AXISCAL_ACCEPT") != nullptr;
  const std::vector<fs::path> programs = Programs();
  ASSERT_GE(programs.size(), 110u);
  for (const fs::path& path : programs) {
    const std::string program = ReadAll(path);
    fs::path expected_path = path;
    expected_path.replace_extension(".txt");
    const std::string expected = ReadAll(expected_path);
    const std::string head = expected.substr(0, expected.find('\n'));
    const std::string found = Outcome(head, program);
    EXPECT_EQ(found, expected) << path;
    if (accepts) std::ofstream(expected_path, std::ios::binary) << found;
  }
}

TEST(Hostile, ANullCorrectionReturnsTheBytesInEveryDialect) {
  for (const fs::path& path : Programs()) {
    const std::string program = ReadAll(path);
    for (const Dialect& dialect : Dialects()) {
      for (const auto mode : {OnUnsupported::kRefuse, OnUnsupported::kPass, OnUnsupported::kStop}) {
        RewriteOptions options = testing::InMm();
        options.dialect = dialect.name;
        options.on_unsupported = mode;
        RewriteReport report;
        const auto text = RewriteText(program, testing::PerfectMachine(), options, &report);
        ASSERT_TRUE(text.ok()) << path << text.status();
        EXPECT_EQ(*text, program) << path;
      }
    }
  }
}

// Whatever dialect it is read in, with and without rotary corrections: no crash, and where both texts can be followed
// the tool point is right.
TEST(Hostile, WhatIsWrittenIsRightInEveryDialect) {
  int64_t moves = 0;
  for (const fs::path& path : Programs()) {
    const std::string program = ReadAll(path);
    for (const Dialect& dialect : Dialects()) {
      for (const bool orientation : {false, true}) {
        RewriteOptions options = testing::kAtZero;
        options.dialect = dialect.name;
        options.tolerance_mm = 0.005;
        options.orientation = orientation;
        options.on_unsupported = OnUnsupported::kPass;
        RewriteReport report;
        const auto text = RewriteText(program, testing::LeaningHead(), options, &report);
        if (!text.ok()) continue;
        VerifyOptions verify;
        verify.reading.unit = ProgramUnit::kMillimetre;
        verify.tool_tip_mm = {0, 0, -testing::kToolMm};
        verify.reading = options;
        const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
        const auto verified = VerifyText(program, *text, machine,
                                         testing::ConstantErrors(machine, {{"EB0B", testing::kTiltRad}}), verify);
        if (!verified.ok() || report.blocks_passed > 0) continue;
        moves += verified->moves;
        EXPECT_LT(verified->end_after.max_mm, 0.0002) << path << ' ' << dialect.name << '\n' << *text;
      }
    }
  }
  EXPECT_GT(moves, 200);
}

}  // namespace
}  // namespace axiscal::nc
