#include "core/compensate/folded_chain.h"

#include <algorithm>
#include <cmath>

namespace axiscal::compensate {
namespace {

using geometry::Rigid;

// Written out: Eigen's products of fixed size are calls at -O2.
inline Eigen::Vector3d Times(const Eigen::Matrix3d& m, const Eigen::Vector3d& v) {
  return {m(0, 0) * v.x() + m(0, 1) * v.y() + m(0, 2) * v.z(), m(1, 0) * v.x() + m(1, 1) * v.y() + m(1, 2) * v.z(),
          m(2, 0) * v.x() + m(2, 1) * v.y() + m(2, 2) * v.z()};
}

// Rodrigues: v + s (k x v) + (1 - c) k x (k x v).
inline Eigen::Vector3d Turned(const Eigen::Vector3d& k, double s, double one_minus_cosine, const Eigen::Vector3d& v) {
  const Eigen::Vector3d once(k.y() * v.z() - k.z() * v.y(), k.z() * v.x() - k.x() * v.z(),
                             k.x() * v.y() - k.y() * v.x());
  const Eigen::Vector3d twice(k.y() * once.z() - k.z() * once.y(), k.z() * once.x() - k.x() * once.z(),
                              k.x() * once.y() - k.y() * once.x());
  return {v.x() + s * once.x() + one_minus_cosine * twice.x(), v.y() + s * once.y() + one_minus_cosine * twice.y(),
          v.z() + s * once.z() + one_minus_cosine * twice.z()};
}

// Appends joints from the tool point towards the table: each new map acts on the result of what is there.
class Folder {
 public:
  Folder(const machine::Machine& machine, const std::vector<int>& linear_axes, FoldedChain* chain)
      : machine_(machine), linear_axes_(linear_axes), stages_(chain->stages) {
    stages_.clear();
    NewStage();
  }

  void Constant(const Rigid<double>& map) {
    FoldedChain::Stage& stage = stages_.back();
    const Eigen::Matrix3d rotation = stage.rotation;
    for (int k = 0; k < 3; ++k) stage.rotation.col(k) = Times(map.rotation, rotation.col(k));
    stage.translation_mm = Times(map.rotation, stage.translation_mm) + map.translation_mm;
    for (int k = 0; stage.has_columns && k < stage.columns.count; ++k) {
      stage.columns.of_axis[k] = Times(map.rotation, stage.columns.of_axis[k]);
    }
  }

  void Shift(const Eigen::Vector3d& by_mm) { stages_.back().translation_mm += by_mm; }

  // `sign` is +1 on the tool branch, -1 on the work branch, whose motions are undone.
  void Motion(int axis_index, double sign) {
    const machine::Axis& axis = machine_.axes[axis_index];
    FoldedChain::Stage& stage = stages_.back();
    if (axis.kind == machine::AxisKind::kLinear) {
      const auto at = std::find(linear_axes_.begin(), linear_axes_.end(), axis_index) - linear_axes_.begin();
      stage.columns.of_axis[static_cast<size_t>(at)] += sign * axis.direction;
      stage.has_columns = true;
      return;
    }
    Shift(-axis.point_mm);
    stage.turn_axis = axis_index;
    stage.turn_sign = sign;
    stage.turn_direction = axis.direction;
    NewStage();
    Shift(axis.point_mm);
  }

 private:
  void NewStage() {
    FoldedChain::Stage& stage = stages_.emplace_back();
    stage.columns.count = static_cast<int>(linear_axes_.size());
    for (int k = 0; k < stage.columns.count; ++k) stage.columns.of_axis[k].setZero();
  }

  const machine::Machine& machine_;
  const std::vector<int>& linear_axes_;
  std::vector<FoldedChain::Stage>& stages_;
};

}  // namespace

void Fold(const machine::Machine& machine, const std::vector<int>& linear_axes,
          const machine::JointErrors<double>& errors, FoldedChain* chain) {
  const auto is_zero = [&](int joint) { return (errors[joint].array() == 0.0).all(); };
  const auto error = [&](int joint) {
    return machine::ErrorTransform<double>(errors[joint], machine::ErrorPoint(machine, joint));
  };
  Folder folder(machine, linear_axes, chain);
  if (!is_zero(machine.tool_joint())) folder.Constant(error(machine.tool_joint()));
  for (auto axis = machine.tool_branch.rbegin(); axis != machine.tool_branch.rend(); ++axis) {
    folder.Motion(*axis, +1.0);
    if (!is_zero(*axis)) folder.Constant(error(*axis));
  }
  for (const int axis : machine.work_branch) {
    if (!is_zero(axis)) folder.Constant(error(axis).Inverse());
    folder.Motion(axis, -1.0);
  }
  if (!is_zero(machine.work_joint())) folder.Constant(error(machine.work_joint()).Inverse());
}

void EvaluateTurns(const machine::Machine& machine, const double* positions, Turns* turns) {
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (machine.axes[i].kind != machine::AxisKind::kRotary) continue;
    turns->sine[i] = std::sin(positions[i]);
    turns->one_minus_cosine[i] = 1.0 - std::cos(positions[i]);
  }
}

void Evaluate(const FoldedChain& chain, const Turns& turns, const double* linear_mm, const Eigen::Vector3d& tip_mm,
              const Eigen::Vector3d& tool_direction, bool with_columns, AffineTip* out) {
  Eigen::Vector3d tip = tip_mm, direction = tool_direction;
  const int count = chain.stages.front().columns.count;
  Columns& columns = out->tip_per_mm;
  columns.count = count;
  bool any_columns = false;
  for (const FoldedChain::Stage& stage : chain.stages) {
    tip = Times(stage.rotation, tip) + stage.translation_mm;
    direction = Times(stage.rotation, direction);
    if (with_columns && any_columns) {
      for (int k = 0; k < count; ++k) columns.of_axis[k] = Times(stage.rotation, columns.of_axis[k]);
    }
    if (stage.has_columns) {
      for (int k = 0; k < count; ++k) {
        tip += stage.columns.of_axis[k] * linear_mm[k];
        if (with_columns)
          columns.of_axis[k] = any_columns ? columns.of_axis[k] + stage.columns.of_axis[k] : stage.columns.of_axis[k];
      }
      any_columns = true;
    }
    if (stage.turn_axis < 0) continue;
    const double s = stage.turn_sign * turns.sine[stage.turn_axis];
    const double v = turns.one_minus_cosine[stage.turn_axis];
    tip = Turned(stage.turn_direction, s, v, tip);
    direction = Turned(stage.turn_direction, s, v, direction);
    for (int k = 0; with_columns && any_columns && k < count; ++k) {
      columns.of_axis[k] = Turned(stage.turn_direction, s, v, columns.of_axis[k]);
    }
  }
  if (with_columns && !any_columns) {
    for (int k = 0; k < count; ++k) columns.of_axis[k].setZero();
  }
  out->tip_in_table_mm = tip;
  out->direction_in_table = direction;
}

}  // namespace axiscal::compensate
