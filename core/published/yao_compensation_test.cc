// The published compensation on the program of Fig 4.30 (deploy/examples/integrex) beside the exact one.
#include "core/published/yao_compensation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/base/files.h"
#include "core/base/testing/source_path.h"
#include "core/machine/machine_json.h"
#include "core/machine/testing/machines.h"
#include "core/published/comparison.h"

namespace axiscal::published {
namespace {

using ::testing::HasSubstr;

const std::string kFolder = base::SourcePath("/deploy/examples/integrex/");
constexpr char kTable45[] = R"({"EB0B": 116.8886})";  // 24.11 arcsec, the model's sign

machine::Machine Integrex() { return machine::ReadMachineFile(kFolder + "machine.json").value(); }

Program ProgramOf(const std::string& errors, const std::string& nc) {
  Program program;
  program.errors = identify::ReadHeldErrors(errors, Integrex()).value();
  program.tool_tip_mm = {0, 0, -356.3945};
  nc::RewriteOptions options;
  options.unit = nc::ProgramUnit::kMillimetre;
  program.poses = nc::ReadPoses(nc::TextReader(nc), Integrex(), options, kMostPoses).value();
  return program;
}

std::string Fig430() { return base::ReadFile(kFolder + "fig-4.30-original.nc", 1 << 20).value(); }

absl::StatusOr<Comparison> Compare(const std::string& source, const Program& program) {
  return FindSource(source).value()->compare_program(Integrex(), program);
}

std::map<std::string, Row> Rows(const std::string& source, const Program& program) {
  std::map<std::string, Row> rows;
  const auto comparison = Compare(source, program);
  EXPECT_TRUE(comparison.ok()) << comparison.status();
  if (!comparison.ok()) return rows;
  for (const Row& row : comparison->rows) rows[row.quantity] = row;
  return rows;
}

TEST(YaoCompensation, TheRuleLeavesAConstantErrorAndTheCorrectionNone) {
  const auto rows = Rows("yao-compensation", ProgramOf(kTable45, Fig430()));
  ASSERT_EQ(rows.size(), 60u);
  constexpr double kSecondOrderUm = 0.05;
  for (int line = 1; line <= 10; ++line) {
    const auto row = [&](const char* what) { return rows.at(absl::StrCat(what, ", line ", line)); };
    EXPECT_NEAR(row("left in X").published, -54.78, 0.02);
    EXPECT_NEAR(row("left in Z").published, 45.59, 0.02);
    for (const char* what : {"left in X", "left in Y", "left in Z"}) {
      EXPECT_NEAR(row(what).corrected, 0.0, kSecondOrderUm) << what;
      EXPECT_NEAR(row(what).exact, 0.0, 0.01) << what;
    }
  }
  // + b R (cos B, -sin B); the rule by -390 and -112.2605 mm.
  EXPECT_NEAR(rows.at("change of X, line 1").exact, 41.66, 0.01);
  EXPECT_NEAR(rows.at("change of X, line 1").corrected, 41.66, 0.01);
  EXPECT_NEAR(rows.at("change of X, line 1").published, -13.12, 0.01);
  EXPECT_NEAR(rows.at("change of Z, line 1").published, 45.59, 0.01);
  EXPECT_TRUE(std::isnan(rows.at("change of X, line 1").sigma));  // errors.json states none
}

TEST(YaoCompensation, TheExactCorrectionTurnsWithB) {
  const auto rows = Rows("yao-compensation", ProgramOf(kTable45, "G01 X0. Y0. Z0. B0. C0. F100\nB45.\nB90.\n"));
  const std::pair<double, double> expected[] = {{41.66, 0}, {29.46, -29.46}, {0, -41.66}};
  for (int line = 1; line <= 3; ++line) {
    for (const auto& [what, um] :
         {std::pair("change of X", expected[line - 1].first), std::pair("change of Z", expected[line - 1].second)}) {
      const Row& row = rows.at(absl::StrCat(what, ", line ", line));
      EXPECT_NEAR(row.exact, um, 0.01) << row.quantity;
      EXPECT_NEAR(row.corrected, um, 0.01) << row.quantity;
      EXPECT_NEAR(row.published, 0.0, 1e-9) << row.quantity;  // no lever at the machine's origin
    }
  }
}

TEST(YaoCompensation, Equation313CorrectsTwice) {
  const Program program = ProgramOf(kTable45, Fig430());
  const auto once = Rows("yao-compensation", program), twice = Rows("yao-equation-3.13", program);
  for (const char* what : {"change of X, line 1", "change of Z, line 1"})
    EXPECT_NEAR(twice.at(what).published, 2.0 * once.at(what).published, 1e-9);
  EXPECT_NEAR(std::abs(twice.at("left in X, line 1").published - once.at("left in X, line 1").published), 13.1, 0.1);
  EXPECT_NEAR(std::abs(twice.at("left in Z, line 1").published - once.at("left in Z, line 1").published), 45.6, 0.1);
}

// Sigma is that of the error by its lever: 2 urad over 356.3945 mm, along X at B = 0 and along Z at B = 90.
TEST(YaoCompensation, UncertaintyOfTheErrorsReachesTheCorrection) {
  const std::string calibration =
      R"({"machine": "integrex-i200", "model": {"EB0B": 116.8886},
          "report": {"errors": [{"symbol": "EB0B", "sigma": 2.0, "identifiable": true}], "correlation": [[1]]}})";
  const auto rows = Rows("yao-compensation", ProgramOf(calibration, "G01 X-390. Y0. Z-112. B0. C0. F100\nB90.\n"));
  constexpr double kUm = 2e-3 * 356.3945;
  for (const char* what : {"change of", "left in"}) {
    EXPECT_NEAR(rows.at(absl::StrCat(what, " X, line 1")).sigma, kUm, 1e-3);
    EXPECT_NEAR(rows.at(absl::StrCat(what, " Z, line 1")).sigma, 0.0, 1e-3);
    EXPECT_NEAR(rows.at(absl::StrCat(what, " X, line 2")).sigma, 0.0, 1e-3);
    EXPECT_NEAR(rows.at(absl::StrCat(what, " Z, line 2")).sigma, kUm, 1e-3);
  }
  EXPECT_NEAR(rows.at("change of X, line 1").published_sigma, 2e-3 * 112, 1e-3);
  EXPECT_NEAR(rows.at("change of Z, line 1").published_sigma, 2e-3 * 390, 1e-3);
  EXPECT_NEAR(rows.at("left in X, line 1").published_sigma, kUm, 1e-3);  // what is left is as uncertain as the tilt
}

TEST(YaoCompensation, RefusesWhatItIsNotAbout) {
  EXPECT_THAT(std::string(Compare("yao-compensation", ProgramOf(R"({"EX0T": 1})", Fig430())).status().message()),
              HasSubstr("expected EB0B among the errors"));
  const auto compare = FindSource("yao-compensation").value()->compare_program;
  const absl::Status other = compare(machine::testing::TiltingTable(), ProgramOf(kTable45, Fig430())).status();
  EXPECT_THAT(std::string(other.message()), HasSubstr("Yao's formulas are about a machine ZYXB|C"));
}

}  // namespace
}  // namespace axiscal::published
