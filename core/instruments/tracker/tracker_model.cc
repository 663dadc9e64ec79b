#include "core/instruments/tracker/tracker_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "absl/strings/str_cat.h"

namespace axiscal::tracker {
namespace {

using instruments::MeasuringRun;
using instruments::SetupParameter;

constexpr double kUnknown = std::numeric_limits<double>::infinity();

// A stand that warms up, or is knocked, goes by tenths of a mm and of a mrad at most. It only keeps steady what the
// references do not show: a turn about the line of two of them.
constexpr double kMovedMm = 0.3, kMovedRad = 3e-4;

void AddPlace(const std::string& name, std::vector<SetupParameter>* setup) {
  for (const char* const axis : {"_x", "_y", "_z"}) setup->push_back({name + axis, kUnknown, true, false});
}

}  // namespace

std::vector<SetupParameter> SetupParameters() { return SetupParametersOf({}); }

std::vector<SetupParameter> SetupParametersOf(const Targets& targets) {
  std::vector<SetupParameter> setup = {{"frame_x", kUnknown, true, false}, {"frame_y", kUnknown, true, false},
                                       {"frame_z", kUnknown, true, false}, {"frame_a", kUnknown, true, true},
                                       {"frame_b", kUnknown, true, true},  {"frame_c", kUnknown, true, true}};
  if (targets.on_tool.size() < 2) AddPlace("target", &setup);
  for (size_t i = 0; targets.on_tool.size() >= 2 && i < targets.on_tool.size(); ++i)
    AddPlace("target_" + targets.on_tool[i].name, &setup);
  for (const Target& reference : targets.references) AddPlace("reference_" + reference.name, &setup);
  for (int look = 2; look <= targets.Moves() + 1; ++look) {
    for (const char axis : {'x', 'y', 'z', 'a', 'b', 'c'}) {
      const bool is_angle = axis < 'x';
      setup.push_back({absl::StrCat("moved_", look, "_", std::string(1, axis)), is_angle ? kMovedRad : kMovedMm, true,
                       is_angle, /*is_placed=*/false});
    }
  }
  return setup;
}

int TargetOf(const MeasuringRun& run, int reading) {
  if (run.targets.of_reading.empty()) return kPoseOffsets;
  const int of = run.targets.of_reading[static_cast<size_t>(reading)];
  const int on_tool = static_cast<int>(std::max<size_t>(1, run.targets.on_tool.size()));
  return kPoseOffsets + 3 * (of >= 0 ? of : on_tool - 1 - of);
}

const Eigen::Vector3d& NominalPlace(const MeasuringRun& run, int reading) {
  if (run.targets.IsReference(reading)) return run.targets.ReferenceOf(reading).point_mm;
  if (run.targets.on_tool.empty()) return run.tip_mm;
  return run.targets.on_tool[static_cast<size_t>(run.targets.of_reading[static_cast<size_t>(reading)])].point_mm;
}

void PoseShares(const Targets& targets, double time_s, double* shares) {
  const int moves = targets.Moves();
  std::fill(shares, shares + moves, 0.0);
  const std::vector<double>& looks_s = targets.looks_s;
  if (moves == 0 || time_s <= looks_s.front()) return;
  // Between looks `from` and from + 1; the first look's pose has no offset.
  const auto next = std::upper_bound(looks_s.begin(), looks_s.end(), time_s);
  const int from = static_cast<int>(next - looks_s.begin()) - 1;
  if (next == looks_s.end()) {
    shares[moves - 1] = 1.0;
    return;
  }
  const double begin_s = looks_s[static_cast<size_t>(from)];
  double on = (time_s - begin_s) / (*next - begin_s);
  const auto knocked = std::upper_bound(targets.knocked_s.begin(), targets.knocked_s.end(), begin_s);
  if (knocked != targets.knocked_s.end() && *knocked <= *next) on = time_s >= *knocked ? 1.0 : 0.0;
  if (from > 0) shares[from - 1] = 1.0 - on;
  shares[from] = on;
}

geometry::Rigid<double> StartingPose(const machine::Machine& machine, const MeasuringRun& run) {
  Eigen::Matrix3Xd nominal_mm(3, run.reading_count()), measured_mm(3, run.reading_count());
  Eigen::Index count = 0;
  for (int k = 0; k < run.reading_count(); ++k) {
    if (run.targets.IsReference(k)) continue;
    nominal_mm.col(count) =
        machine::EvaluateChain<double>(machine, run.PositionsOf(k), {}).bed_from_tool * NominalPlace(run, k);
    measured_mm.col(count++) = run.measured_mm.col(k);
  }
  if (count == 0) return {};
  const Eigen::Matrix4d pose =
      Eigen::umeyama(nominal_mm.leftCols(count).eval(), measured_mm.leftCols(count).eval(), /*with_scaling=*/false);
  return {pose.topLeftCorner<3, 3>(), pose.topRightCorner<3, 1>()};
}

void Evaluate(const machine::Machine& machine, const MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out) {
  const Targets& targets = run.targets;
  const int target = TargetOf(run, reading), first_move = FirstMove(targets);
  const bool is_reference = targets.IsReference(reading);
  const Eigen::Vector3d target_mm = NominalPlace(run, reading) + Eigen::Map<const Eigen::Vector3d>(setup + target);
  machine::EvaluateRelativePoint(machine, run.PositionsOf(reading), errors, target_mm, Eigen::Vector3d::Zero(),
                                 &out->point);
  // The tracker does not stand on the table: the work branch has no part in its reading.
  for (const int axis : machine.work_branch) out->point.sensitivity.middleCols<6>(6 * axis).setZero();
  out->point.sensitivity.middleCols<6>(6 * machine.work_joint()).setZero();
  if (is_reference) out->point.sensitivity.setZero();
  const Eigen::Vector3d place_mm = is_reference ? target_mm : Eigen::Vector3d(out->point.tip_in_bed_mm);
  const Eigen::Matrix3d bed_from_carrier =
      is_reference ? Eigen::Matrix3d::Identity().eval() : Eigen::Matrix3d(out->point.pose.bed_from_tool.rotation);

  double pose[kPoseOffsets], shares[kMostPoses];
  std::copy(setup, setup + kPoseOffsets, pose);
  PoseShares(targets, run.time_s[static_cast<size_t>(reading)], shares);
  for (int k = 0; k < targets.Moves(); ++k) {
    for (int i = 0; i < kPoseOffsets; ++i) pose[i] += shares[k] * setup[first_move + kPoseOffsets * k + i];
  }
  const double ca = std::cos(pose[3]), sa = std::sin(pose[3]), cb = std::cos(pose[4]), sb = std::sin(pose[4]);
  const Eigen::Matrix3d turn = geometry::RotationXyz(pose[3], pose[4], pose[5]);
  const Eigen::Matrix3d tracker_from_bed = turn * run.tracker_from_machine.rotation;
  const Eigen::Vector3d turned_mm = turn * (run.tracker_from_machine * place_mm);
  out->predicted_mm = turned_mm + Eigen::Vector3d(pose[0], pose[1], pose[2]);
  out->by_error.noalias() = tracker_from_bed * out->point.sensitivity;
  out->by_setup.setZero(3, first_move + kPoseOffsets * targets.Moves());
  out->by_setup.leftCols<3>().setIdentity();
  out->by_setup.col(3) = Eigen::Vector3d::UnitX().cross(turned_mm);
  out->by_setup.col(4) = Eigen::Vector3d(0, ca, sa).cross(turned_mm);
  out->by_setup.col(5) = Eigen::Vector3d(sb, -sa * cb, ca * cb).cross(turned_mm);
  out->by_setup.middleCols<3>(target) = tracker_from_bed * bed_from_carrier;
  for (int k = 0; k < targets.Moves(); ++k) {
    if (shares[k] == 0.0) continue;
    out->by_setup.middleCols<kPoseOffsets>(first_move + kPoseOffsets * k) =
        shares[k] * out->by_setup.leftCols<kPoseOffsets>().eval();
  }
}

}  // namespace axiscal::tracker
