#include <Eigen/Geometry>
#include <Eigen/QR>
#include <cmath>
#include <map>
#include <utility>

#include "core/base/units.h"
#include "core/identify/identify.h"
#include "core/instruments/evaluation.h"
#include "core/published/sources.h"

namespace axiscal::published {
namespace {

using instruments::MeasuringRun;
using machine::Machine;
using Six = Eigen::Matrix<double, 6, 1>;           // displacements x y z, turns a b c; mm, rad
using Index = std::pair<double, double>;           // positions of the two axes, deg, as commanded
using ByFeature = std::map<int, Eigen::Vector2d>;  // sum and count of what a face is off along its normal, mm

// The table's two rotary axes, the carrying one first.
absl::StatusOr<std::pair<int, int>> TableAxes(const Machine& machine) {
  const size_t count = machine.work_branch.size();
  if (count >= 2) {
    const int first = machine.work_branch[count - 2], second = machine.work_branch[count - 1];
    const bool are_rotary = machine.axes[first].kind == machine::AxisKind::kRotary &&
                            machine.axes[second].kind == machine::AxisKind::kRotary;
    if (are_rotary) return std::make_pair(first, second);
  }
  return absl::FailedPreconditionError("machine " + machine.id +
                                       ": expected a table on two rotary axes, the last two of the work branch");
}

struct Grid {
  std::map<Index, ByFeature> off;  // against the nominal machine
  std::map<Index, int> reading;    // one of each index
  int first = 0, second = 0;       // axes
  Eigen::Vector3d origin_mm;       // of the displacements: the nominal crossing of the axes
};

absl::StatusOr<Grid> ReadGrid(const Machine& machine, const MeasuringRun& run) {
  Grid grid;
  ASSIGN_OR_RETURN(const auto axes, TableAxes(machine));
  std::tie(grid.first, grid.second) = axes;
  grid.origin_mm = machine.axes[grid.first].point_mm;
  const double setup[instruments::kMaxSetupParameters] = {};
  for (int k = 0; k < run.reading_count(); ++k) {
    const int feature = run.touches.feature_of[k];
    if (run.touches.features[feature].is_sphere) {
      return absl::InvalidArgumentError("session " + run.session + ": '" + run.touches.features[feature].name +
                                        "' is a sphere, expected plane faces only");
    }
    const auto degrees = [&](int axis) {
      return std::round(run.PositionsOf(k)[axis] * base::kDegPerRad * 1e3) / 1e3 + 0.0;
    };
    double gap_mm = NAN;  // of the stylus to the nominal face: how far the face stood out
    instruments::Predict(machine, run, k, {}, setup, &gap_mm);
    const Index index(degrees(grid.first), degrees(grid.second));
    Eigen::Vector2d& sum = grid.off[index].try_emplace(feature, Eigen::Vector2d::Zero()).first->second;
    sum += Eigen::Vector2d(gap_mm, 1.0);
    grid.reading.emplace(index, k);
  }
  if (grid.off.count({0, 0}) == 0) {
    return absl::InvalidArgumentError(absl::StrCat("session ", run.session, ": expected touches at ",
                                                   machine.axes[grid.first].name, " = ", machine.axes[grid.second].name,
                                                   " = 0, the reference pose"));
  }
  return grid;
}

// In the frame that carries both axes: the linear axes at home, whatever a touch needed.
geometry::Rigid<double> TableAt(const Machine& machine, const MeasuringRun& run, int reading,
                                const machine::JointErrors<double>& errors) {
  std::vector<double> positions(run.PositionsOf(reading), run.PositionsOf(reading) + run.axis_count);
  for (int i = 0; i < run.axis_count; ++i) {
    if (machine.axes[i].kind == machine::AxisKind::kLinear) positions[i] = 0.0;
  }
  return machine::EvaluateChain<double>(machine, positions.data(), errors).bed_from_table;
}

// Equations 6 and 9: least squares of what the faces moved along their normals since the reference pose. NaN where the
// touches do not determine all six.
Six PublishedDisplacement(const Machine& machine, const MeasuringRun& run, const Grid& grid, const Index& index) {
  const ByFeature& here = grid.off.at(index);
  const ByFeature& reference = grid.off.at({0, 0});
  Eigen::MatrixXd rows(here.size(), 6);
  Eigen::VectorXd moved_mm(here.size());
  const geometry::Rigid<double> table = TableAt(machine, run, grid.reading.at(index), {});
  int count = 0;
  for (const auto& [feature, sum] : here) {
    const auto at_reference = reference.find(feature);
    if (at_reference == reference.end()) continue;
    const touch::Feature& face = run.touches.features[feature];
    const Eigen::Vector3d arm_mm = table * face.point_mm - grid.origin_mm, n = table.rotation * face.normal;
    rows.row(count) << n.transpose(), arm_mm.cross(n).transpose();
    moved_mm[count++] = sum[0] / sum[1] - at_reference->second[0] / at_reference->second[1];
  }
  Eigen::MatrixXd scaled = rows.topRows(count);
  constexpr double kArmMm = 100.0;  // so that turns and displacements weigh alike in the rank
  scaled.rightCols(3) /= kArmMm;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  qr.setThreshold(1e-6);
  if (count < 6 || qr.rank() < 6) return Six::Constant(NAN);
  Six solved = qr.solve(moved_mm.head(count));
  solved.tail<3>() /= kArmMm;
  return solved;
}

// Of the table against the nominal machine, about the axes' crossing.
Six Displacement(const Machine& machine, const MeasuringRun& run, int reading, const machine::ErrorModel& model,
                 const Eigen::Vector3d& origin_mm) {
  const geometry::Rigid<double> delta =
      TableAt(machine, run, reading, machine::ErrorsAt(machine, model, run.StateOf(reading))) *
      TableAt(machine, run, reading, {}).Inverse();
  const Eigen::Matrix3d& r = delta.rotation;
  Six six;
  six << delta * origin_mm - origin_mm, 0.5 * Eigen::Vector3d(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1));
  return six;
}

struct Maps {
  std::map<double, Six> of_first;
  std::map<Index, Six> of_second;
};

// Equations 12 and 13: the carrying axis' map is the mean over the carried one's positions, the rest, turned back, is
// the carried one's.
Maps MapsOf(const Machine& machine, const Grid& grid, const std::map<Index, Six>& displacements) {
  Maps maps;
  std::map<double, int> count;
  for (const auto& [index, six] : displacements) {
    maps.of_first.try_emplace(index.first, Six::Zero()).first->second += six;
    ++count[index.first];
  }
  for (auto& [position, six] : maps.of_first) six /= count[position];
  for (const auto& [index, six] : displacements) {
    const double turn_rad = -index.first * base::kRadPerDeg;
    const Eigen::Matrix3d back = Eigen::AngleAxisd(turn_rad, machine.axes[grid.first].direction).toRotationMatrix();
    const Six rest = six - maps.of_first[index.first];
    maps.of_second[index] << back * rest.head<3>(), back * rest.tail<3>();
  }
  return maps;
}

void AddRows(const std::string& where, const std::string& symbol_of, const Six& published, const Six& corrected,
             const Six& exact, const char* formula, std::vector<Row>* rows) {
  static const char* const kNames[] = {"dx", "dy", "dz", "a", "b", "c"};
  static const char kLetters[] = "XYZABC";
  for (int i = 0; i < 6; ++i) {
    const bool is_angle = i >= 3;
    const double per_unit = is_angle ? base::kUradPerRad : base::kUmPerMm;
    const std::string symbol = symbol_of.empty() ? "" : std::string("E") + kLetters[i] + symbol_of;
    rows->push_back({absl::StrCat(kNames[i], " ", where), is_angle ? "urad" : "um", per_unit * published[i],
                     per_unit * corrected[i], symbol, per_unit * exact[i], NAN, formula,
                     std::isfinite(published[i]) ? "" : "the faces touched here and at 0, 0 do not determine all six"});
  }
}

}  // namespace

absl::StatusOr<Comparison> IbarakiMaps(const Machine& machine, const std::vector<session::Session>& sessions) {
  ASSIGN_OR_RETURN(std::vector<MeasuringRun> runs, identify::BindSessions(machine, sessions));
  if (runs.size() != 1 || runs[0].kind != instruments::Kind::kTouch) {
    return absl::InvalidArgumentError(
        "expected one session of instrument touch: a second one would be another mounting");
  }
  ASSIGN_OR_RETURN(const Grid grid, ReadGrid(machine, runs[0]));
  const MeasuringRun run = runs[0];
  ASSIGN_OR_RETURN(const identify::Fit fit, identify::FitRuns(machine, std::move(runs), {}));
  const bool is_told = fit.result.not_separable.empty() && !fit.result.estimates.empty();
  Comparison out;
  std::map<Index, Six> published, exact, corrected;
  for (const auto& [index, reading] : grid.reading) {
    published[index] = PublishedDisplacement(machine, run, grid, index);
    exact[index] =
        is_told ? Displacement(machine, run, reading, fit.result.model, grid.origin_mm) : Six(Six::Constant(NAN));
  }
  // What the reference pose takes away: its own error, turned with the table.
  const Six lost = exact.at({0, 0});
  for (const auto& [index, six] : published) {
    const Eigen::Matrix3d turn = TableAt(machine, run, grid.reading.at(index), {}).rotation;
    corrected[index] << six.head<3>() + turn * lost.head<3>(), six.tail<3>() + turn * lost.tail<3>();
  }
  const std::string &first = machine.axes[grid.first].name, &second = machine.axes[grid.second].name;
  const auto place = [&](const Index& index) {
    return absl::StrFormat("at %s %g %s %g", first, index.first, second, index.second);
  };
  for (const auto& [index, six] : published)
    AddRows(place(index), "", six, corrected[index], exact[index], "eqs 6, 9", &out.rows);
  const Maps p = MapsOf(machine, grid, published), c = MapsOf(machine, grid, corrected),
             e = MapsOf(machine, grid, exact);
  for (const auto& [position, six] : p.of_first) {
    AddRows(absl::StrFormat("of %s at %g", first, position), first, six, c.of_first.at(position),
            e.of_first.at(position), "eq 12", &out.rows);
  }
  for (const auto& [index, six] : p.of_second)
    AddRows("of " + second + " " + place(index), second, six, c.of_second.at(index), e.of_second.at(index), "eq 13",
            &out.rows);
  out.notes.push_back(absl::StrCat("the published steps take the artefact from ", first, " = ", second,
                                   " = 0: that pose's own error is missing everywhere, turned with the table, and "
                                   "constant errors come back as maps"));
  if (!is_told) {
    std::string unknown = fit.result.estimates.empty() ? "the machine declares none" : "";
    for (const std::string& name : fit.result.not_separable)
      absl::StrAppend(&unknown, unknown.empty() ? "the touches cannot tell " : "; ", name);
    out.notes.push_back("no exact numbers from the declared errors: " + unknown);
  } else {
    out.notes.push_back(absl::StrFormat("exact: the machine's declared errors, residual %.3f um rms",
                                        base::kUmPerMm * fit.result.fit.rms_mm));
  }
  return out;
}

}  // namespace axiscal::published
