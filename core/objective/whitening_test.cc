#include "core/objective/whitening.h"

#include <gtest/gtest.h>

namespace axiscal::objective {
namespace {

TEST(Whitening, UndoIsTheInverseOfApply) {
  constexpr int kRows = 40, kSecondSeries = 25;
  for (const double echo : {0.0, 0.3}) {
    Eigen::ArrayXd weight = Eigen::ArrayXd::LinSpaced(kRows, 0.5, 3.0);
    Eigen::ArrayXd correlation = Eigen::ArrayXd::Constant(kRows, 0.7), echoes = Eigen::ArrayXd::Constant(kRows, echo);
    for (const int first : {0, kSecondSeries}) correlation[first] = echoes[first] = 0.0;
    const Whitening whitening(weight, correlation, echoes);
    const Eigen::MatrixXd raw = Eigen::MatrixXd::Random(kRows, 3);
    Eigen::MatrixXd columns = raw;
    whitening.Apply(0, columns);
    EXPECT_GT((columns - raw).norm(), 1.0);
    whitening.Undo(0, columns);
    EXPECT_TRUE(columns.isApprox(raw, 1e-12));
    Eigen::MatrixXd second = raw.bottomRows(kRows - kSecondSeries);
    whitening.Apply(kSecondSeries, second);
    whitening.Undo(kSecondSeries, second);
    EXPECT_TRUE(second.isApprox(raw.bottomRows(kRows - kSecondSeries), 1e-12));
  }
}

}  // namespace
}  // namespace axiscal::objective
