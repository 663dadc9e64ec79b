#include "core/compensate/orientation.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/compensate/folded_chain.h"

namespace axiscal::compensate {
namespace {

constexpr int kMaxIterations = 60;
// The last step turns the tool, and the axes, by less.
constexpr double kLastTurnRad = 1e-12, kLastStepRad = 1e-9;
// Squares of singular values below this: round-off would turn the axis, and within a bound it could do nothing.
constexpr double kNoTurnSquared = 1e-12;

using Jacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, machine::kMaxAxes>;
using Change = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, machine::kMaxAxes, 1>;
using Gram = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, machine::kMaxAxes, machine::kMaxAxes>;

struct Answer {
  Change change;
  DirectionLimit limit = DirectionLimit::kNone;
  double needed_rad = 0;
  double least_turn = 0;
};

// The squares of the singular values of J, ascending, and v_k.
struct Parts {
  Change squares;
  Gram directions;
};

// Of two axes by one rotation that makes their columns orthogonal (Jacobi): nearly every machine has two, and this runs
// for every block.
Parts PartsOf(const Jacobian& jacobian) {
  if (jacobian.cols() != 2) {
    const Eigen::SelfAdjointEigenSolver<Gram> solver(jacobian.transpose() * jacobian);
    return {solver.eigenvalues(), solver.eigenvectors()};
  }
  const Eigen::Vector3d a = jacobian.col(0), b = jacobian.col(1);
  const double aa = a.squaredNorm(), bb = b.squaredNorm(), ab = a.dot(b);
  const double angle = 0.5 * std::atan2(2.0 * ab, aa - bb);  // of the larger one
  const double c = std::cos(angle), s = std::sin(angle);
  Parts parts{Change(2), Gram(2, 2)};
  parts.squares << (b * c - a * s).squaredNorm(), (a * c + b * s).squaredNorm();
  parts.directions << -s, c, c, s;
  return parts;
}

// The formula of the header.
Answer TurnTowards(const Jacobian& jacobian, const Eigen::Vector3d& wanted, double bound_rad) {
  const Parts parts = PartsOf(jacobian);
  Answer answer;
  answer.change = Change::Zero(jacobian.cols());
  if (jacobian.cols() > 0) answer.least_turn = std::sqrt(std::max(0.0, parts.squares[0]));
  for (Eigen::Index k = 0; k < jacobian.cols(); ++k) {
    const double squared = parts.squares[k];
    if (!(squared > kNoTurnSquared)) continue;
    const Change direction = parts.directions.col(k);
    const double projected = (jacobian * direction).dot(wanted);  // s_k (u_k e)
    const double exact = projected / squared;
    if (std::abs(exact) <= bound_rad) {
      answer.change += direction * exact;
      continue;
    }
    answer.limit = DirectionLimit::kBound;
    answer.needed_rad = std::max(answer.needed_rad, std::abs(exact));
    answer.change += direction * (squared * bound_rad * bound_rad / projected);
  }
  // Two directions at once may add up to more.
  const double largest = answer.change.size() > 0 ? answer.change.cwiseAbs().maxCoeff() : 0.0;
  if (largest > bound_rad) {
    answer.limit = DirectionLimit::kBound;
    answer.needed_rad = std::max(answer.needed_rad, largest);
    answer.change *= bound_rad / largest;
  }
  return answer;
}

// The rotary axes of a machine at one programmed pose.
class Solver {
 public:
  Solver(const Compensator& compensator, const Pose& pose, double bound_rad)
      : compensator_(compensator), pose_(pose), bound_rad_(bound_rad) {
    for (int i = 0; i < compensator.machine().axis_count(); ++i) {
      if (compensator.machine().axes[i].kind == machine::AxisKind::kRotary) axes_.push_back(i);
    }
    count_ = static_cast<Eigen::Index>(axes_.size());
  }

  absl::Status Run(const AxisValues& near, Turned* turned) {
    const Eigen::Vector3d wanted = compensator_.NominalDirection(pose_);
    Pose commanded = pose_;
    AxisValues near_mm = near;
    for (int i = 0; i < compensator_.machine().axis_count(); ++i) commanded.position[i] += near[i];
    Change change(count_);
    for (Eigen::Index k = 0; k < count_; ++k) change[k] = near[axes_[static_cast<size_t>(k)]];
    for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
      TurnColumns columns;
      compensator_.Aim(commanded, &columns);
      const Eigen::Vector3d lacking = wanted - columns.direction_in_table;
      Jacobian jacobian(3, count_);
      for (Eigen::Index k = 0; k < count_; ++k)
        jacobian.col(k) = columns.direction_per_rad[axes_[static_cast<size_t>(k)]];
      const Answer answer = WithinTravel(jacobian, lacking + jacobian * change);
      const Change step = answer.change - change;
      if (!step.allFinite()) break;
      const bool is_last = (jacobian * step).norm() < kLastTurnRad && step.norm() < kLastStepRad;
      change = answer.change;
      for (Eigen::Index k = 0; k < count_; ++k) {
        const int axis = axes_[static_cast<size_t>(k)];
        commanded.position[axis] = pose_.position[axis] + change[k];
      }
      if (is_last) {
        turned->position = commanded.position;
        turned->tilt_left_rad = wanted.cross(columns.direction_in_table).norm();
        turned->limit = DirectionLimit::kNone;
        turned->needed_rad = answer.needed_rad;
        turned->least_turn = answer.least_turn;
        if (turned->tilt_left_rad > kDirectionToleranceRad)
          turned->limit = answer.limit == DirectionLimit::kNone ? DirectionLimit::kNoAxis : answer.limit;
        return absl::OkStatus();
      }
      if (compensator_.is_constant()) continue;
      // Errors that vary with the position act at the commands of the linear axes too.
      Correction linear;
      RETURN_IF_ERROR(compensator_.CorrectTurned(pose_, commanded.position, near_mm, &linear));
      for (const int axis : compensator_.linear_axes()) {
        commanded.position[axis] = linear.corrected[axis];
        near_mm[axis] = linear.corrected[axis] - pose_.position[axis];
      }
    }
    return absl::FailedPreconditionError(
        absl::StrFormat("no rotary commands found that turn the tool as programmed within %d steps, the errors are too "
                        "large",
                        kMaxIterations));
  }

 private:
  // Axes that would leave their travel stop at its end; the others turn the tool as far as they can.
  Answer WithinTravel(const Jacobian& jacobian, const Eigen::Vector3d& wanted) const {
    Jacobian free = jacobian;
    Eigen::Vector3d rest = wanted;
    Change stopped = Change::Zero(count_);
    bool is_any_stopped = false;
    for (Eigen::Index round = 0;; ++round) {
      Answer answer = TurnTowards(free, rest, bound_rad_);
      answer.change += stopped;
      if (is_any_stopped) answer.limit = DirectionLimit::kTravel;
      bool is_within = true;
      for (Eigen::Index k = 0; k < count_; ++k) {
        const double change = InTravel(axes_[static_cast<size_t>(k)], answer.change[k]);
        if (change == answer.change[k] || free.col(k).isZero(0.0)) continue;
        is_within = false;
        stopped[k] = change;
        rest -= jacobian.col(k) * change;
        free.col(k).setZero();
        break;
      }
      if (is_within || round > count_) return answer;
      is_any_stopped = true;
    }
  }

  // The change that keeps the axis within its travel; a programmed position beyond it is reported elsewhere.
  double InTravel(int axis, double change) const {
    const machine::Axis& limits = compensator_.machine().axes[axis];
    const double programmed = pose_.position[axis];
    if (limits.max_position) change = std::min(change, std::max(0.0, *limits.max_position - programmed));
    if (limits.min_position) change = std::max(change, std::min(0.0, *limits.min_position - programmed));
    return change;
  }

  const Compensator& compensator_;
  const Pose& pose_;
  const double bound_rad_;
  std::vector<int> axes_;
  Eigen::Index count_ = 0;
};

}  // namespace

absl::Status CorrectDirection(const Compensator& compensator, const Pose& pose, double bound_rad,
                              const AxisValues& near, Turned* turned) {
  for (int i = 0; i < compensator.machine().axis_count(); ++i) {
    if (!std::isfinite(pose.position[i])) {
      return absl::InvalidArgumentError(
          absl::StrCat("axis ", compensator.machine().axes[i].name, " = ", pose.position[i], ", must be finite"));
    }
  }
  return Solver(compensator, pose, bound_rad).Run(near, turned);
}

std::string ToString(const Turned& turned, double bound_rad) {
  switch (turned.limit) {
    case DirectionLimit::kNone:
      return "reached";
    case DirectionLimit::kNoAxis:
      return "no rotary axis turns the tool that way in this pose";
    case DirectionLimit::kBound:
      return absl::StrFormat("the pose is nearly singular: a turn of %.3g deg would be needed, the bound is %.3g deg",
                             turned.needed_rad * base::kDegPerRad, bound_rad * base::kDegPerRad);
    case DirectionLimit::kTravel:
      return "a rotary axis would leave its travel";
  }
  return "unknown limit";
}

}  // namespace axiscal::compensate
