#include "core/compare/tool_point.h"

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/base/units.h"
#include "core/predict/taken_up.h"
#include "core/predict/tool_point.h"

namespace axiscal::compare {
namespace {

constexpr uint64_t kSeed = 230;
constexpr int kDraws = 1000;  // the 95 % quantile of what chance makes, to about 1 % of its place
constexpr double kQuantile = 0.95;
constexpr int kMostCorners = 256;  // of eight axes; more would outnumber the poses that are drawn
constexpr double kNoticed = 1e-6;  // of a direction's effect, mm per file unit: less is rounding
constexpr size_t kMostNamed = 3;   // errors that are named where the difference is largest

// States at the corners of the box and at poses drawn from it.
class Poses {
 public:
  Poses(const Workspace& workspace) : workspace_(workspace), axes_(workspace.box.low.size()) {
    const Box& box = workspace.box;
    std::vector<size_t> moving;
    for (size_t i = 0; i < axes_; ++i)
      if (box.low[i] < box.high[i]) moving.push_back(i);
    const size_t corners = size_t{1} << moving.size();
    if (moving.size() < 20 && corners <= kMostCorners) {
      for (size_t corner = 0; corner < corners; ++corner) {
        std::vector<double> at = box.low;
        for (size_t k = 0; k < moving.size(); ++k)
          if ((corner >> k) & 1) at[moving[k]] = box.high[moving[k]];
        Add(at);
      }
    }
    for (int k = 0; k < workspace.poses; ++k) {
      std::vector<double> at = box.low;
      for (const size_t i : moving) at[i] = random_.Uniform(box.low[i], box.high[i]);
      Add(at);
    }
  }
  int count() const { return static_cast<int>(positions_.size() / std::max<size_t>(1, axes_)); }
  const double* PositionsOf(int pose) const { return positions_.data() + static_cast<size_t>(pose) * axes_; }
  shapes::State At(int pose) const {
    shapes::State state;
    state.axes = {states_.data() + static_cast<size_t>(pose) * axes_, axes_};
    state.time_s = workspace_.time_s;
    state.temperature_celsius = workspace_.temperature_celsius;
    return state;
  }

 private:
  void Add(const std::vector<double>& at) {
    for (const double position : at) {
      positions_.push_back(position);
      shapes::AxisState state;
      state.position = position;
      state.sense = random_.Chance(0.5) ? 1.0 : -1.0;
      states_.push_back(state);
    }
  }

  const Workspace& workspace_;
  const size_t axes_;
  base::Random random_{kSeed};
  std::vector<double> positions_;
  std::vector<shapes::AxisState> states_;
};

double RmsOf(const Eigen::VectorXd& mm) { return std::sqrt(mm.squaredNorm() / (static_cast<double>(mm.size()) / 3.0)); }

int LargestOf(const Eigen::VectorXd& mm) {
  int at = 0;
  for (int k = 1; k < mm.size() / 3; ++k)
    if (mm.segment<3>(3 * k).norm() > mm.segment<3>(3 * at).norm()) at = k;
  return at;
}

double Quantile(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(kQuantile * static_cast<double>(values.size() - 1))];
}

// `alone`: 3 poses x numbers, what each number's difference does; `uncertain`: 3 poses x q, whose product with standard
// normal numbers is what the uncertainties do.
Size SizeOf(const Eigen::VectorXd& mm, const Eigen::MatrixXd& alone, const Eigen::MatrixXd& uncertain,
            const Poses& poses, const Numbers& numbers) {
  Size size;
  const int at = LargestOf(mm);
  size.rms_mm = RmsOf(mm);
  size.max_mm = mm.segment<3>(3 * at).norm();
  const double* positions = poses.PositionsOf(at);
  size.where.positions.assign(positions, positions + poses.At(at).axes.size());
  size.where.difference_mm = mm.segment<3>(3 * at);
  std::vector<std::pair<double, std::string>> shares;
  for (Eigen::Index i = 0; i < alone.cols() && size.max_mm > 0.0; ++i) {
    // Its part along the whole.
    const double share = alone.col(i).segment<3>(3 * at).dot(size.where.difference_mm) / (size.max_mm * size.max_mm);
    constexpr double kWorthNaming = 0.1;
    if (share > kWorthNaming) shares.emplace_back(-share, numbers.all[static_cast<size_t>(i)].name);
  }
  std::sort(shares.begin(), shares.end());
  for (size_t i = 0; i < std::min(shares.size(), kMostNamed); ++i) size.where.by.push_back(shares[i].second);
  size.chance_rms_mm = size.chance_max_mm = reports::kNoNumber;
  if (uncertain.cols() == 0) {
    size.where.sigma_mm.setConstant(reports::kNoNumber);
    return size;
  }
  size.where.sigma_mm = uncertain.middleRows<3>(3 * at).rowwise().norm();
  base::Random random(kSeed);
  std::vector<double> rms, max;
  Eigen::VectorXd z(uncertain.cols());
  for (int i = 0; i < kDraws; ++i) {
    for (double& one : z) one = random.Normal();
    const Eigen::VectorXd drawn = uncertain * z;
    rms.push_back(RmsOf(drawn));
    max.push_back(drawn.segment<3>(3 * LargestOf(drawn)).norm());
  }
  size.chance_rms_mm = Quantile(std::move(rms));
  size.chance_max_mm = Quantile(std::move(max));
  return size;
}

// The tool-point error's derivatives by the numbers of `covariance`, times its root.
Eigen::MatrixXd Spread(const machine::Machine& machine, const machine::ErrorModel& model,
                       const machine::ErrorCovariance& covariance, const Poses& poses, const Eigen::Vector3d& tip_mm) {
  const machine::KnownErrors errors{model, covariance};
  predict::ToolPoint tool(machine, errors, tip_mm);
  Eigen::MatrixXd out(3 * poses.count(), covariance.root.cols());
  for (int k = 0; k < poses.count(); ++k)
    out.middleRows<3>(3 * k) = tool.ByNumberAt(poses.At(k)).topRows<3>() * covariance.root;
  return out;
}

}  // namespace

OverBox DifferenceOver(const machine::Machine& machine, const Side& first, const Side& second, const Numbers& numbers,
                       const Workspace& workspace) {
  const Poses poses(workspace);
  const int count = poses.count();
  OverBox out;
  out.difference.poses = count;
  predict::ToolPoint of_first(machine, first.errors, workspace.tip_mm),
      of_second(machine, second.errors, workspace.tip_mm);
  Eigen::VectorXd mm(3 * count);
  double squares = 0.0;
  for (int k = 0; k < count; ++k) {
    const predict::ToolPointError error = of_second.ErrorAt(poses.At(k)) - of_first.ErrorAt(poses.At(k));
    mm.segment<3>(3 * k) = error.head<3>();
    const double tilt_rad = error.tail<3>().norm();
    squares += tilt_rad * tilt_rad;
    out.difference.tilt_max_rad = std::max(out.difference.tilt_max_rad, tilt_rad);
  }
  out.difference.tilt_rms_rad = std::sqrt(squares / count);

  machine::ErrorCovariance each;
  for (const Number& number : numbers.all) each.of.push_back(number.of);
  const auto size = static_cast<Eigen::Index>(numbers.all.size());
  each.root.setIdentity(size, size);
  for (Eigen::Index i = 0; i < size; ++i) each.root(i, i) = numbers.all[static_cast<size_t>(i)].factor;
  const Eigen::MatrixXd by_number = Spread(machine, numbers.both, each, poses, workspace.tip_mm);  // mm per file unit
  Eigen::MatrixXd alone = by_number;
  for (Eigen::Index i = 0; i < size; ++i) {
    const Number& number = numbers.all[static_cast<size_t>(i)];
    alone.col(i) *= number.value[1] - number.value[0];
    out.rms_mm.push_back(RmsOf(alone.col(i)));
  }
  Eigen::MatrixXd uncertain(3 * count, 0);
  for (const Side* side : {&first, &second}) {
    if (side->errors.covariance.is_empty()) continue;
    const Eigen::MatrixXd spread =
        Spread(machine, side->errors.model, side->errors.covariance, poses, workspace.tip_mm);
    uncertain.conservativeResize(Eigen::NoChange, uncertain.cols() + spread.cols());
    uncertain.rightCols(spread.cols()) = spread;
  }
  const Eigen::MatrixXd taken = predict::TakenUp(machine, count, [&](int k) { return poses.PositionsOf(k); });
  const auto left = [&](const auto& columns) -> Eigen::MatrixXd {
    return columns - taken * (taken.transpose() * columns);
  };
  out.difference.as_programmed = SizeOf(mm, alone, uncertain, poses, numbers);
  out.difference.set_anew = SizeOf(left(mm), left(alone), left(uncertain), poses, numbers);
  const Eigen::MatrixXd of_unknown = left(Eigen::MatrixXd(by_number * numbers.unknown.transpose()));
  for (Eigen::Index k = 0; k < numbers.unknown.rows(); ++k) {
    if (of_unknown.col(k).cwiseAbs().maxCoeff() < kNoticed * base::kMmPerUm) continue;
    out.difference.unknown.push_back(
        CombinationText(numbers.all, numbers.unknown.row(k).transpose(), numbers.pivots[static_cast<size_t>(k)]));
  }
  return out;
}

}  // namespace axiscal::compare
