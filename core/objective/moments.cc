#include "core/objective/moments.h"

#include <algorithm>

namespace axiscal::objective {

Slips::Slips(int row_count, std::vector<Series> series, Eigen::MatrixXd columns, const Group& model)
    : row_count_(row_count), series_(std::move(series)), columns_(std::move(columns)) {
  const size_t moments = series_.empty() ? 0 : series_.front().first.size();
  for (size_t m = 0; m < moments; ++m) {
    Group group = model;
    group.columns = static_cast<int>(columns_.cols());
    group.place = series_.front().first[m];
    groups_.push_back(group);
  }
}

Eigen::MatrixXd Slips::Columns(int group) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(row_count_, columns_.cols());
  Eigen::Index at = 0;
  for (const Series& one : series_) {
    const int before = one.first[group] - one.begin, after = one.end - one.first[group];
    out.middleRows(one.first[group], after) = columns_.middleRows(at + before, after);
    at += one.end - one.begin;
  }
  return out;
}

void Slips::AddProducts(int begin, const Eigen::MatrixXd& u, Eigen::Ref<Eigen::MatrixXd> products) const {
  const Eigen::Index m = columns_.cols();
  Eigen::Index at = 0;
  for (const Series& one : series_) {
    const Eigen::Index n = one.end - one.begin;
    if (one.begin >= begin && one.end <= begin + u.rows()) {
      Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(m, u.cols());
      int summed = one.end;
      for (size_t k = groups_.size(); k-- > 0;) {
        const int first = one.first[k];
        sum.noalias() += columns_.middleRows(at + first - one.begin, summed - first).transpose() *
                         u.middleRows(first - begin, summed - first);
        summed = first;
        products.middleRows(static_cast<Eigen::Index>(k) * m, m) += sum;
      }
    }
    at += n;
  }
}

std::vector<Eigen::MatrixXd> Slips::Grams(const Whitening& whitening) const {
  const Eigen::Index m = columns_.cols();
  std::vector<Eigen::MatrixXd> grams(groups_.size(), Eigen::MatrixXd::Zero(m, m));
  Eigen::Index at = 0;
  for (const Series& one : series_) {
    const int n = one.end - one.begin;
    // What has slipped before all rows; rows that no longer remember the moment are the same for all moments before.
    Eigen::MatrixXd whitened = columns_.middleRows(at, n);
    whitening.Apply(one.begin, whitened);
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(m, m);
    int summed = one.end;
    for (size_t k = groups_.size(); k-- > 0;) {
      const int first = one.first[k];
      if (first == one.end) continue;
      const int settled = std::min(summed, first + whitening.Memory(first, one.end));
      if (settled < summed) {
        const auto more = whitened.middleRows(settled - one.begin, summed - settled);
        sum.noalias() += more.transpose() * more;
        summed = settled;
      }
      Eigen::MatrixXd begin = columns_.middleRows(at + first - one.begin, settled - first);
      whitening.Apply(first, begin);
      grams[k] += sum + begin.transpose() * begin;
    }
    at += n;
  }
  return grams;
}

SingleRows::SingleRows(int row_count, std::vector<int> rows, const Group& model)
    : row_count_(row_count), rows_(std::move(rows)) {
  groups_.assign(rows_.size(), model);
  for (size_t k = 0; k < rows_.size(); ++k) groups_[k].place = rows_[k];
}

Eigen::MatrixXd SingleRows::Columns(int group) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(row_count_, 1);
  out(rows_[group], 0) = 1.0;
  return out;
}

void SingleRows::AddProducts(int begin, const Eigen::MatrixXd& u, Eigen::Ref<Eigen::MatrixXd> products) const {
  for (size_t k = 0; k < rows_.size(); ++k) {
    const int row = rows_[k] - begin;
    if (row >= 0 && row < u.rows()) products.row(static_cast<Eigen::Index>(k)) += u.row(row);
  }
}

std::vector<Eigen::MatrixXd> SingleRows::Grams(const Whitening& whitening) const {
  std::vector<Eigen::MatrixXd> grams;
  for (const int row : rows_) {
    Eigen::MatrixXd begin = Eigen::MatrixXd::Zero(whitening.Memory(row, row_count_), 1);
    begin(0, 0) = 1.0;
    whitening.Apply(row, begin);
    grams.emplace_back(begin.transpose() * begin);
  }
  return grams;
}

}  // namespace axiscal::objective
