#include "core/predict/box_poses.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "core/predict/tool_point.h"

namespace axiscal::predict {
namespace {

constexpr uint64_t kPosesSeed = 230;
constexpr int kChanceDraws = 1000;  // the 95 % quantile of what chance makes, to about 1 % of its place
constexpr double kChanceQuantile = 0.95;
constexpr size_t kMostCorners = 256;  // of eight axes; more would outnumber the poses that are drawn

double QuantileOf(std::vector<double> values) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(kChanceQuantile * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

absl::StatusOr<Box> BoxOfTravel(const machine::Machine& machine) {
  Box box;
  for (const machine::Axis& axis : machine.axes) {
    const bool is_stated = axis.min_position && axis.max_position;
    if (!is_stated && axis.kind == machine::AxisKind::kLinear)
      return absl::InvalidArgumentError(absl::StrCat("machine ", machine.id, " states no travel of ", axis.name,
                                                     ", expected a box with a range of it"));
    box.low.push_back(is_stated ? *axis.min_position : 0.0);
    box.high.push_back(is_stated ? *axis.max_position : 2.0 * std::numbers::pi);
  }
  return box;
}

BoxPoses::BoxPoses(const Workspace& workspace)
    : workspace_(workspace), axes_(std::max<size_t>(1, workspace.box.low.size())) {
  base::Random random(kPosesSeed);
  const Box& box = workspace.box;
  const auto add = [&](const std::vector<double>& at) {
    for (const double position : at) {
      positions_.push_back(position);
      shapes::AxisState state;
      state.position = position;
      state.sense = random.Chance(0.5) ? 1.0 : -1.0;
      states_.push_back(state);
    }
  };
  std::vector<size_t> moving;
  for (size_t i = 0; i < box.low.size(); ++i)
    if (box.low[i] < box.high[i]) moving.push_back(i);
  const size_t corners = size_t{1} << std::min<size_t>(moving.size(), 20);
  if (corners <= kMostCorners) {
    for (size_t corner = 0; corner < corners; ++corner) {
      std::vector<double> at = box.low;
      for (size_t k = 0; k < moving.size(); ++k)
        if ((corner >> k) & 1) at[moving[k]] = box.high[moving[k]];
      add(at);
    }
  }
  for (int k = 0; k < workspace.poses; ++k) {
    std::vector<double> at = box.low;
    for (const size_t i : moving) at[i] = random.Uniform(box.low[i], box.high[i]);
    add(at);
  }
}

shapes::State BoxPoses::At(int pose) const {
  shapes::State state;
  state.axes = {states_.data() + static_cast<size_t>(pose) * axes_, axes_};
  state.time_s = workspace_.time_s;
  state.temperature_celsius = workspace_.temperature_celsius;
  return state;
}

double RmsOver(const Eigen::VectorXd& mm) {
  return std::sqrt(mm.squaredNorm() / (static_cast<double>(mm.size()) / 3.0));
}

int LongestAt(const Eigen::VectorXd& mm) {
  int at = 0;
  for (int k = 1; k < mm.size() / 3; ++k)
    if (mm.segment<3>(3 * k).norm() > mm.segment<3>(3 * at).norm()) at = k;
  return at;
}

Eigen::MatrixXd SpreadOver(const machine::Machine& machine, const machine::ErrorModel& model,
                           const machine::ErrorCovariance& covariance, const BoxPoses& poses,
                           const Eigen::Vector3d& tip_mm) {
  const machine::KnownErrors errors{model, covariance};
  ToolPoint tool(machine, errors, tip_mm);
  Eigen::MatrixXd out(3 * poses.count(), covariance.root.cols());
  for (int k = 0; k < poses.count(); ++k)
    out.middleRows<3>(3 * k) = tool.ByNumberAt(poses.At(k)).topRows<3>() * covariance.root;
  return out;
}

ChanceOver ChanceOf(const Eigen::MatrixXd& spread) {
  base::Random random(kPosesSeed);
  std::vector<double> rms, max;
  Eigen::VectorXd z(spread.cols());
  for (int i = 0; i < kChanceDraws; ++i) {
    for (double& one : z) one = random.Normal();
    const Eigen::VectorXd drawn = spread * z;
    rms.push_back(RmsOver(drawn));
    max.push_back(drawn.segment<3>(3 * LongestAt(drawn)).norm());
  }
  return {QuantileOf(std::move(rms)), QuantileOf(std::move(max))};
}

}  // namespace axiscal::predict
