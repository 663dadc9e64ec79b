#include "core/predict/volumetric.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/predict/over_poses.h"

namespace axiscal::predict {
namespace {

using instruments::MeasuringRun;

// The mean square over the box is off by about 1 / sqrt(poses) of the spread of the squares: 3 % of the root.
constexpr int kPoses = 400;
// The ends of a 95 % interval are drawn to about 2 % of its width.
constexpr int kDraws = 4000;
constexpr uint64_t kSeed = 230;

// The runs that hold positions: readings along a path hold those of their traces.
std::vector<const MeasuringRun*> Positioned(const std::vector<MeasuringRun>& runs) {
  std::vector<const MeasuringRun*> out;
  for (const MeasuringRun& run : runs) {
    if (run.path_readings == nullptr) {
      if (run.reading_count() > 0) out.push_back(&run);
      continue;
    }
    for (const MeasuringRun& trace : run.path_readings->traces)
      if (!trace.time_s.empty()) out.push_back(&trace);
  }
  return out;
}

int CountOf(const MeasuringRun& run) { return static_cast<int>(run.time_s.size()); }

// What a machine may be off by beyond a number's uncertainty: by a rival of each choice, drawn by its odds.
class Choices {
 public:
  // Columns: errors of each rival less those of what was found, mm.
  Choices(const OverPoses& over, const std::vector<OpenChoice>& choices) {
    Eigen::Index count = 0;
    for (const OpenChoice& choice : choices) count += static_cast<Eigen::Index>(choice.rivals.size());
    columns_.resize(over.rows(), count);
    Eigen::Index at = 0;
    for (const OpenChoice& choice : choices) {
      const Eigen::VectorXd as_found = over.ErrorsOf(choice.as_found);
      double odds = 1.0;
      for (const OpenChoice::Rival& rival : choice.rivals) odds += rival.odds;
      One& one = choices_.emplace_back(One{choice.name, at, {}, 0.0});
      Eigen::VectorXd mean = Eigen::VectorXd::Zero(over.rows());
      double squares = 0.0;
      for (const OpenChoice::Rival& rival : choice.rivals) {
        columns_.col(at) = over.ErrorsOf(rival.model) - as_found;
        const double probability = rival.odds / odds;
        one.probability.push_back(probability);
        mean += probability * columns_.col(at);
        squares += probability * columns_.col(at).squaredNorm();
        ++at;
      }
      one.squares = squares;
      scatter_ += squares - mean.squaredNorm();
      mean_ = mean_.size() == 0 ? mean : Eigen::VectorXd(mean_ + mean);
    }
    if (mean_.size() == 0) mean_.setZero(over.rows());
  }

  const Eigen::MatrixXd& columns() const { return columns_; }
  const Eigen::VectorXd& mean() const { return mean_; }
  // Of all choices, sum over the poses, mm^2: what their draws scatter about the mean.
  double scatter() const { return scatter_; }
  // One where its rival acts.
  Eigen::VectorXd Draw(base::Random* random) const {
    Eigen::VectorXd acts = Eigen::VectorXd::Zero(columns_.cols());
    for (const One& one : choices_) {
      double left = random->Uniform();
      for (size_t k = 0; k < one.probability.size(); ++k) {
        left -= one.probability[k];
        if (left >= 0.0) continue;
        acts[one.first + static_cast<Eigen::Index>(k)] = 1.0;
        break;
      }
    }
    return acts;
  }
  // Those that make at least kWeak of this sum of squares, the largest first.
  std::vector<std::string> Weak(double squares) const {
    std::vector<std::pair<double, std::string>> shares;
    for (const One& one : choices_)
      if (one.squares > 0.0 && one.squares >= kWeak * squares) shares.emplace_back(-one.squares, one.name);
    std::sort(shares.begin(), shares.end());
    std::vector<std::string> names;
    for (const auto& [share, name] : shares) names.push_back(name);
    return names;
  }

 private:
  struct One {
    std::string name;
    Eigen::Index first = 0;
    std::vector<double> probability;
    double squares = 0.0;  // expected
  };
  Eigen::MatrixXd columns_;
  std::vector<One> choices_;
  Eigen::VectorXd mean_;
  double scatter_ = 0.0;
};

// Root mean square of d + V a + A z over the poses, z standard normal, a by the choices, for one d: by the eigenvectors
// of A' A.
struct Spread {
  double constant = 0.0;            // d' d / poses
  double mean_square = 0.0;         // expectation of |d + V a|^2 / poses
  Eigen::VectorXd linear, squares;  // of the rotated z
  Eigen::VectorXd with_choices;     // V' d / poses

  // `choices`: |V a|^2 / poses; `linear_choices`: the rotated A' V a / poses.
  double At(const Eigen::VectorXd& z, const Eigen::VectorXd& acts, double choices,
            const Eigen::VectorXd& linear_choices) const {
    return std::sqrt(std::max(0.0, constant + choices + 2.0 * with_choices.dot(acts) +
                                       2.0 * (linear + linear_choices).dot(z) + squares.dot(z.cwiseAbs2())));
  }
  double Expected() const { return std::sqrt(mean_square + squares.sum()); }
};

RootMeanSquare IntervalOf(const Spread& spread, std::vector<double> draws) {
  return {spread.Expected(), Quantile(&draws, kLowQuantile), Quantile(&draws, kHighQuantile)};
}

}  // namespace

Box MeasuredBox(const std::vector<MeasuringRun>& runs) {
  Box box;
  for (const MeasuringRun* run : Positioned(runs)) {
    const auto axes = static_cast<size_t>(run->axis_count);
    box.low.resize(axes, std::numeric_limits<double>::infinity());
    box.high.resize(axes, -std::numeric_limits<double>::infinity());
    for (int k = 0; k < CountOf(*run); ++k) {
      for (size_t i = 0; i < axes; ++i) {
        box.low[i] = std::min(box.low[i], run->PositionsOf(k)[i]);
        box.high[i] = std::max(box.high[i], run->PositionsOf(k)[i]);
      }
    }
  }
  return box;
}

BoxStates::BoxStates(const std::vector<MeasuringRun>& runs, int count, const std::optional<Box>& box)
    : box_(box ? *box : MeasuredBox(runs)) {
  const std::vector<const MeasuringRun*> measured = Positioned(runs);
  const int axes = measured.front()->axis_count;
  std::vector<double> fastest(static_cast<size_t>(axes), 0.0);
  std::vector<size_t> first;  // reading of all, per run
  size_t readings = 0;
  bool has_time = false;
  for (const MeasuringRun* run : measured) {
    first.push_back(readings);
    readings += static_cast<size_t>(CountOf(*run));
    has_time = has_time || run->has_time;
    for (int k = 0; k < CountOf(*run); ++k) {
      for (int i = 0; i < axes; ++i) {
        const double speed = std::abs(run->axis_states[static_cast<size_t>(k * axes + i)].speed);
        if (std::isfinite(speed)) fastest[i] = std::max(fastest[i], speed);
      }
    }
  }
  base::Random random(kSeed);
  path_.axis_count = axes;
  path_.has_time = has_time;
  path_.measured_mm.setZero(1, count);
  double time_s = 0.0;
  for (int k = 0; k < count; ++k) {
    for (int i = 0; i < axes; ++i) path_.positions.push_back(random.Uniform(box_.low[i], box_.high[i]));
    for (int i = 0; k > 0 && i < axes; ++i) {
      const double way = std::abs(path_.PositionsOf(k)[i] - path_.PositionsOf(k - 1)[i]);
      if (fastest[i] > 0.0) time_s = std::max(time_s, path_.time_s.back() + way / fastest[i]);
    }
    path_.time_s.push_back(time_s);
    const auto of_all = static_cast<size_t>(random.Below(readings));
    const auto run = static_cast<size_t>(std::upper_bound(first.begin(), first.end(), of_all) - first.begin()) - 1;
    at_.push_back({measured[run], static_cast<int>(of_all - first[run])});
  }
  instruments::DeriveMotion(&path_);
}

shapes::State BoxStates::At(int pose) const {
  shapes::State state = at_[static_cast<size_t>(pose)].run->StateOf(at_[static_cast<size_t>(pose)].reading);
  const auto axes = static_cast<size_t>(path_.axis_count);
  state.axes = {path_.axis_states.data() + static_cast<size_t>(pose) * axes, axes};
  state.approach = {};
  return state;
}

std::optional<VolumetricError> VolumetricErrorOver(const machine::Machine& machine,
                                                   const std::vector<MeasuringRun>& runs,
                                                   const machine::ErrorModel& before, const machine::KnownErrors& found,
                                                   const std::vector<std::string>& unknown,
                                                   const std::vector<OpenChoice>& choices) {
  if (found.covariance.is_empty() || Positioned(runs).empty()) return std::nullopt;
  const BoxStates states(runs, kPoses);
  if (states.box().low == states.box().high) return std::nullopt;
  const OverPoses over(machine, states, runs.front().tip_mm);
  VolumetricError out;
  out.box = states.box();
  out.poses = kPoses;

  const Eigen::MatrixXd by_number = over.Left(over.ByNumber(found));
  const Eigen::MatrixXd uncertain = by_number * found.covariance.root;
  out.weakest = over.WeakestOf(found, by_number, uncertain);
  const Eigen::VectorXd as_found = over.ErrorsOf(found.model);
  const Eigen::VectorXd missed = as_found - over.ErrorsOf(before);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(uncertain.transpose() * uncertain / kPoses);
  const Choices open_choices(over, choices);
  out.undecided =
      open_choices.Weak(uncertain.squaredNorm() + open_choices.mean().squaredNorm() + open_choices.scatter());
  const auto spread_of = [&](const Eigen::VectorXd& offset) {
    return Spread{offset.squaredNorm() / kPoses,
                  ((offset + open_choices.mean()).squaredNorm() + open_choices.scatter()) / kPoses,
                  eigen.eigenvectors().transpose() * (uncertain.transpose() * offset) / kPoses,
                  eigen.eigenvalues().cwiseMax(0.0), open_choices.columns().transpose() * offset / kPoses};
  };
  const Eigen::MatrixXd of_choices =
      eigen.eigenvectors().transpose() * (uncertain.transpose() * open_choices.columns()) / kPoses;
  const Eigen::MatrixXd choices_gram = open_choices.columns().transpose() * open_choices.columns() / kPoses;
  const Spread uncorrected = spread_of(as_found), of_before = spread_of(missed),
               of_after = spread_of(as_found - over.ErrorsOf(machine::NamedErrors(found.model)));
  std::vector<double> at_uncorrected, at_before, at_after, gain;
  base::Random random(kSeed);
  Eigen::VectorXd z(uncertain.cols());
  for (int i = 0; i < kDraws; ++i) {
    for (double& one : z) one = random.Normal();
    const Eigen::VectorXd acts = open_choices.Draw(&random), linear = of_choices * acts;
    const double squares = acts.dot(choices_gram * acts);
    at_uncorrected.push_back(uncorrected.At(z, acts, squares, linear));
    at_before.push_back(of_before.At(z, acts, squares, linear));
    at_after.push_back(of_after.At(z, acts, squares, linear));
    gain.push_back(at_before.back() - at_after.back());
  }
  out.uncorrected = IntervalOf(uncorrected, std::move(at_uncorrected));
  out.before = IntervalOf(of_before, std::move(at_before));
  out.after = IntervalOf(of_after, std::move(at_after));
  out.is_gain_held = Quantile(&gain, kLowQuantile) > 0.0;

  out.unknown = over.ActingOf(found.model, unknown);
  return out;
}

}  // namespace axiscal::predict
