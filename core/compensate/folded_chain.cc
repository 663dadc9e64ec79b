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

// About a coordinate axis by the angle of this sine and cosine; `a` turns towards `b`.
inline void TurnPlane(double s, double c, double* a, double* b) {
  const double before = *a;
  *a = c * before - s * *b;
  *b = s * before + c * *b;
}

struct Turn {
  const FoldedChain::Stage& stage;
  double s, one_minus_cosine;

  void Apply(Eigen::Vector3d* v) const {
    const double c = 1.0 - one_minus_cosine;
    switch (stage.turn_coordinate) {
      case 0:
        return TurnPlane(s, c, &v->y(), &v->z());
      case 1:
        return TurnPlane(s, c, &v->z(), &v->x());
      case 2:
        return TurnPlane(s, c, &v->x(), &v->y());
      default:
        *v = Turned(stage.turn_direction, s, one_minus_cosine, *v);
    }
  }
};

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
    stage.has_rotation = true;
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
    for (int k = 0; k < 3; ++k) {
      if (axis.direction == Eigen::Vector3d::Unit(k)) stage.turn_coordinate = k;
    }
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
  absl::InlinedVector<FoldedChain::Stage, 4>& stages_;
};

}  // namespace

void SetMap(const machine::Machine& machine, int joint, const machine::ErrorVector<double>& error, JointMaps* maps) {
  maps->is_identity[joint] = (error.array() == 0.0).all();
  if (maps->is_identity[joint]) return;
  const bool is_work =
      joint == machine.work_joint() ||
      std::find(machine.work_branch.begin(), machine.work_branch.end(), joint) != machine.work_branch.end();
  const Rigid<double> map = machine::ErrorTransform<double>(error, machine::ErrorPoint(machine, joint));
  maps->of_joint[joint] = is_work ? map.Inverse() : map;
}

void Fold(const machine::Machine& machine, const std::vector<int>& linear_axes, const JointMaps& maps,
          FoldedChain* chain) {
  Folder folder(machine, linear_axes, chain);
  const auto constant = [&](int joint) {
    if (!maps.is_identity[joint]) folder.Constant(maps.of_joint[joint]);
  };
  constant(machine.tool_joint());
  for (auto axis = machine.tool_branch.rbegin(); axis != machine.tool_branch.rend(); ++axis) {
    folder.Motion(*axis, +1.0);
    constant(*axis);
  }
  for (const int axis : machine.work_branch) {
    constant(axis);
    folder.Motion(axis, -1.0);
  }
  constant(machine.work_joint());
}

void Fold(const machine::Machine& machine, const std::vector<int>& linear_axes,
          const machine::JointErrors<double>& errors, FoldedChain* chain) {
  JointMaps maps;
  for (int joint = 0; joint < machine.joint_count(); ++joint) SetMap(machine, joint, errors[joint], &maps);
  Fold(machine, linear_axes, maps, chain);
}

void EvaluateTurns(const machine::Machine& machine, const double* positions, Turns* turns) {
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (machine.axes[i].kind != machine::AxisKind::kRotary) continue;
    double cosine = 0;
    sincos(positions[i], &turns->sine[i], &cosine);  // of glibc: half the time of two calls
    turns->one_minus_cosine[i] = 1.0 - cosine;
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
    if (stage.has_rotation) {
      tip = Times(stage.rotation, tip);
      direction = Times(stage.rotation, direction);
      for (int k = 0; with_columns && any_columns && k < count; ++k)
        columns.of_axis[k] = Times(stage.rotation, columns.of_axis[k]);
    }
    tip += stage.translation_mm;
    if (stage.has_columns) {
      for (int k = 0; k < count; ++k) {
        tip += stage.columns.of_axis[k] * linear_mm[k];
        if (with_columns)
          columns.of_axis[k] = any_columns ? columns.of_axis[k] + stage.columns.of_axis[k] : stage.columns.of_axis[k];
      }
      any_columns = true;
    }
    if (stage.turn_axis < 0) continue;
    const Turn turn{stage, stage.turn_sign * turns.sine[stage.turn_axis], turns.one_minus_cosine[stage.turn_axis]};
    turn.Apply(&tip);
    turn.Apply(&direction);
    for (int k = 0; with_columns && any_columns && k < count; ++k) turn.Apply(&columns.of_axis[k]);
  }
  if (with_columns && !any_columns) {
    for (int k = 0; k < count; ++k) columns.of_axis[k].setZero();
  }
  out->tip_in_table_mm = tip;
  out->direction_in_table = direction;
}

}  // namespace axiscal::compensate
