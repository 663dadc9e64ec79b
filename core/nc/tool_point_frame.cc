#include "core/nc/tool_point_frame.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/status.h"
#include "core/base/units.h"
#include "core/machine/chain.h"

namespace axiscal::nc {
namespace {

constexpr double kSquare = 1e-9;       // directions of machine.json are unit to that
constexpr double kLeastVolume = 1e-3;  // of three unit directions: below it, they nearly lie in a plane
constexpr double kUpright = 1e-9;      // rad

void ToValues(const machine::Machine& machine, const AxisTicks& ticks, double* values) {
  for (int i = 0; i < machine.axis_count(); ++i) {
    const bool is_rotary = machine.axes[i].kind == machine::AxisKind::kRotary;
    values[i] = static_cast<double>(ticks[i]) / kTicksPerUnit * (is_rotary ? base::kRadPerDeg : 1.0);
  }
}

}  // namespace

ToolPointFrame::ToolPointFrame(const machine::Machine& machine, const Eigen::Vector3d& gauge_mm)
    : machine_(&machine), gauge_mm_(gauge_mm) {
  static constexpr const char* kNames[] = {"X", "Y", "Z"};
  int rotary_count = 0;
  for (size_t k = 0; k < 3; ++k) xyz_[k] = machine::FindAxis(machine, kNames[k]);
  for (int i = 0; i < machine.axis_count(); ++i) {
    const bool is_rotary = machine.axes[i].kind == machine::AxisKind::kRotary;
    rotary_count += is_rotary;
    if (!is_rotary && i != xyz_[0] && i != xyz_[1] && i != xyz_[2])
      problem_ = absl::StrCat("machine '", machine.id, "' has the linear axis ", machine.axes[i].name,
                              " beside X, Y and Z, and how the control's kinematics count it is not known");
  }
  for (const int axis : xyz_) {
    if (axis < 0 || machine.axes[axis].kind != machine::AxisKind::kLinear)
      problem_ = absl::StrCat("machine '", machine.id, "' lacks one of the linear axes X, Y and Z");
  }
  if (rotary_count == 0) problem_ = absl::StrCat("machine '", machine.id, "' has no rotary axis");
  if (!problem_.empty()) return;
  const std::array<double, machine::kMaxAxes> home{};
  Eigen::Vector3d tip_mm, direction;
  Evaluate(home.data(), 0.0, &home_, &tip_mm, &direction);
  if (!(home_.transpose() * home_ - Eigen::Matrix3d::Identity()).isZero(kSquare)) {
    problem_ = absl::StrCat("X, Y and Z of machine '", machine.id,
                            "' do not stand at right angles at home, and how the control counts words is not known");
  } else if (!(direction + home_.col(2)).isZero(kSquare)) {
    problem_ = absl::StrCat("the tool of machine '", machine.id,
                            "' does not stand along Z at home, and how its length is counted is not known");
  }
}

void ToolPointFrame::Evaluate(const double* positions, double length_mm, Eigen::Matrix3d* columns,
                              Eigen::Vector3d* tip_mm, Eigen::Vector3d* direction) const {
  geometry::Rigid<double> ends[2];
  for (const bool is_work : {false, true}) {
    geometry::Rigid<double>& bed = ends[is_work];
    for (const int axis : is_work ? machine_->work_branch : machine_->tool_branch) {
      const machine::Axis& moved = machine_->axes[axis];
      if (moved.kind == machine::AxisKind::kRotary) {
        machine::AppendMotion<double>(moved, positions[axis], &bed);
        continue;
      }
      for (int k = 0; k < 3; ++k) {
        if (xyz_[static_cast<size_t>(k)] == axis)
          columns->col(k) = (is_work ? -1.0 : 1.0) * (bed.rotation * moved.direction);
      }
    }
  }
  const Eigen::Matrix3d table_from_bed = ends[1].rotation.transpose();
  *columns = Eigen::Matrix3d(table_from_bed * *columns);
  const Eigen::Vector3d tip_at_home_mm = gauge_mm_ + length_mm * machine_->tool_direction;
  *tip_mm = table_from_bed * (ends[0] * tip_at_home_mm - ends[1].translation_mm);
  *direction = table_from_bed * (ends[0].rotation * machine_->tool_direction);
}

bool ToolPointFrame::At(const double* positions, double length_mm, const WordFrame* placed, Map* map) const {
  if (placed != nullptr && placed->base == WordFrame::Base::kAxes) {
    map->axes_of_words = placed->linear;
    map->words_of_axes = placed->inverse;
    map->at_zero_mm = -(placed->inverse * placed->shift_mm);
    return true;
  }
  Eigen::Matrix3d columns;
  Eigen::Vector3d tip_mm, direction;
  Evaluate(positions, length_mm, &columns, &tip_mm, &direction);
  map->words_of_axes = home_.transpose() * columns;
  map->at_zero_mm = home_.transpose() * (tip_mm - gauge_mm_);
  map->direction = home_.transpose() * direction;
  const double volume = map->words_of_axes.determinant();
  if (!(std::abs(volume) > kLeastVolume)) return false;
  map->axes_of_words = map->words_of_axes.inverse();
  if (placed == nullptr) return true;
  if (placed->base == WordFrame::Base::kOrigin) {
    const Eigen::Vector3d carried_mm = map->axes_of_words * (placed->shift_mm - map->at_zero_mm);
    map->at_zero_mm = placed->shift_mm - carried_mm;
    map->words_of_axes = map->axes_of_words = Eigen::Matrix3d::Identity();
    return true;
  }
  map->at_zero_mm = placed->inverse * (map->at_zero_mm - placed->shift_mm);
  map->words_of_axes = placed->inverse * map->words_of_axes;
  map->axes_of_words = map->axes_of_words * placed->linear;
  return true;
}

bool ToolPointFrame::has_xyz() const {
  return std::all_of(xyz_.begin(), xyz_.end(),
                     [this](int axis) { return axis >= 0 && machine_->axes[axis].kind == machine::AxisKind::kLinear; });
}

double ToolPointFrame::Lean(const AxisTicks& ticks, const WordFrame& placed) const {
  std::array<double, machine::kMaxAxes> values{};
  ToValues(*machine_, ticks, values.data());
  Map map;
  if (!At(values.data(), 0.0, nullptr, &map)) return std::numeric_limits<double>::infinity();
  return std::atan2(map.direction.cross(placed.up).norm(), -map.direction.dot(placed.up));
}

Eigen::Vector3d ToolPointFrame::Up(const AxisTicks& ticks) const {
  std::array<double, machine::kMaxAxes> values{};
  ToValues(*machine_, ticks, values.data());
  Eigen::Matrix3d columns;
  Eigen::Vector3d tip_mm, direction;
  Evaluate(values.data(), 0.0, &columns, &tip_mm, &direction);
  return home_.transpose() * -direction;
}

bool ToolPointFrame::ToWords(double length_mm, const WordFrame* placed, double* values) const {
  Map map;
  if (!At(values, length_mm, placed, &map)) return false;
  const Eigen::Vector3d axes(values[xyz_[0]], values[xyz_[1]], values[xyz_[2]]);
  const Eigen::Vector3d words = map.at_zero_mm + map.words_of_axes * axes;
  for (size_t k = 0; k < 3; ++k) values[xyz_[k]] = words[static_cast<Eigen::Index>(k)];
  return true;
}

bool ToolPointFrame::ToAxes(double length_mm, const WordFrame* placed, double* values) const {
  Map map;
  if (!At(values, length_mm, placed, &map)) return false;
  const Eigen::Vector3d words(values[xyz_[0]], values[xyz_[1]], values[xyz_[2]]);
  const Eigen::Vector3d axes = map.axes_of_words * (words - map.at_zero_mm);
  for (size_t k = 0; k < 3; ++k) values[xyz_[k]] = axes[static_cast<Eigen::Index>(k)];
  return true;
}

bool ToolPointFrame::ToWords(double length_mm, AxisTicks* ticks) const {
  std::array<double, machine::kMaxAxes> values{};
  ToValues(*machine_, *ticks, values.data());
  if (!ToWords(length_mm, nullptr, values.data())) return false;
  for (const int axis : xyz_) (*ticks)[axis] = std::llround(values[axis] * kTicksPerUnit);
  return true;
}

bool ToolPointFrame::ToAxes(double length_mm, AxisTicks* ticks) const {
  std::array<double, machine::kMaxAxes> values{};
  ToValues(*machine_, *ticks, values.data());
  if (!ToAxes(length_mm, nullptr, values.data())) return false;
  for (const int axis : xyz_) (*ticks)[axis] = std::llround(values[axis] * kTicksPerUnit);
  return true;
}

bool ToolPointFrame::IsAlongZ(const AxisTicks& ticks) const {
  std::array<double, machine::kMaxAxes> values{};
  ToValues(*machine_, ticks, values.data());
  Map map;
  constexpr double kMostLeanRad = 5e-4;  // words of rotary axes have three decimals
  return At(values.data(), 0.0, nullptr, &map) && (map.direction + map.words_of_axes.col(2)).norm() <= kMostLeanRad;
}

bool ToolPointFrame::IsUpright(const AxisTicks& ticks) const {
  std::array<double, machine::kMaxAxes> values{};
  ToValues(*machine_, ticks, values.data());
  Map map;
  const Eigen::Vector3d up(0, 0, 1);
  return At(values.data(), 0.0, nullptr, &map) && (map.words_of_axes.col(2) - up).isZero(kUpright) &&
         (map.direction + up).isZero(kUpright);
}

}  // namespace axiscal::nc
