#include "core/compensate/folded_chain.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/two_turns.h"

namespace axiscal::compensate {
namespace {

using geometry::Rigid;

// Written out: Eigen's products of fixed size are calls at -O2.
inline Eigen::Vector3d Times(const Eigen::Matrix3d& m, const Eigen::Vector3d& v) {
  return {m(0, 0) * v.x() + m(0, 1) * v.y() + m(0, 2) * v.z(), m(1, 0) * v.x() + m(1, 1) * v.y() + m(1, 2) * v.z(),
          m(2, 0) * v.x() + m(2, 1) * v.y() + m(2, 2) * v.z()};
}

// Two vectors side by side, so that one instruction works on both.
using Two = double __attribute__((vector_size(16)));
struct TwoVectors {
  Two x, y, z;
};

inline TwoVectors Beside(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return {Two{a.x(), b.x()}, Two{a.y(), b.y()}, Two{a.z(), b.z()}};
}
inline Eigen::Vector3d Part(const TwoVectors& v, int index) { return {v.x[index], v.y[index], v.z[index]}; }

inline TwoVectors Times(const Eigen::Matrix3d& m, const TwoVectors& v) {
  return {m(0, 0) * v.x + m(0, 1) * v.y + m(0, 2) * v.z, m(1, 0) * v.x + m(1, 1) * v.y + m(1, 2) * v.z,
          m(2, 0) * v.x + m(2, 1) * v.y + m(2, 2) * v.z};
}

// nullptr: there is none, or it is the identity.
inline const JointMaps::Map* VaryingMap(const FoldedChain::Stage& stage, const JointMaps& maps) {
  const int joint = stage.varying_joint;
  return joint < 0 || maps.is_identity[joint] ? nullptr : &maps.of_joint[joint];
}

// Of a point and a direction.
inline TwoVectors Mapped(const JointMaps::Map& map, const TwoVectors& tool) {
  TwoVectors mapped = Times(map.rotation, tool);
  mapped.x[0] += map.translation_mm.x();
  mapped.y[0] += map.translation_mm.y();
  mapped.z[0] += map.translation_mm.z();
  return mapped;
}

inline TwoVectors Cross(const Eigen::Vector3d& k, const TwoVectors& v) {
  return {k.y() * v.z - k.z() * v.y, k.z() * v.x - k.x() * v.z, k.x() * v.y - k.y() * v.x};
}

// Rodrigues: v + s (k x v) + (1 - c) k x (k x v).
inline TwoVectors Turned(const Eigen::Vector3d& k, double s, double one_minus_cosine, const TwoVectors& v) {
  const TwoVectors once = Cross(k, v), twice = Cross(k, once);
  return {v.x + s * once.x + one_minus_cosine * twice.x, v.y + s * once.y + one_minus_cosine * twice.y,
          v.z + s * once.z + one_minus_cosine * twice.z};
}

// About a coordinate axis by the angle of this sine and cosine; `a` turns towards `b`.
inline void TurnPlane(double s, double c, Two* a, Two* b) {
  const Two before = *a;
  *a = c * before - s * *b;
  *b = s * before + c * *b;
}

struct Turn {
  const FoldedChain::Stage& stage;
  double s, one_minus_cosine;

  void Apply(TwoVectors* v) const {
    const double c = 1.0 - one_minus_cosine;
    switch (stage.turn_coordinate) {
      case 0:
        return TurnPlane(s, c, &v->y, &v->z);
      case 1:
        return TurnPlane(s, c, &v->z, &v->x);
      case 2:
        return TurnPlane(s, c, &v->x, &v->y);
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

  void Varying(int joint) {
    NewStage();
    stages_.back().varying_joint = joint;
  }

  void Constant(const JointMaps::Map& map) {
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
    // One more: Evaluate reads them two by two.
    for (int k = 0; k < stage.columns.count + stage.columns.count % 2; ++k) stage.columns.of_axis[k].setZero();
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
  const Rigid<double> on_the_way = is_work ? map.Inverse() : map;
  maps->of_joint[joint] = {on_the_way.rotation, on_the_way.translation_mm};
}

void Fold(const machine::Machine& machine, const std::vector<int>& linear_axes, const JointMaps& maps,
          const std::vector<int>& varying_joints, FoldedChain* chain) {
  Folder folder(machine, linear_axes, chain);
  const auto constant = [&](int joint) {
    if (std::find(varying_joints.begin(), varying_joints.end(), joint) != varying_joints.end())
      return folder.Varying(joint);
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
  Fold(machine, linear_axes, maps, {}, chain);
}

void EvaluateTurns(const machine::Machine& machine, const double* positions, Turns* turns) {
  const auto set = [turns](int axis, const geometry::TwoTurns& two, int index) {
    turns->sine[axis] = two.sine[index];
    turns->one_minus_cosine[axis] = 1.0 - two.cosine[index];
  };
  int single = -1;
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (machine.axes[i].kind != machine::AxisKind::kRotary) continue;
    if (single < 0) {
      single = i;
      continue;
    }
    const geometry::TwoTurns two = geometry::SineCosineOfTwo(positions[single], positions[i]);
    set(single, two, 0);
    set(i, two, 1);
    single = -1;
  }
  if (single >= 0) set(single, geometry::SineCosineOfTwo(positions[single], 0.0), 0);
}

void Evaluate(const FoldedChain& chain, const JointMaps& maps, const Turns& turns, const double* linear_mm,
              const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& tool_direction, bool with_columns, AffineTip* out) {
  TwoVectors tool = Beside(tip_mm, tool_direction);
  const int count = chain.stages.front().columns.count, pairs = with_columns ? (count + 1) / 2 : 0;
  TwoVectors columns[(machine::kMaxAxes + 1) / 2];
  for (int k = 0; k < pairs; ++k) columns[k] = Beside(Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  int moved_pairs = 0;  // pairs, or 0 where no column differs from zero yet
  for (const FoldedChain::Stage& stage : chain.stages) {
    if (const JointMaps::Map* const map = VaryingMap(stage, maps)) {
      tool = Mapped(*map, tool);
      for (int k = 0; k < moved_pairs; ++k) columns[k] = Times(map->rotation, columns[k]);
    }
    if (stage.has_rotation) {
      tool = Times(stage.rotation, tool);
      for (int k = 0; k < moved_pairs; ++k) columns[k] = Times(stage.rotation, columns[k]);
    }
    Eigen::Vector3d move_mm = stage.translation_mm;
    if (stage.has_columns) {
      const auto& own = stage.columns.of_axis;  // zero behind the last one
      for (int k = 0; k < count; ++k) move_mm += own[static_cast<size_t>(k)] * linear_mm[k];
      for (int k = 0; k < pairs; ++k) {
        const TwoVectors two = Beside(own[static_cast<size_t>(2 * k)], own[static_cast<size_t>(2 * k + 1)]);
        columns[k].x += two.x;
        columns[k].y += two.y;
        columns[k].z += two.z;
      }
      moved_pairs = pairs;
    }
    tool.x[0] += move_mm.x();
    tool.y[0] += move_mm.y();
    tool.z[0] += move_mm.z();
    if (stage.turn_axis < 0) continue;
    const Turn turn{stage, stage.turn_sign * turns.sine[stage.turn_axis], turns.one_minus_cosine[stage.turn_axis]};
    turn.Apply(&tool);
    for (int k = 0; k < moved_pairs; ++k) turn.Apply(&columns[k]);
  }
  out->tip_in_table_mm = Part(tool, 0);
  out->direction_in_table = Part(tool, 1);
  out->tip_per_mm.count = count;
  for (int k = 0; k < pairs; ++k) {
    out->tip_per_mm.of_axis[static_cast<size_t>(2 * k)] = Part(columns[k], 0);
    if (2 * k + 1 < count) out->tip_per_mm.of_axis[static_cast<size_t>(2 * k + 1)] = Part(columns[k], 1);
  }
}

void EvaluateTurnColumns(const FoldedChain& chain, const JointMaps& maps, const Turns& turns, const double* linear_mm,
                         const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& tool_direction, TurnColumns* out) {
  TwoVectors tool = Beside(tip_mm, tool_direction);
  TwoVectors columns[machine::kMaxAxes];  // of axes[0], axes[1] ...: of the tool point, of the direction
  int axes[machine::kMaxAxes], count = 0;
  for (const FoldedChain::Stage& stage : chain.stages) {
    if (const JointMaps::Map* const map = VaryingMap(stage, maps)) {
      tool = Mapped(*map, tool);
      for (int k = 0; k < count; ++k) columns[k] = Times(map->rotation, columns[k]);
    }
    if (stage.has_rotation) {
      tool = Times(stage.rotation, tool);
      for (int k = 0; k < count; ++k) columns[k] = Times(stage.rotation, columns[k]);
    }
    Eigen::Vector3d move_mm = stage.translation_mm;
    for (int k = 0; stage.has_columns && k < stage.columns.count; ++k)
      move_mm += stage.columns.of_axis[static_cast<size_t>(k)] * linear_mm[k];
    tool.x[0] += move_mm.x();
    tool.y[0] += move_mm.y();
    tool.z[0] += move_mm.z();
    if (stage.turn_axis < 0) continue;
    const Turn turn{stage, stage.turn_sign * turns.sine[stage.turn_axis], turns.one_minus_cosine[stage.turn_axis]};
    turn.Apply(&tool);
    for (int k = 0; k < count; ++k) turn.Apply(&columns[k]);
    axes[count] = stage.turn_axis;
    columns[count++] = Cross(stage.turn_sign * stage.turn_direction, tool);
  }
  out->tip_per_rad.fill(Eigen::Vector3d::Zero());
  out->direction_per_rad.fill(Eigen::Vector3d::Zero());
  for (int k = 0; k < count; ++k) {
    out->tip_per_rad[static_cast<size_t>(axes[k])] = Part(columns[k], 0);
    out->direction_per_rad[static_cast<size_t>(axes[k])] = Part(columns[k], 1);
  }
  out->direction_in_table = Part(tool, 1);
}

}  // namespace axiscal::compensate
