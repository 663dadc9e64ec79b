// Effects that begin at a row (something slipped) or are one row (a bad reading). Their products come by running sums
// from the last row back: all moments at the cost of one.
#ifndef AXISCAL_CORE_OBJECTIVE_MOMENTS_H_
#define AXISCAL_CORE_OBJECTIVE_MOMENTS_H_

#include <vector>

#include "core/objective/source.h"

namespace axiscal::objective {

// From a moment on some columns act that did not before: group m is `columns` in the rows from first_rows(m, series)
// on.
class Slips : public Source {
 public:
  // The rows of one series in which something may slip.
  struct Series {
    int begin = 0, end = 0;
    std::vector<int> first;  // per moment, the first row after it; `end` where none is
  };
  // `columns`: raw, rows of all series x amplitudes, in the order of `series`. `model`: family, precision, kin ... of
  // each group; its place is the first row after the moment in the first series.
  Slips(int row_count, std::vector<Series> series, Eigen::MatrixXd columns, const Group& model);

  Eigen::MatrixXd Columns(int group) const override;
  void AddProducts(int begin, const Eigen::MatrixXd& u, Eigen::Ref<Eigen::MatrixXd> products) const override;
  std::vector<Eigen::MatrixXd> Grams(const Whitening& whitening) const override;

 private:
  const int row_count_;
  const std::vector<Series> series_;
  const Eigen::MatrixXd columns_;
};

// Group r is the row rows[r] alone.
class SingleRows : public Source {
 public:
  SingleRows(int row_count, std::vector<int> rows, const Group& model);

  Eigen::MatrixXd Columns(int group) const override;
  void AddProducts(int begin, const Eigen::MatrixXd& u, Eigen::Ref<Eigen::MatrixXd> products) const override;
  std::vector<Eigen::MatrixXd> Grams(const Whitening& whitening) const override;
  int RowOf(int group) const { return rows_[group]; }

 private:
  const int row_count_;
  const std::vector<int> rows_;
};

}  // namespace axiscal::objective

#endif  // AXISCAL_CORE_OBJECTIVE_MOMENTS_H_
