// Slips of one session: every reading after a slip takes part in all slips before it, so that sums from the last
// reading back give all moments at once.
#include <algorithm>
#include <numeric>

#include "core/loop/signatures.h"

namespace axiscal::loop {

Eigen::Ref<const Eigen::MatrixXd> Signatures::SlipOf(const Candidate& slip, Eigen::Index begin,
                                                     Eigen::Index count) const {
  if (slip.carrier == instruments::Carrier::kTable) return setup_raw_.middleRows(begin, count);
  const Eigen::Index tool = machine::kComponents * Eigen::Index{problem_.machine->tool_joint()};
  return sensitivity_.block(begin, tool, count, 3);
}

void Signatures::SumSlips(const std::vector<const Candidate*>& slips, const std::vector<Projection*>& projections,
                          Eigen::MatrixXd* coefficients) const {
  std::vector<size_t> latest_first(slips.size());
  std::iota(latest_first.begin(), latest_first.end(), size_t{0});
  std::sort(latest_first.begin(), latest_first.end(),
            [&slips](size_t a, size_t b) { return slips[a]->first_reading > slips[b]->first_reading; });
  for (const Series& rows : series_) {
    if (rows.run != slips.front()->run) continue;
    // Of rows whose neighbour above has slipped, too.
    const Eigen::Index n = rows.end - rows.begin;
    const Eigen::Ref<const Eigen::MatrixXd> raw = SlipOf(*slips.front(), rows.begin, n);
    Eigen::MatrixXd whitened = raw;
    for (Eigen::Index k = n - 1; k > 0; --k) whitened.row(k) -= correlation_[rows.begin + k] * raw.row(k - 1);
    whitened.array().colwise() *= weight_.segment(rows.begin, n);

    Eigen::MatrixXd of_nuisance = Eigen::MatrixXd::Zero(nuisance_.size(), kMaxColumns);
    Eigen::Matrix3d own = Eigen::Matrix3d::Zero();
    Eigen::Vector3d with_residual = Eigen::Vector3d::Zero();
    int summed = rows.end;  // from this row on
    for (const size_t i : latest_first) {
      const int first = static_cast<int>(
          std::lower_bound(reading_.begin() + rows.begin, reading_.begin() + rows.end, slips[i]->first_reading) -
          reading_.begin());
      if (first == rows.end) continue;
      const Eigen::Index count = summed - (first + 1);
      if (count > 0) {
        const auto more = whitened.middleRows(first + 1 - rows.begin, count);
        nuisance_.Accumulate(rows.group, first + 1, more, &of_nuisance);
        own.noalias() += more.transpose() * more;
        with_residual.noalias() += more.transpose() * residual_.segment(first + 1, count);
        summed = first + 1;
      }
      auto sums = coefficients->middleCols<kMaxColumns>(kMaxColumns * static_cast<Eigen::Index>(i));
      const Eigen::RowVector3d begin = weight_[first] * raw.row(first - rows.begin);  // its neighbour has not
      sums += of_nuisance;
      nuisance_.Accumulate(rows.group, first, begin, &sums);
      projections[i]->own += own + begin.transpose() * begin;
      projections[i]->with_residual += with_residual + residual_[first] * begin.transpose();
    }
  }
}

}  // namespace axiscal::loop
