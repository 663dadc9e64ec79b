// The chain of core/machine/chain.h, folded: from the tool point through the bed to the table all joints between two
// rotary axes (or joints whose errors vary) are one constant affine map of the point and the linear axes'
// commands. The same numbers (a test compares the two) in a tenth of the time:
//   x -> rotation * x + translation + columns * q_linear, then the turn of a rotary axis, and so on.
// A joint whose errors vary begins a stage with its map at the pose.
#ifndef AXISCAL_CORE_COMPENSATE_FOLDED_CHAIN_H_
#define AXISCAL_CORE_COMPENSATE_FOLDED_CHAIN_H_

#include <Eigen/Core>
#include <array>
#include <vector>

#include "absl/container/inlined_vector.h"
#include "core/machine/chain.h"

namespace axiscal::compensate {

// Column k: the tool point's motion per mm of linear axis k (in the caller's order).
struct Columns {
  int count = 0;
  std::array<Eigen::Vector3d, machine::kMaxAxes> of_axis;
};

struct FoldedChain {
  struct Stage {
    int varying_joint = -1;  // whose map comes first; -1: none
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    bool has_rotation = false;  // else it is the identity
    Eigen::Vector3d translation_mm = Eigen::Vector3d::Zero();
    Columns columns;  // zero where the axis is in another stage
    bool has_columns = false;
    // The turn that follows: about turn_direction by turn_sign * position of the axis; -1: none, the last stage.
    int turn_axis = -1;
    double turn_sign = 1.0;
    Eigen::Vector3d turn_direction = Eigen::Vector3d::Zero();
    int turn_coordinate = -1;  // 0, 1, 2 where the direction is +X, +Y, +Z
  };
  absl::InlinedVector<Stage, 4> stages;  // from the tool point to the table
};

// The map of each joint's error on the way from the tool point to the table: E on the tool branch, its inverse on the
// work branch. Maps that are the identity are not filled.
struct JointMaps {
  struct Map {
    Eigen::Matrix3d rotation;
    Eigen::Vector3d translation_mm;
  };
  std::array<Map, machine::kMaxJoints> of_joint;
  std::array<bool, machine::kMaxJoints> is_identity;

  JointMaps() { is_identity.fill(true); }
};
void SetMap(const machine::Machine& machine, int joint, const machine::ErrorVector<double>& error, JointMaps* maps);

// `linear_axes`: indices into machine.axes, in the order of columns. The maps of `varying_joints` are not folded:
// Evaluate gets them for each pose.
void Fold(const machine::Machine& machine, const std::vector<int>& linear_axes, const JointMaps& maps,
          const std::vector<int>& varying_joints, FoldedChain* chain);
void Fold(const machine::Machine& machine, const std::vector<int>& linear_axes,
          const machine::JointErrors<double>& errors, FoldedChain* chain);

struct AffineTip {
  Eigen::Vector3d tip_in_table_mm;     // with the linear axes at the positions given
  Eigen::Vector3d direction_in_table;  // unit
  Columns tip_per_mm;
};

// Sine and cosine of every rotary axis, shared by chains that stand at the same pose.
struct Turns {
  double sine[machine::kMaxAxes];
  double one_minus_cosine[machine::kMaxAxes];
};
void EvaluateTurns(const machine::Machine& machine, const double* positions, Turns* turns);

// `maps`: of the varying joints at the pose, the others are not looked at. `linear_mm`: positions of the linear axes in
// the order of columns. Columns are only computed on request.
void Evaluate(const FoldedChain& chain, const JointMaps& maps, const Turns& turns, const double* linear_mm,
              const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& tool_direction, bool with_columns, AffineTip* out);

// How the tool moves when rotary axes turn, per rad; indexed like machine.axes, zero for linear axes.
struct TurnColumns {
  Eigen::Vector3d direction_in_table;  // unit
  std::array<Eigen::Vector3d, machine::kMaxAxes> tip_per_rad, direction_per_rad;
};
void EvaluateTurnColumns(const FoldedChain& chain, const JointMaps& maps, const Turns& turns, const double* linear_mm,
                         const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& tool_direction, TurnColumns* out);

}  // namespace axiscal::compensate

#endif  // AXISCAL_CORE_COMPENSATE_FOLDED_CHAIN_H_
