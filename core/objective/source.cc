#include "core/objective/source.h"

namespace axiscal::objective {

int Source::column_count() const {
  int count = 0;
  for (const Group& group : groups_) count += group.columns;
  return count;
}

void Source::AddProducts(int begin, const Eigen::MatrixXd& u, Eigen::Ref<Eigen::MatrixXd> products) const {
  Eigen::Index at = 0;
  for (size_t g = 0; g < groups_.size(); ++g) {
    const Eigen::MatrixXd columns = Columns(static_cast<int>(g));
    products.middleRows(at, columns.cols()).noalias() += columns.middleRows(begin, u.rows()).transpose() * u;
    at += columns.cols();
  }
}

std::vector<Eigen::MatrixXd> Source::Grams(const Whitening& whitening) const {
  std::vector<Eigen::MatrixXd> grams;
  for (size_t g = 0; g < groups_.size(); ++g) {
    Eigen::MatrixXd columns = Columns(static_cast<int>(g));
    whitening.Apply(0, columns);
    grams.emplace_back(columns.transpose() * columns);
  }
  return grams;
}

}  // namespace axiscal::objective
