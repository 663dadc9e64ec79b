#include "core/predict/box_errors.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/random.h"
#include "core/predict/over_poses.h"

namespace axiscal::predict {
namespace {

// The largest of so many poses stands for the box; a percentile is off by 1 % of the poses at 95 %.
constexpr int kPoses = 400;
// The ends of a 95 % interval are drawn to about 4 % of its width.
constexpr int kDraws = 1000;
constexpr uint64_t kSeed = 2301;
constexpr double kP95 = 0.95, kMedian = 0.5;

// Figures of some poses, drawn many times.
class Drawn {
 public:
  explicit Drawn(std::vector<int> poses) : poses_(std::move(poses)), squares_(poses_.size(), 0.0) {}

  // `errors`: of all poses, rows as of OverPoses.
  void Add(const Eigen::VectorXd& errors) {
    std::vector<double> lengths;
    double sum = 0.0;
    for (size_t i = 0; i < poses_.size(); ++i) {
      const double square = errors.segment<3>(3 * poses_[i]).squaredNorm();
      squares_[i] += square;
      sum += square;
      lengths.push_back(std::sqrt(square));
    }
    rms_.push_back(std::sqrt(sum / static_cast<double>(poses_.size())));
    max_.push_back(*std::max_element(lengths.begin(), lengths.end()));
    median_.push_back(Quantile(&lengths, kMedian));
    p95_.push_back(Quantile(&lengths, kP95));
  }
  LengthFigures Figures(const BoxPoses& poses) && {
    const size_t worst = static_cast<size_t>(std::max_element(squares_.begin(), squares_.end()) - squares_.begin());
    const double* const at = poses.PositionsOf(poses_[worst]);
    return {Of(&rms_), Of(&median_), Of(&p95_), Of(&max_), {at, at + poses.box().low.size()}};
  }

 private:
  static Figure Of(std::vector<double>* draws) {
    const double mean = std::accumulate(draws->begin(), draws->end(), 0.0) / static_cast<double>(draws->size());
    return {mean, Quantile(draws, kLowQuantile), Quantile(draws, kHighQuantile)};
  }

  const std::vector<int> poses_;
  std::vector<double> squares_, rms_, median_, p95_, max_;
};

bool Holds(const Box& box, const double* positions) {
  // Rounding of files: a position of the box's end is within it.
  constexpr double kRounding = 1e-9;
  for (size_t i = 0; i < box.low.size(); ++i)
    if (positions[i] < box.low[i] - kRounding || positions[i] > box.high[i] + kRounding) return false;
  return true;
}

}  // namespace

std::optional<BoxErrors> ErrorsOverBox(const machine::Machine& machine,
                                       const std::vector<instruments::MeasuringRun>& runs,
                                       const std::optional<machine::ErrorModel>& before,
                                       const machine::KnownErrors& found, const std::vector<std::string>& unknown,
                                       const std::optional<Box>& box) {
  BoxErrors out;
  out.measured = MeasuredBox(runs);
  if (found.covariance.is_empty() || out.measured.low == out.measured.high) return std::nullopt;
  out.box = box.value_or(out.measured);
  if (out.box.low == out.box.high) return std::nullopt;
  const BoxPoses poses(runs, kPoses, out.box);
  const OverPoses over(machine, poses, runs.front().tip_mm);
  out.poses = kPoses;
  std::vector<int> all(kPoses), known;
  std::iota(all.begin(), all.end(), 0);
  for (const int k : all)
    if (Holds(out.measured, poses.PositionsOf(k))) known.push_back(k);
  out.known_share = static_cast<double>(known.size()) / kPoses;

  const Eigen::MatrixXd by_number = over.Left(over.ByNumber(found));
  const Eigen::MatrixXd uncertain = by_number * found.covariance.root;
  out.weakest = over.WeakestOf(found, by_number, uncertain);
  out.unknown = over.ActingOf(found.model, unknown);
  const Eigen::VectorXd as_found = over.ErrorsOf(found.model);
  const Eigen::VectorXd left = as_found - over.ErrorsOf(machine::NamedErrors(found.model));
  const Eigen::VectorXd missed = before ? Eigen::VectorXd(as_found - over.ErrorsOf(*before)) : as_found;
  const bool is_mixed = !known.empty() && known.size() < all.size();
  Drawn uncorrected(all), at_before(all), after(all), where_known(is_mixed ? known : all);
  base::Random random(kSeed);
  Eigen::VectorXd z(uncertain.cols());
  for (int i = 0; i < kDraws; ++i) {
    for (double& one : z) one = random.Normal();
    const Eigen::VectorXd off = uncertain * z;
    uncorrected.Add(as_found + off);
    if (before) at_before.Add(missed + off);
    after.Add(left + off);
    if (is_mixed) where_known.Add(left + off);
  }
  out.uncorrected = std::move(uncorrected).Figures(poses);
  if (before) out.before = std::move(at_before).Figures(poses);
  out.after = std::move(after).Figures(poses);
  if (is_mixed) out.after_where_known = std::move(where_known).Figures(poses);
  return out;
}

}  // namespace axiscal::predict
