#include "core/figures/rotary_sessions.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/base/units.h"
#include "core/figures/axis_sessions.h"
#include "core/figures/noise.h"
#include "core/machine/chain.h"

namespace axiscal::figures {
namespace {

// Radial, tangential and axial directions at a reading, columns, in the table's frame.
absl::StatusOr<Eigen::Matrix3d> FrameOf(const machine::Machine& machine, const instruments::MeasuringRun& run, int axis,
                                        int reading) {
  std::vector<double> positions(run.PositionsOf(reading), run.PositionsOf(reading) + run.axis_count);
  const bool is_of_table =
      std::find(machine.work_branch.begin(), machine.work_branch.end(), axis) != machine.work_branch.end();
  const auto carried = [&](double turned) -> Eigen::Vector3d {
    std::vector<double> at = positions;
    at[static_cast<size_t>(axis)] += turned;
    const auto pose = machine::EvaluateChain<double>(machine, at.data(), machine::JointErrors<double>());
    return is_of_table ? pose.bed_from_table * run.ball_mm : pose.bed_from_tool * run.tip_mm;
  };
  // A circle: its first derivative is a x r, its second -r across the axis.
  constexpr double kStep = 1e-3;
  const Eigen::Vector3d less = carried(-kStep), here = carried(0.0), more = carried(kStep);
  const Eigen::Vector3d along = (more - less) / (2.0 * kStep), out = (2.0 * here - more - less) / (kStep * kStep);
  constexpr double kNearMm = 1.0;
  if (along.norm() < kNearMm) {
    return absl::InvalidArgumentError(absl::StrCat("the ", is_of_table ? "ball" : "tool point", " stands on ",
                                                   machine.axes[axis].name,
                                                   ": radial and tangential mean nothing there"));
  }
  const auto pose = machine::EvaluateChain<double>(machine, positions.data(), machine::JointErrors<double>());
  Eigen::Matrix3d frame;
  frame.col(1) = along.normalized();
  frame.col(0) = (out - out.dot(frame.col(1)) * frame.col(1)).normalized();
  frame.col(2) = frame.col(0).cross(frame.col(1));
  return Eigen::Matrix3d(pose.bed_from_table.rotation.transpose() * frame);
}

struct Seen {
  std::string symbol, text;
};
// R, T, A: *assumed* letters.
const Seen kDirections[] = {{"E rad", "radial"}, {"E tan", "tangential"}, {"E ax", "axial"},
                            {"E X", "along X"},  {"E Y", "along Y"},      {"E Z", "along Z"}};

double RangeOf(const Eigen::MatrixXd& rows, Eigen::Index row, const std::vector<double>& senses, double sense) {
  double low = INFINITY, high = -INFINITY;
  for (Eigen::Index k = 0; k < rows.cols(); ++k) {
    if (sense != 0.0 && senses[static_cast<size_t>(k)] != sense) continue;
    low = std::min(low, rows(row, k));
    high = std::max(high, rows(row, k));
  }
  return high - low;
}

}  // namespace

absl::StatusOr<MeasuredTest> RotaryTest(const machine::Machine& machine, const instruments::MeasuringRun& run,
                                        int axis) {
  const int count = run.reading_count();
  std::vector<Eigen::Matrix3d> frames;
  std::vector<double> senses;
  double low = INFINITY, high = -INFINITY;
  for (int k = 0; k < count; ++k) {
    ASSIGN_OR_RETURN(const Eigen::Matrix3d frame, FrameOf(machine, run, axis, k));
    frames.push_back(frame);
    const double sense = run.StateOf(k).axes[static_cast<size_t>(axis)].sense;
    senses.push_back(sense < 0.0 ? -1.0 : 1.0);
    low = std::min(low, run.PositionsOf(k)[axis]);
    high = std::max(high, run.PositionsOf(k)[axis]);
  }
  MeasuredTest test;
  test.kind = "rotary";
  test.what = absl::StrFormat("R-test of %s from %.4g to %.4g deg", machine.axes[axis].name, low * base::kDegPerRad,
                              high * base::kDegPerRad);
  test.sessions = {run.session};
  test.temperature_celsius = MeanTemperature({&run});
  NoteStated({&run}, &test.notes);
  const bool is_up = std::count(senses.begin(), senses.end(), 1.0) > 1,
             is_down = std::count(senses.begin(), senses.end(), -1.0) > 1;
  if (!(is_up && is_down)) test.notes.emplace_back("measured in one sense only");
  test.figures = WithNoise([&](const std::function<double()>& noise, bool is_alone) {
    std::vector<double> off;  // each stated fact, by so many standard uncertainties
    for (size_t i = 0; i < run.stated.size(); ++i) off.push_back(noise());
    Eigen::Matrix3Xd readings(3, count);
    for (int k = 0; k < count; ++k) {
      readings.col(k) = is_alone ? Eigen::Vector3d::Zero() : Eigen::Vector3d(run.measured_mm.col(k));
      for (int i = 0; i < 3; ++i) readings(i, k) += run.sigma_mm * noise();
      for (size_t i = 0; i < off.size(); ++i) readings.col(k) += off[i] * run.stated[i].by_sigma_mm.col(k);
    }
    const Eigen::Vector3d mean = readings.rowwise().mean();
    Eigen::MatrixXd along(6, count);
    for (int k = 0; k < count; ++k) {
      const Eigen::Vector3d e = readings.col(k) - mean;
      along.col(k).head<3>() = frames[static_cast<size_t>(k)].transpose() * e;
      along.col(k).tail<3>() = e;
    }
    std::vector<Figure> figures;
    for (Eigen::Index row = 0; row < 6; ++row) {
      const Seen& direction = kDirections[row];
      figures.push_back(
          {direction.symbol, absl::StrCat(direction.text, " deviation, range"), RangeOf(along, row, senses, 0.0)});
      if (!(is_up && is_down)) continue;
      figures.push_back({absl::StrCat(direction.symbol, "(up)"), absl::StrCat(direction.text, " deviation, rising"),
                         RangeOf(along, row, senses, 1.0)});
      figures.push_back({absl::StrCat(direction.symbol, "(down)"), absl::StrCat(direction.text, " deviation, falling"),
                         RangeOf(along, row, senses, -1.0)});
    }
    return figures;
  });
  return test;
}

}  // namespace axiscal::figures
