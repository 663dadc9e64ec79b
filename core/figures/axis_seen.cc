#include "core/figures/axis_seen.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_format.h"
#include "core/base/units.h"
#include "core/figures/line.h"
#include "core/instruments/evaluation.h"
#include "core/machine/chain.h"

namespace axiscal::figures {
namespace {

using instruments::Kind;
using instruments::MeasuringRun;

// The letter of the machine axis that a direction stands along, or 0.
char LetterOf(const Eigen::Vector3d& direction, const char* letters) {
  constexpr double kAlong = 0.99;
  for (int k = 0; k < 3; ++k)
    if (std::abs(direction[k]) > kAlong) return letters[k];
  return 0;
}

Across StraightnessIn(char letter, const std::string& axis, const std::vector<double>& values_mm) {
  return {absl::StrFormat("E%c%s", letter, axis),
          absl::StrFormat("straightness of %s in %c, about the least-squares line", axis, letter), true, values_mm};
}

std::vector<double> RowOf(const Eigen::RowVectorXd& row) { return {row.data(), row.data() + row.size()}; }

// A tracker sees positioning along the line through its points, and straightness in the machine's two directions
// nearest to square to it.
void SeeByTracker(const machine::Machine& machine, const MeasuringRun& run, int axis, AxisSeen* seen) {
  const Line measured = LineOf(seen->positions, seen->measured_mm);
  seen->perfect_mm.resize(3, seen->measured_mm.cols());
  for (Eigen::Index i = 0; i < seen->perfect_mm.cols(); ++i)
    seen->perfect_mm.col(i) = seen->positions[static_cast<size_t>(i)] * measured.along;
  const Eigen::Matrix3d tracker_from_machine = run.tracker_from_machine.rotation;
  const Eigen::Vector3d direction = machine.axes[axis].direction;
  const std::string name = machine.axes[axis].name;
  seen->deviations_of = [=, positions = seen->positions](const Eigen::MatrixXd& points_mm) {
    const Line line = LineOf(positions, points_mm);
    Deviations out{line.deviation_mm, {}};
    for (int k = 0; k < 3; ++k) {
      constexpr double kAlong = 0.7;  // the component along the axis is positioning
      if (std::abs(direction[k]) > kAlong) continue;
      const Eigen::Vector3d in_tracker = tracker_from_machine.col(k);
      const Eigen::Vector3d side = (in_tracker - in_tracker.dot(line.along) * line.along).normalized();
      out.across.push_back(StraightnessIn("XYZ"[k], name, RowOf(side.transpose() * points_mm)));
    }
    return out;
  };
}

double ScaleSigma(const MeasuringRun& run) {
  constexpr double kPerMetre = 1e-3;  // the set-up's scale is in mm per metre
  for (const instruments::SetupParameter& parameter : run.setup)
    if (parameter.name == "scale") return kPerMetre * parameter.prior_sigma;
  return 0.0;
}

// A beam along the motion shows positioning, one across it straightness.
absl::Status SeeByBeam(const machine::Machine& machine, const MeasuringRun& run, int axis,
                       const std::vector<Stop>& stops, AxisSeen* seen) {
  const machine::JointErrors<double> no_errors;
  const double no_setup[instruments::kMaxSetupParameters] = {};
  seen->perfect_mm.resize(1, static_cast<Eigen::Index>(stops.size()));
  for (size_t i = 0; i < stops.size(); ++i)
    instruments::Predict(machine, run, stops[i].readings[0], no_errors, no_setup,
                         &seen->perfect_mm(0, static_cast<Eigen::Index>(i)));
  const auto [low, high] = std::minmax_element(seen->positions.begin(), seen->positions.end());
  const double slope =
      (seen->perfect_mm(0, high - seen->positions.begin()) - seen->perfect_mm(0, low - seen->positions.begin())) /
      (*high - *low);
  const Eigen::RowVectorXd nominal_mm = seen->perfect_mm;
  constexpr double kAlong = 0.99, kAcross = 0.1;
  if (std::abs(slope) > kAlong) {
    seen->scale_sigma = ScaleSigma(run);
    seen->deviations_of = [=](const Eigen::MatrixXd& readings_mm) {
      return Deviations{RowOf((readings_mm.row(0) - nominal_mm) / slope), {}};
    };
    return absl::OkStatus();
  }
  const auto pose = machine::EvaluateChain<double>(machine, run.PositionsOf(stops[0].readings[0]), no_errors);
  const Eigen::Vector3d beam_in_bed =
      run.length.is_on_bed ? run.length.beam : Eigen::Vector3d(pose.bed_from_table.rotation * run.length.beam);
  const char letter = LetterOf(beam_in_bed, "XYZ");
  if (std::abs(slope) > kAcross || letter == 0)
    return absl::InvalidArgumentError("its beam stands neither along the motion nor square to it along X, Y or Z");
  seen->deviations_of = [=, name = machine.axes[axis].name](const Eigen::MatrixXd& readings_mm) {
    return Deviations{{}, {StraightnessIn(letter, name, RowOf(readings_mm.row(0) - nominal_mm))}};
  };
  return absl::OkStatus();
}

// How far the tool turns about `about` against the reference while a rotary axis goes from one stop to another, per
// turn of the axis: 1 or -1 where `about` is its axis.
double TurnAlong(const machine::Machine& machine, const MeasuringRun& run, const Stop& from, const Stop& to) {
  const auto tool_in_reference = [&](const Stop& stop) {
    const auto pose =
        machine::EvaluateChain<double>(machine, run.PositionsOf(stop.readings[0]), machine::JointErrors<double>());
    if (run.direction.is_on_bed) return Eigen::Matrix3d(pose.bed_from_tool.rotation);
    return Eigen::Matrix3d(pose.bed_from_table.rotation.transpose() * pose.bed_from_tool.rotation);
  };
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(tool_in_reference(to) * tool_in_reference(from).transpose()));
  const double by = std::remainder(to.position - from.position, 2.0 * std::numbers::pi);
  return by == 0.0 ? 0.0 : turn.angle() * turn.axis().dot(run.direction.about) / by;
}

// The turn beside the nominal one: positioning of a rotary axis about its own axis, an angular error of any other.
absl::Status SeeByDirection(const machine::Machine& machine, const MeasuringRun& run, int axis,
                            const std::vector<Stop>& stops, AxisSeen* seen) {
  seen->perfect_mm = Eigen::MatrixXd::Zero(1, static_cast<Eigen::Index>(stops.size()));
  const bool is_rotary = machine.axes[axis].kind == machine::AxisKind::kRotary;
  const double along = is_rotary ? TurnAlong(machine, run, stops[0], stops[1]) : 0.0;
  constexpr double kAlong = 0.99, kAcross = 0.1;
  if (std::abs(along) > kAlong) {
    seen->deviations_of = [sign = along > 0.0 ? 1.0 : -1.0](const Eigen::MatrixXd& readings_mm) {
      return Deviations{RowOf(sign * readings_mm.row(0)), {}};
    };
    return absl::OkStatus();
  }
  const char letter = LetterOf(run.direction.about, "ABC");
  if (std::abs(along) > kAcross || letter == 0)
    return absl::InvalidArgumentError("its 'about' stands neither along the axis that turns nor along X, Y or Z");
  const std::string name = machine.axes[axis].name;
  const Across turn{absl::StrFormat("E%c%s", letter, name),
                    absl::StrFormat("angular error of %s about %c, range", name, "XYZ"[letter - 'A']),
                    false,
                    {}};
  seen->deviations_of = [turn](const Eigen::MatrixXd& readings_mm) {
    Deviations out{{}, {turn}};
    out.across[0].values_mm = RowOf(readings_mm.row(0));
    return out;
  };
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<AxisSeen> SeenOf(const machine::Machine& machine, const MeasuringRun& run, int axis,
                                const std::vector<Stop>& stops) {
  const bool is_linear = machine.axes[axis].kind == machine::AxisKind::kLinear;
  if (!run.targets.of_reading.empty())
    return absl::InvalidArgumentError(
        "figures are known of a tracker that stands and sees one target, not of a session with a column target");
  AxisSeen seen;
  seen.measured_mm.resize(run.row_count, static_cast<Eigen::Index>(stops.size()));
  seen.stated_mm.assign(run.stated.size(), Eigen::MatrixXd::Zero(run.row_count, seen.measured_mm.cols()));
  for (size_t i = 0; i < stops.size(); ++i) {
    const auto count = static_cast<double>(stops[i].readings.size());
    for (size_t fact = 0; fact < run.stated.size(); ++fact) {
      for (const int k : stops[i].readings)
        seen.stated_mm[fact].col(static_cast<Eigen::Index>(i)) += run.stated[fact].by_sigma_mm.col(k) / count;
    }
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(run.row_count);
    for (const int k : stops[i].readings) mean += run.measured_mm.col(k) / count;
    seen.measured_mm.col(static_cast<Eigen::Index>(i)) = mean;
    seen.positions.push_back(stops[i].position * (is_linear ? 1.0 : base::kDegPerRad));
    seen.senses.push_back(stops[i].sense);
    seen.sigma_mm.push_back(run.sigma_mm / std::sqrt(count));
  }
  if (run.kind == Kind::kTracker && is_linear) {
    SeeByTracker(machine, run, axis, &seen);
  } else if (run.kind == Kind::kLength && run.length.is_beam && is_linear) {
    RETURN_IF_ERROR(SeeByBeam(machine, run, axis, stops, &seen));
  } else if (run.kind == Kind::kDirection) {
    RETURN_IF_ERROR(SeeByDirection(machine, run, axis, stops, &seen));
  } else {
    return absl::InvalidArgumentError(
        "of one axis that moves alone, figures are known of a tracker or a beam along or across a linear one, and of "
        "directions");
  }
  return seen;
}

}  // namespace axiscal::figures
