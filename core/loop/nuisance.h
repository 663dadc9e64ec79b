// What the declared errors and the setup offsets can explain of a column of readings: coefficients on an orthonormal
// basis of their whitened columns, with priors as further rows. Errors have priors too, as wide as errors get: else a
// declared error that hardly shows could explain another effect by growing to a radian.
#ifndef AXISCAL_CORE_LOOP_NUISANCE_H_
#define AXISCAL_CORE_LOOP_NUISANCE_H_

#include <Eigen/Core>
#include <vector>

#include "core/identify/problem.h"

namespace axiscal::loop {

// The rows of one series (one run, one reading column), in time order.
struct Series {
  int begin = 0, end = 0;
  int run = 0, group = 0;
};

class Nuisance {
 public:
  Nuisance() = default;
  // `columns`: whitened, one row per used reading; first the set-up offsets of the row's own group, moved right up to
  // the errors, then the `errors` columns of the errors. `precision`: of the priors of these errors.
  Nuisance(const identify::Problem& problem, const std::vector<Series>& series, Eigen::MatrixXd columns,
           const Eigen::VectorXd& precision);

  Eigen::Index size() const { return size_; }
  // Adds the inner products of some rows' whitened columns (rows first .. first + count of one series) to `raw`
  // (size() x width); Finish turns the sum over all rows into coefficients.
  template <typename Columns, typename Raw>
  void Accumulate(int group, Eigen::Index first, const Columns& columns, Raw* raw) const {
    const Eigen::Index s = setup_basis_[group].rows(), n = columns.rows(), p = error_basis_.cols();
    // The setup's offsets stand right before the errors, unused ones of other groups to their left: one product.
    const Eigen::MatrixXd sums = columns_.block(first, widest_ - s, n, s + p).transpose() * columns;
    raw->middleRows(offset_[group], s) += sums.topRows(s);
    raw->bottomRows(p) += sums.bottomRows(p);
  }
  void Finish(Eigen::MatrixXd* raw) const;
  // Coefficients of the priors' own rows, `value` being each group's offsets: adds to those of the residual.
  Eigen::VectorXd OfPriors(const identify::Problem& problem, const std::vector<Eigen::VectorXd>& value) const;
  // The column with these coefficients, readings' rows only.
  Eigen::VectorXd Column(const std::vector<Series>& series, const Eigen::VectorXd& coefficients) const;

 private:
  // Of some rows of one group: columns of the errors; of its offsets.
  auto ErrorsOf(Eigen::Index first, Eigen::Index count) const {
    return columns_.block(first, widest_, count, columns_.cols() - widest_);
  }
  auto SetupOf(int group, Eigen::Index first, Eigen::Index count) const {
    return columns_.block(first, widest_ - setup_basis_[group].rows(), count, setup_basis_[group].rows());
  }

  Eigen::MatrixXd columns_;  // setup offsets of the row's own group, to the right in the first widest_ columns | errors
  Eigen::Index widest_ = 0;
  std::vector<Eigen::MatrixXd> setup_basis_;  // per group: columns times this are orthonormal with the priors' rows
  std::vector<Eigen::MatrixXd> setup_error_;  // per group: setup-basis coefficients of the error columns
  std::vector<Eigen::Index> offset_;          // per group: where its coefficients begin
  Eigen::MatrixXd error_basis_;
  Eigen::Index size_ = 0;
};

// B with B' G B = 1 on the space that G sees.
Eigen::MatrixXd InverseRoot(const Eigen::MatrixXd& gram);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_NUISANCE_H_
