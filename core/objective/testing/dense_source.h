// A source whose columns stand in a matrix: the slow obvious twin of all others.
#ifndef AXISCAL_CORE_OBJECTIVE_TESTING_DENSE_SOURCE_H_
#define AXISCAL_CORE_OBJECTIVE_TESTING_DENSE_SOURCE_H_

#include "core/objective/source.h"

namespace axiscal::objective {

class DenseSource : public Source {
 public:
  // Groups in order; their columns stand side by side.
  DenseSource(Eigen::MatrixXd columns, std::vector<Group> groups) : columns_(std::move(columns)) {
    groups_ = std::move(groups);
  }
  // All flat, of one family, `width` columns each.
  DenseSource(Eigen::MatrixXd columns, int width, int family, bool is_scan = false)
      : columns_(std::move(columns)), is_scan_(is_scan) {
    Group group;
    group.family = family;
    group.columns = width;
    groups_.assign(static_cast<size_t>(columns_.cols() / width), group);
  }

  bool IsScan() const override { return is_scan_; }
  Eigen::MatrixXd Columns(int group) const override {
    Eigen::Index at = 0;
    for (int g = 0; g < group; ++g) at += groups_[g].columns;
    return columns_.middleCols(at, groups_[group].columns);
  }

 private:
  const Eigen::MatrixXd columns_;
  const bool is_scan_ = false;
};

}  // namespace axiscal::objective

#endif  // AXISCAL_CORE_OBJECTIVE_TESTING_DENSE_SOURCE_H_
