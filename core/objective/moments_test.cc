#include "core/objective/moments.h"

#include <gtest/gtest.h>

#include "core/objective/testing/dense_source.h"
#include "core/objective/testing/made_rows.h"

namespace axiscal::objective {
namespace {

constexpr double kTolerance = 1e-7;  // what the noise is said to have forgotten (1e-9), summed over rows

// Products and Gram matrices are those of the columns written out.
void ExpectAsDense(const Source& source, const Whitening& whitening) {
  Eigen::MatrixXd columns(kRows, source.column_count());
  Eigen::Index at = 0;
  for (size_t g = 0; g < source.groups().size(); ++g) {
    const Eigen::MatrixXd its = source.Columns(static_cast<int>(g));
    columns.middleCols(at, its.cols()) = its;
    at += its.cols();
  }
  const DenseSource dense(columns, source.groups());
  std::mt19937 random(6);
  const Eigen::MatrixXd u = Gaussian(kRows, 2, &random);
  const std::vector<std::pair<int, int>> ranges = {{0, kRows}, {kSessionRows, 2 * kSessionRows}};
  for (const auto& [begin, end] : ranges) {
    Eigen::MatrixXd products = Eigen::MatrixXd::Ones(columns.cols(), 2), expected = products;
    source.AddProducts(begin, u.middleRows(begin, end - begin), products);
    dense.AddProducts(begin, u.middleRows(begin, end - begin), expected);
    EXPECT_LT((products - expected).cwiseAbs().maxCoeff(), kTolerance);
  }
  const std::vector<Eigen::MatrixXd> grams = source.Grams(whitening), expected = dense.Grams(whitening);
  ASSERT_EQ(grams.size(), expected.size());
  for (size_t g = 0; g < grams.size(); ++g) EXPECT_LT((grams[g] - expected[g]).cwiseAbs().maxCoeff(), kTolerance) << g;
}

TEST(Moments, RunningSumsGiveWhatTheColumnsWrittenOutGive) {
  for (const auto& [ar1, echo] : std::vector<std::pair<double, double>>{{0.0, 0.0}, {0.7, 0.0}, {0.8, 0.4}}) {
    const Rows rows = MakeRows(7, ar1, echo);
    std::mt19937 random(8);
    // Two series of one session that is read in two rows; moments close to each other, to the start and to the end.
    std::vector<Slips::Series> series = {{kSessionRows, 2 * kSessionRows, {}},
                                         {2 * kSessionRows, 3 * kSessionRows, {}}};
    for (Slips::Series& one : series) {
      for (const int moment : {1, 2, 70, 71, kSessionRows - 1, kSessionRows}) one.first.push_back(one.begin + moment);
    }
    Group model;
    model.precision = Eigen::VectorXd::Constant(3, 1.0);
    ExpectAsDense(Slips(kRows, series, Gaussian(2 * kSessionRows, 3, &random), model), rows.whitening);
    Group row;
    ExpectAsDense(SingleRows(kRows, {0, 5, kSessionRows - 1, kSessionRows, 400, kRows - 1}, row), rows.whitening);
  }
}

}  // namespace
}  // namespace axiscal::objective
