#include "core/compensate/table_check.h"

#include <algorithm>

#include "core/machine/chain.h"

namespace axiscal::compensate {
namespace {

constexpr int kLinePoses = 1001;  // over the whole range, besides those within each piece
constexpr double kWithinPiece[] = {0.11, 0.37, 0.5, 0.81};

}  // namespace

std::vector<Pose> PosesAlong(const Pose& reference, int axis, const TableRange& range,
                             const std::vector<double>& nodes) {
  std::vector<double> positions;
  // The golden ratio puts them off every regular grid.
  for (int i = 0; i < kLinePoses; ++i)
    positions.push_back(range.min + (range.max - range.min) * (i + 0.618) / (kLinePoses + 0.236));
  for (size_t i = 0; i + 1 < nodes.size(); ++i) {
    for (const double part : kWithinPiece) {
      const double position = nodes[i] + part * (nodes[i + 1] - nodes[i]);
      if (position >= range.min && position <= range.max) positions.push_back(position);
    }
  }
  std::vector<Pose> poses;
  for (const double position : positions) {
    for (const double sense : {1.0, -1.0}) {
      Pose pose = reference;
      pose.sense.fill(0.0);
      pose.position[axis] = position;
      pose.sense[axis] = sense;
      poses.push_back(pose);
    }
  }
  return poses;
}

std::vector<Pose> PosesWithin(const machine::Machine& machine, const Pose& reference, const TableRanges& ranges,
                              int count) {
  // R_d sequence: fractions of powers of the root of x^(d+1) = x + 1, spread evenly in d dimensions.
  const int dimensions = std::max(1, machine.axis_count());
  double root = 1.5;
  for (int i = 0; i < 50; ++i) root = std::pow(1.0 + root, 1.0 / (dimensions + 1));
  std::vector<Pose> poses;
  for (int n = 1; n <= count; ++n) {
    Pose pose = reference;
    for (int i = 0; i < machine.axis_count(); ++i) {
      const double place = std::fmod(0.5 + n * std::pow(root, -(i + 1)), 1.0);
      if (ranges[i].is_set) pose.position[i] = ranges[i].min + place * (ranges[i].max - ranges[i].min);
      pose.sense[i] = !ranges[i].is_set ? 0.0 : (n >> (i % 11)) & 1 ? 1.0 : -1.0;
    }
    poses.push_back(pose);
  }
  return poses;
}

TableChecker::TableChecker(const machine::Machine& machine, const machine::ErrorModel& errors, const Options& options,
                           const Pose& reference)
    : machine_(machine), errors_(errors), options_(options), reference_(reference) {}

// Where the machine with its errors brings tool point and direction when it is sent to `commanded`.
TableChecker::Seen TableChecker::See(const Positions& commanded, const Pose& pose) const {
  std::array<shapes::AxisState, machine::kMaxAxes> axes;
  for (int i = 0; i < machine_.axis_count(); ++i) {
    axes[i].position = commanded[i];
    axes[i].sense = pose.sense[i];
  }
  shapes::State state;
  state.axes = {axes.data(), static_cast<size_t>(machine_.axis_count())};
  if (options_.time_s) state.time_s = *options_.time_s;
  if (options_.temperature_celsius) state.temperature_celsius = *options_.temperature_celsius;
  const auto actual =
      machine::EvaluateChain<double>(machine_, commanded.data(), machine::ErrorsAt(machine_, errors_, state));
  const auto nominal = machine::EvaluateChain<double>(machine_, pose.position.data(), {});
  return {machine::TipInTable<double>(actual, options_.tool_tip_mm) -
              machine::TipInTable<double>(nominal, options_.tool_tip_mm),
          machine::ToolDirectionInTable<double>(machine_, actual) -
              machine::ToolDirectionInTable<double>(machine_, nominal)};
}

absl::StatusOr<Eigen::Vector3d> TableChecker::AtReference(const Commander& command) const {
  Eigen::Vector3d mean_mm = Eigen::Vector3d::Zero();
  for (const double sense : {1.0, -1.0}) {
    Pose pose = reference_;
    pose.sense.fill(sense);
    ASSIGN_OR_RETURN(const Positions commanded, command(pose));
    mean_mm += 0.5 * See(commanded, pose).tip_mm;
  }
  return mean_mm;
}

absl::StatusOr<PointError> TableChecker::Check(const Commander& without, const Commander& with,
                                               const std::vector<Pose>& poses) const {
  ASSIGN_OR_RETURN(const Eigen::Vector3d before_mm, AtReference(without));
  ASSIGN_OR_RETURN(const Eigen::Vector3d after_mm, AtReference(with));
  PointError error;
  for (const Pose& pose : poses) {
    ASSIGN_OR_RETURN(const Positions uncorrected, without(pose));
    error.before.Add((See(uncorrected, pose).tip_mm - before_mm).norm());
    ASSIGN_OR_RETURN(const Positions corrected, with(pose));
    const Seen seen = See(corrected, pose);
    error.after.Add((seen.tip_mm - after_mm).norm());
    error.tilt_rad = std::max(error.tilt_rad, seen.direction.norm());
  }
  return error;
}

}  // namespace axiscal::compensate
