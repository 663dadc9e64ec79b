#include "core/identify/residuals_csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "core/identify/reduction.h"
#include "core/identify/testing/scenario.h"
#include "core/machine/testing/machines.h"

namespace axiscal::identify {
namespace {

using ::testing::HasSubstr;

const machine::Machine kMachine = machine::testing::MultiTasking();

std::vector<std::vector<std::string>> Rows(const std::string& csv) {
  std::vector<std::vector<std::string>> rows;
  for (const absl::string_view line : absl::StrSplit(csv, '\n', absl::SkipEmpty()))
    rows.push_back(absl::StrSplit(line, ','));
  return rows;
}

double Number(const std::string& text) {
  double number = std::nan("");
  EXPECT_TRUE(absl::SimpleAtod(text, &number)) << text;
  return number;
}

// Correlated noise too: what is new in each reading is what counts.
TEST(ResidualsCsv, TheSquaresAddUpToTheChiSquareOfTheReport) {
  const auto truth = testing::Errors(kMachine, R"({"EA0B": 40, "EX0C": -22})");
  for (const double ar1 : {0.0, 0.8}) {
    auto sessions = testing::Measure(kMachine, truth, {});
    double wander = 0.0;
    for (session::Session& session : sessions) {
      session::Column& readings = session.columns.back();
      for (size_t k = 0; k < readings.values.size(); ++k) {
        wander = ar1 * wander + (ar1 > 0.0 ? 2e-4 * std::sin(37.0 * static_cast<double>(k * k)) : 0.0);
        readings.values[k] += wander;
      }
    }
    sessions[1].columns.back().values[20] += 0.5;  // a chip
    const auto fit = FitSessions(kMachine, sessions, {});
    ASSERT_TRUE(fit.ok()) << fit.status();
    EXPECT_EQ(fit->problem.noise[0].ar1 > 0.0, ar1 > 0.0);
    const auto rows = Rows(ResidualsCsv("fit", *fit));
    double squares = 0.0;
    size_t aside = 0, readings = 0;
    for (const session::Session& session : sessions) readings += session.reading_count();
    ASSERT_EQ(rows.size(), readings);
    for (const auto& row : rows) {
      ASSERT_EQ(row.size(), 9u);
      EXPECT_EQ(row[0], "fit");
      if (!row[8].empty()) {
        ++aside;
        EXPECT_EQ(row[8], "stands out of its series");
        EXPECT_EQ(row[6], "0");
        EXPECT_EQ(row[7], "");
        ASSERT_FALSE(fit->result.outliers.empty());
        EXPECT_EQ(row[1], fit->result.outliers[aside - 1].session);
        EXPECT_EQ(row[2], std::to_string(fit->result.outliers[aside - 1].row));
        continue;
      }
      squares += std::pow(Number(row[7]), 2);
      // Where neighbours do not correlate, whitened^2 = weight residual^2.
      if (ar1 > 0.0) continue;
      const double square = std::pow(Number(row[7]), 2);
      EXPECT_NEAR(square, Number(row[6]) * std::pow(Number(row[5]), 2), 1e-4 * (0.01 + square));
    }
    EXPECT_EQ(aside, fit->result.outliers.size());
    EXPECT_GE(aside, 1u);
    const double chi2 = fit->result.fit.chi2_per_dof * fit->result.fit.degrees_of_freedom;
    EXPECT_NEAR(squares + JudgingPriorSquares(fit->problem, fit->point), chi2, 1e-6 * chi2);
  }
}

TEST(ResidualsCsv, PredictionMinusReadingIsTheResidual) {
  auto sessions = testing::Measure(kMachine, testing::Errors(kMachine, R"({"EA0B": 40})"), {});
  sessions[0].header[1].value = "night, \"late\"";
  ASSERT_EQ(sessions[0].header[1].key, "session");
  const auto fit = FitSessions(kMachine, {sessions[0], sessions[1]}, {});
  ASSERT_TRUE(fit.ok()) << fit.status();
  const std::string csv = ResidualsCsv("check", *fit);
  EXPECT_THAT(csv, ::testing::StartsWith("check,\"night, \"\"late\"\"\",1,dL_mm,"));
  const auto rows = Rows(csv);
  const auto& last = rows.back();
  EXPECT_EQ(last[2], std::to_string(sessions[1].reading_count()));
  EXPECT_NEAR(Number(last[4]) - sessions[1].columns.back().values.back(), Number(last[5]) * 1e-3, 2e-9);
  EXPECT_EQ(ResidualsCsvHeader(),
            "part,session,row,reading,predicted_mm,residual_um,weight_per_um2,whitened,set_aside\n");
}

}  // namespace
}  // namespace axiscal::identify
