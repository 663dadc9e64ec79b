// Problems of known truth: four sessions with a constant of their own, three common columns, rows in order of time.
#ifndef AXISCAL_CORE_OBJECTIVE_TESTING_MADE_ROWS_H_
#define AXISCAL_CORE_OBJECTIVE_TESTING_MADE_ROWS_H_

#include <cmath>
#include <random>

#include "core/objective/rows.h"

namespace axiscal::objective {

constexpr int kSessions = 4, kSessionRows = 150, kRows = kSessions * kSessionRows;

inline Eigen::MatrixXd Gaussian(Eigen::Index rows, Eigen::Index columns, std::mt19937* random) {
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(*random); });
}

// y is raw noise of unit variance and no correlation, and so is y whitened, unless `ar1`: then the whitening is that
// of first-order noise, y is still to be set.
inline Rows MakeRows(uint32_t seed, double ar1 = 0.0, double echo = 0.0) {
  std::mt19937 random(seed);
  Rows rows;
  Eigen::ArrayXd correlation = Eigen::ArrayXd::Constant(kRows, ar1), echoes = Eigen::ArrayXd::Constant(kRows, echo);
  for (int s = 0; s < kSessions; ++s) {
    correlation[s * kSessionRows] = echoes[s * kSessionRows] = 0.0;
    rows.stretches.push_back({s * kSessionRows, (s + 1) * kSessionRows, s});
    rows.own_precision.emplace_back(Eigen::VectorXd::Constant(1, 1e-6));
    rows.own_value.emplace_back(Eigen::VectorXd::Zero(1));
  }
  rows.whitening = Whitening(Eigen::ArrayXd::Ones(kRows), correlation, echoes);
  rows.own = Eigen::MatrixXd::Ones(kRows, 1);
  rows.common = Gaussian(kRows, 3, &random);
  rows.common_precision = Eigen::VectorXd::Zero(3);
  rows.whitening.Apply(0, rows.own);
  rows.y = Gaussian(kRows, 1, &random);
  std::vector<int> chunks(kRows);
  constexpr int kChunk = 15;
  for (int i = 0; i < kRows; ++i) chunks[i] = i / kChunk;
  rows.clusterings = {chunks};
  return rows;
}

// cos and sin of the orders 1 .. `orders`, side by side, over a position that sweeps each session once.
inline Eigen::MatrixXd Harmonics(int orders) {
  Eigen::MatrixXd columns(kRows, 2 * orders);
  for (int i = 0; i < kRows; ++i) {
    const double q = 2.0 * M_PI * (i % kSessionRows) / kSessionRows;
    for (int n = 1; n <= orders; ++n) {
      columns(i, 2 * n - 2) = std::cos(n * q);
      columns(i, 2 * n - 1) = std::sin(n * q);
    }
  }
  return columns;
}

}  // namespace axiscal::objective

#endif  // AXISCAL_CORE_OBJECTIVE_TESTING_MADE_ROWS_H_
