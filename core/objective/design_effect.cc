#include "core/objective/design_effect.h"

#include <algorithm>
#include <map>
#include <random>

namespace axiscal::objective {
namespace {

double QuantileOf(Eigen::VectorXd values, double share) {
  if (values.size() == 0) return 1.0;
  const auto at =
      std::min<Eigen::Index>(values.size() - 1, static_cast<Eigen::Index>(share * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[at];
}

}  // namespace

DesignEffect::DesignEffect(const Scorer& scorer) : scorer_(scorer) {
  std::map<int, std::vector<int>> of_family;
  for (int g = 0; g < scorer.group_count(); ++g)
    if (scorer.IsVisible(g)) of_family[scorer.group(g).family].push_back(g);
  std::mt19937 random(scorer.policy().seed);
  std::vector<int> drawn;
  for (auto& [family, groups] : of_family) {
    // The first of a shuffle, by a rule that is the same in every library.
    for (size_t k = 0; k < groups.size() && k < static_cast<size_t>(scorer.policy().design_columns); ++k) {
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

Eigen::VectorXd DesignEffect::EffectsOf(const Eigen::MatrixXf& columns, const Eigen::VectorXd& residual,
                                        const std::vector<int>& clusters) const {
  const int count = clusters.empty() ? 0 : 1 + *std::max_element(clusters.begin(), clusters.end());
  Eigen::VectorXd effects = Eigen::VectorXd::Zero(columns.cols());
  if (count < scorer_.policy().fewest_clusters) return effects;
  const double variance = residual.squaredNorm() / scorer_.degrees_of_freedom();
  Eigen::VectorXd sums(count);
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    sums.setZero();
    double squares = 0.0;
    for (Eigen::Index i = 0; i < columns.rows(); ++i) {
      const double x = columns(i, c);
      sums[clusters[i]] += x * residual[i];
      squares += x * x;
    }
    effects[c] = squares > 0.0 ? sums.squaredNorm() / (variance * squares) : 0.0;
  }
  return effects;
}

double DesignEffect::Of(const Eigen::VectorXd& residual) const {
  double largest = 1.0;
  for (const std::vector<int>& clusters : scorer_.rows().clusterings)
    largest = std::max(largest, QuantileOf(EffectsOf(columns_, residual, clusters), scorer_.policy().design_quantile));
  return largest;
}

double DesignEffect::OfGroup(int group, const Eigen::VectorXd& residual) const {
  const Eigen::MatrixXf columns = scorer_.Projected(group).cast<float>();
  double largest = 1.0;
  for (const std::vector<int>& clusters : scorer_.rows().clusterings)
    largest = std::max(largest, QuantileOf(EffectsOf(columns, residual, clusters), 0.5));
  return largest;
}

}  // namespace axiscal::objective
