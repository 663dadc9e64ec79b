// Design effect: by how much the products of the residual with columns scatter more than they would if rows were
// independent (Kish 1965). An incomplete model, or noise that neighbours share, leaves residuals that go together
// within clusters of rows; likelihood ratios are then too large by this factor.
//
//   c(x) = max over clusterings of   sum over clusters (sum over its rows x r)^2 / (s^2 sum over all rows x^2),   s^2 =
//   r'r / dof D = max(1, the policy's quantile of c over columns of all families)
#ifndef AXISCAL_CORE_OBJECTIVE_DESIGN_EFFECT_H_
#define AXISCAL_CORE_OBJECTIVE_DESIGN_EFFECT_H_

#include "core/objective/scorer.h"

namespace axiscal::objective {

class DesignEffect {
 public:
  // Draws visible columns of each family. `scorer` must outlive it.
  explicit DesignEffect(const Scorer& scorer);

  // Of what `residual` (whitened rows) has left.
  double Of(const Eigen::VectorXd& residual) const;
  // Of one group's columns: their median.
  double OfGroup(int group, const Eigen::VectorXd& residual) const;

 private:
  // Rows [begin, end) that follow each other in one cluster.
  struct Stay {
    Eigen::Index begin = 0, end = 0;
    int cluster = 0;
  };
  struct Clustering {
    std::vector<Stay> stays;
    int count = 0;  // numbers of clusters
    int held = 0;   // of which hold rows
  };

  // Of each column, under one clustering.
  Eigen::VectorXf EffectsOf(const Eigen::MatrixXf& columns, const Eigen::VectorXf& residual, double variance,
                            const Clustering& clustering) const;
  // The largest of all clusterings: this quantile of the columns' effects.
  double LargestOf(const Eigen::MatrixXf& columns, const Eigen::VectorXd& residual, double quantile) const;

  const Scorer& scorer_;
  std::vector<Clustering> clusterings_;
  Eigen::MatrixXf columns_;  // projected; single precision: a quantile of their sums is asked for
};

}  // namespace axiscal::objective

#endif  // AXISCAL_CORE_OBJECTIVE_DESIGN_EFFECT_H_
