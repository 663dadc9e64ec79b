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
    // Rows after which all that the noise remembers has slipped, too.
    Eigen::Index memory = 1;
    constexpr double kForgotten = 1e-9;
    for (double left = 1.0; has_echo_ && left > kForgotten && rows.begin + memory < rows.end; ++memory)
      left *= echo_[rows.begin + memory];
    // Of such rows.
    const Eigen::Index n = rows.end - rows.begin;
    const Eigen::Ref<const Eigen::MatrixXd> raw = SlipOf(*slips.front(), rows.begin, n);
    Eigen::MatrixXd whitened = raw;
    for (Eigen::Index k = n - 1; k > 0; --k) whitened.row(k) -= correlation_[rows.begin + k] * raw.row(k - 1);
    for (Eigen::Index k = 1; has_echo_ && k < n; ++k) whitened.row(k) += echo_[rows.begin + k] * whitened.row(k - 1);
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
      const int settled = static_cast<int>(std::min<Eigen::Index>(first + memory, rows.end)), count = summed - settled;
      if (count > 0) {
        const auto more = whitened.middleRows(settled - rows.begin, count);
        nuisance_.Accumulate(rows.group, settled, more, &of_nuisance);
        own.noalias() += more.transpose() * more;
        with_residual.noalias() += more.transpose() * residual_.segment(settled, count);
        summed = settled;
      }
      auto sums = coefficients->middleCols<kMaxColumns>(kMaxColumns * static_cast<Eigen::Index>(i));
      Eigen::Matrix<double, Eigen::Dynamic, 3> begin = raw.middleRows(first - rows.begin, settled - first);
      for (Eigen::Index k = begin.rows() - 1; k > 0; --k)
        begin.row(k) -= correlation_[first + k] * raw.row(first - rows.begin + k - 1);
      for (Eigen::Index k = 1; k < begin.rows(); ++k) begin.row(k) += echo_[first + k] * begin.row(k - 1);
      begin.array().colwise() *= weight_.segment(first, begin.rows());
      sums += of_nuisance;
      nuisance_.Accumulate(rows.group, first, begin, &sums);
      projections[i]->own += own + begin.transpose() * begin;
      projections[i]->with_residual += with_residual + begin.transpose() * residual_.segment(first, begin.rows());
    }
  }
}

}  // namespace axiscal::loop
