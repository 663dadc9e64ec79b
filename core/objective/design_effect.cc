#include "core/objective/design_effect.h"

#include <algorithm>
#include <map>
#include <random>
#include <set>

namespace axiscal::objective {
namespace {

double QuantileOf(Eigen::VectorXf values, double share) {
  if (values.size() == 0) return 1.0;
  const auto at =
      std::min<Eigen::Index>(values.size() - 1, static_cast<Eigen::Index>(share * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[at];
}

}  // namespace

DesignEffect::DesignEffect(const Scorer& scorer) : scorer_(scorer) {
  for (const std::vector<int>& clusters : scorer.rows().clusterings) {
    Clustering& one = clusterings_.emplace_back();
    for (size_t i = 0; i < clusters.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      if (i == 0 || clusters[i] != clusters[i - 1]) one.stays.push_back({row, row, clusters[i]});
      one.stays.back().end = row + 1;
      one.count = std::max(one.count, clusters[i] + 1);
    }
    // Those that hold rows: of a few readings most blocks of time are empty.
    one.held = static_cast<int>(std::set<int>(clusters.begin(), clusters.end()).size());
  }
  std::map<int, std::vector<int>> of_family;
  for (int g = 0; g < scorer.group_count(); ++g)
    if (scorer.IsVisible(g)) of_family[scorer.group(g).family].push_back(g);
  // Of very many rows each column says more, and fewer are held.
  constexpr double kMostValues = 2e7;
  constexpr size_t kFewestColumns = 3;
  const auto held =
      static_cast<size_t>(kMostValues / (1.0 + static_cast<double>(of_family.size()) * scorer.rows().count()));
  const size_t wanted = std::min(static_cast<size_t>(scorer.policy().design_columns), std::max(kFewestColumns, held));
  std::mt19937 random(scorer.policy().seed);
  std::vector<int> drawn;
  for (auto& [family, groups] : of_family) {
    // The first of a shuffle, by a rule that is the same in every library.
    for (size_t k = 0; k < groups.size() && k < wanted; ++k) {
      std::swap(groups[k], groups[k + random() % (groups.size() - k)]);
      drawn.push_back(groups[k]);
    }
  }
  columns_.resize(scorer.rows().count(), static_cast<Eigen::Index>(drawn.size()));
  for (size_t k = 0; k < drawn.size(); ++k) {
    const Eigen::MatrixXd columns = scorer.Projected(drawn[k]);
    const auto which = static_cast<Eigen::Index>(random() % static_cast<unsigned>(columns.cols()));
    columns_.col(static_cast<Eigen::Index>(k)) = columns.col(which).cast<float>();
  }
}

Eigen::VectorXf DesignEffect::EffectsOf(const Eigen::MatrixXf& columns, const Eigen::VectorXf& residual,
                                        double variance, const Clustering& clustering) const {
  Eigen::VectorXf effects(columns.cols()), sums(clustering.count);
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    sums.setZero();
    const auto column = columns.col(c);
    for (const Stay& stay : clustering.stays) {
      const Eigen::Index n = stay.end - stay.begin;
      sums[stay.cluster] += column.segment(stay.begin, n).dot(residual.segment(stay.begin, n));
    }
    const float squares = column.squaredNorm();
    effects[c] = squares > 0.0f ? sums.squaredNorm() / (static_cast<float>(variance) * squares) : 0.0f;
  }
  return effects;
}

double DesignEffect::LargestOf(const Eigen::MatrixXf& columns, const Eigen::VectorXd& residual, double quantile) const {
  const double variance = residual.squaredNorm() / scorer_.degrees_of_freedom();
  const Eigen::VectorXf single = residual.cast<float>();
  double largest = 1.0;
  for (const Clustering& clustering : clusterings_) {
    if (clustering.held < scorer_.policy().fewest_clusters) continue;
    largest = std::max(largest, QuantileOf(EffectsOf(columns, single, variance, clustering), quantile));
  }
  return largest;
}

double DesignEffect::Of(const Eigen::VectorXd& residual) const {
  return LargestOf(columns_, residual, scorer_.policy().design_quantile);
}

double DesignEffect::OfGroup(int group, const Eigen::VectorXd& residual) const {
  constexpr double kMedian = 0.5;
  return LargestOf(scorer_.Projected(group).cast<float>(), residual, kMedian);
}

}  // namespace axiscal::objective
