#include "core/predict/box_poses.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/random.h"
#include "core/base/units.h"

namespace axiscal::predict {
namespace {

using instruments::MeasuringRun;

constexpr uint64_t kPosesSeed = 230;
constexpr size_t kMostCorners = 256;  // of eight axes; more would outnumber the poses that are drawn

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

Box Around(const Box& one, const Box& other) {
  if (one.low.empty() || other.low.empty()) return one.low.empty() ? other : one;
  Box box = one;
  for (size_t i = 0; i < box.low.size(); ++i) {
    box.low[i] = std::min(box.low[i], other.low[i]);
    box.high[i] = std::max(box.high[i], other.high[i]);
  }
  return box;
}

std::vector<reports::AxisRange> RangesOf(const machine::Machine& machine, const Box& box) {
  std::vector<reports::AxisRange> ranges;
  for (size_t i = 0; i < box.low.size(); ++i) {
    const bool is_rotary = machine.axes[i].kind == machine::AxisKind::kRotary;
    const double unit = is_rotary ? base::kDegPerRad : 1.0;
    ranges.push_back({machine.axes[i].name, box.low[i] * unit, box.high[i] * unit, is_rotary ? "deg" : "mm"});
  }
  return ranges;
}

BoxPoses::BoxPoses(const Workspace& workspace) : box_(workspace.box), axes_(box_.low.size()) {
  base::Random random(kPosesSeed);
  const auto add = [&](const std::vector<double>& at) {
    for (const double position : at) {
      positions_.push_back(position);
      shapes::AxisState& axis = axis_states_.emplace_back();
      axis.position = position;
      axis.sense = random.Chance(0.5) ? 1.0 : -1.0;
    }
    shapes::State& state = states_.emplace_back();
    state.time_s = workspace.time_s;
    state.temperature_celsius = workspace.temperature_celsius;
  };
  std::vector<size_t> moving;
  for (size_t i = 0; i < box_.low.size(); ++i)
    if (box_.low[i] < box_.high[i]) moving.push_back(i);
  const size_t corners = size_t{1} << std::min<size_t>(moving.size(), 20);
  if (corners <= kMostCorners) {
    for (size_t corner = 0; corner < corners; ++corner) {
      std::vector<double> at = box_.low;
      for (size_t k = 0; k < moving.size(); ++k)
        if ((corner >> k) & 1) at[moving[k]] = box_.high[moving[k]];
      add(at);
    }
  }
  for (int k = 0; k < workspace.poses; ++k) {
    std::vector<double> at = box_.low;
    for (const size_t i : moving) at[i] = random.Uniform(box_.low[i], box_.high[i]);
    add(at);
  }
}

BoxPoses::BoxPoses(const std::vector<MeasuringRun>& runs, int count, const std::optional<Box>& box)
    : box_(box ? *box : MeasuredBox(runs)), axes_(box_.low.size()) {
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
        const double speed = std::abs(run->AxisStatesOf(k)[i].speed);
        if (std::isfinite(speed)) fastest[i] = std::max(fastest[i], speed);
      }
    }
  }
  base::Random random(kPosesSeed);
  MeasuringRun path;  // positions and motion of the poses
  path.axis_count = axes;
  path.has_time = has_time;
  path.measured_mm.setZero(1, count);
  double time_s = 0.0;
  for (int k = 0; k < count; ++k) {
    for (int i = 0; i < axes; ++i) path.positions.push_back(random.Uniform(box_.low[i], box_.high[i]));
    for (int i = 0; k > 0 && i < axes; ++i) {
      const double way = std::abs(path.PositionsOf(k)[i] - path.PositionsOf(k - 1)[i]);
      if (fastest[i] > 0.0) time_s = std::max(time_s, path.time_s.back() + way / fastest[i]);
    }
    path.time_s.push_back(time_s);
    const auto of_all = static_cast<size_t>(random.Below(readings));
    const auto run = static_cast<size_t>(std::upper_bound(first.begin(), first.end(), of_all) - first.begin()) - 1;
    states_.push_back(measured[run]->StateOf(static_cast<int>(of_all - first[run])));
    states_.back().approach = {};
  }
  instruments::DeriveMotion(&path);
  positions_ = std::move(path.positions);
  axis_states_ = std::move(path.axis_states.Own());
}

shapes::State BoxPoses::At(int pose) const {
  shapes::State state = states_[static_cast<size_t>(pose)];
  state.axes = {axis_states_.data() + static_cast<size_t>(pose) * axes_, axes_};
  return state;
}

}  // namespace axiscal::predict
