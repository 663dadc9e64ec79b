// What readings tell of unknowns: their Fisher information, the Gram matrix J'J of the whitened Jacobian J (a row per
// reading, of unit variance), with the test's own set-up eliminated: the Schur complement of the set-up's block, which
// is what is left where the set-up is fitted along (Pukelsheim, Optimal Design of Experiments, 1993, ch. 3). The
// readings' values do not enter, so that a planned test has an information before it is measured.
#ifndef AXISCAL_CORE_INFORMATION_INFORMATION_H_
#define AXISCAL_CORE_INFORMATION_INFORMATION_H_

#include <Eigen/Core>
#include <vector>

namespace axiscal::information {

// About p unknowns in an order that its maker states, mm and rad.
struct Information {
  Eigen::MatrixXd matrix;  // p x p, 1 / (unit_i unit_j)
  Eigen::VectorXd norm2;   // p: squares of the norms of J's columns before the set-up was eliminated

  // Tests about the same unknowns whose set-ups are their own, or are known, add up.
  Information& operator+=(const Information& other) {
    matrix += other.matrix;
    norm2 += other.norm2;
    return *this;
  }
};

// Of the rows of `whitened` (rows x p), nothing to be eliminated.
Information OfRows(const Eigen::MatrixXd& whitened);

// Covariance of the unknowns `free`, in their order, while the others do not move. The information's block of `free`
// must have full rank (null_space.h).
Eigen::MatrixXd CovarianceOf(const Information& information, const std::vector<int>& free);

}  // namespace axiscal::information

#endif  // AXISCAL_CORE_INFORMATION_INFORMATION_H_
