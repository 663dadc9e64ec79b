#include "core/compensate/folded_chain.h"

#include <algorithm>
#include <cmath>

namespace axiscal::compensate {
namespace {

using geometry::Rigid;

// Appends joints from the tool point towards the table: each new map acts on the result of what is there.
class Folder {
 public:
  Folder(const machine::Machine& machine, const std::vector<int>& linear_axes)
      : machine_(machine), linear_axes_(linear_axes), stage_(NewStage()) {}

  void Constant(const Rigid<double>& map) {
    stage_.rotation = map.rotation * stage_.rotation;
    stage_.translation_mm = map * stage_.translation_mm;
    stage_.columns = map.rotation * stage_.columns;
  }

  // `sign` is +1 on the tool branch, -1 on the work branch, whose motions are undone.
  void Motion(int axis_index, double sign) {
    const machine::Axis& axis = machine_.axes[axis_index];
    if (axis.kind == machine::AxisKind::kLinear) {
      const auto at = std::find(linear_axes_.begin(), linear_axes_.end(), axis_index) - linear_axes_.begin();
      stage_.columns.col(at) += sign * axis.direction;
      stage_.has_columns = true;
      return;
    }
    Constant({Eigen::Matrix3d::Identity(), -axis.point_mm});
    stage_.turn_axis = axis_index;
    stage_.turn_sign = sign;
    stage_.turn_skew = geometry::Skew(axis.direction);
    stage_.turn_skew_squared = stage_.turn_skew * stage_.turn_skew;
    chain_.stages.push_back(stage_);
    stage_ = NewStage();
    Constant({Eigen::Matrix3d::Identity(), axis.point_mm});
  }

  FoldedChain Finish() {
    chain_.stages.push_back(stage_);
    return std::move(chain_);
  }

 private:
  FoldedChain::Stage NewStage() const {
    FoldedChain::Stage stage;
    stage.columns = Columns::Zero(3, static_cast<Eigen::Index>(linear_axes_.size()));
    stage.turn_skew = stage.turn_skew_squared = Eigen::Matrix3d::Zero();
    return stage;
  }

  const machine::Machine& machine_;
  const std::vector<int>& linear_axes_;
  FoldedChain chain_;
  FoldedChain::Stage stage_;
};

}  // namespace

FoldedChain Fold(const machine::Machine& machine, const std::vector<int>& linear_axes,
                 const machine::JointErrors<double>& errors) {
  const auto error = [&](int joint) {
    return machine::ErrorTransform<double>(errors[joint], machine::ErrorPoint(machine, joint));
  };
  Folder folder(machine, linear_axes);
  folder.Constant(error(machine.tool_joint()));
  for (auto axis = machine.tool_branch.rbegin(); axis != machine.tool_branch.rend(); ++axis) {
    folder.Motion(*axis, +1.0);
    folder.Constant(error(*axis));
  }
  for (const int axis : machine.work_branch) {
    folder.Constant(error(axis).Inverse());
    folder.Motion(axis, -1.0);
  }
  folder.Constant(error(machine.work_joint()).Inverse());
  return folder.Finish();
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
  Eigen::Vector3d tip = tip_mm;
  Eigen::Vector3d direction = tool_direction;
  const Eigen::Index count = chain.stages.front().columns.cols();
  bool any_columns = false;
  if (with_columns) out->tip_per_mm.setZero(3, count);
  for (const FoldedChain::Stage& stage : chain.stages) {
    Eigen::Matrix3d map = stage.rotation;
    tip = map * tip + stage.translation_mm;
    if (stage.has_columns) {
      for (Eigen::Index k = 0; k < count; ++k) tip += stage.columns.col(k) * linear_mm[k];
    }
    if (stage.turn_axis >= 0) {
      const double s = stage.turn_sign * turns.sine[stage.turn_axis];
      const double v = turns.one_minus_cosine[stage.turn_axis];
      const Eigen::Matrix3d turn = Eigen::Matrix3d::Identity() + s * stage.turn_skew + v * stage.turn_skew_squared;
      tip = turn * tip;
      map = turn * map;
      if (with_columns) {
        for (Eigen::Index k = 0; k < count; ++k) {
          Eigen::Vector3d column =
              stage.has_columns ? Eigen::Vector3d(turn * stage.columns.col(k)) : Eigen::Vector3d::Zero();
          if (any_columns) column += map * out->tip_per_mm.col(k);
          out->tip_per_mm.col(k) = column;
        }
      }
    } else if (with_columns) {
      for (Eigen::Index k = 0; k < count; ++k) {
        Eigen::Vector3d column = stage.columns.col(k);
        if (any_columns) column += map * out->tip_per_mm.col(k);
        out->tip_per_mm.col(k) = column;
      }
    }
    any_columns |= stage.has_columns;
    direction = map * direction;
  }
  out->tip_in_table_mm = tip;
  out->direction_in_table = direction;
}

}  // namespace axiscal::compensate
