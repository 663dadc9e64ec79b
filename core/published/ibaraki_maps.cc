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
using Six = Eigen::Matrix<double, 6, 1>;  // displacements x y z, turns a b c; mm, rad
using SixBySix = Eigen::Matrix<double, 6, 6>;
using Index = std::pair<double, double>;  // positions of the two axes, deg, as commanded

// Sums over the touches of a face: how far it stood out along its normal, and what the run's stated facts (expansion of
// the artefact ...) change of that when they are off by one standard uncertainty each; mm.
struct Touched {
  double out_mm = 0.0;
  Eigen::VectorXd by_fact_mm;
  int count = 0;
};
using ByFeature = std::map<int, Touched>;

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

// Six numbers with their covariance: `own`, independent of every other index', and what is shared by all indices (the
// touches at the reference pose, or the fitted errors), by which these move so much.
struct Uncertain {
  Six value = Six::Zero();
  SixBySix own = SixBySix::Zero();
  Eigen::MatrixXd by_shared = Eigen::MatrixXd(6, 0);

  Six Sigma(const Eigen::MatrixXd& shared) const {
    return (own + by_shared * shared * by_shared.transpose()).diagonal().cwiseSqrt();
  }
};
using ByIndex = std::map<Index, Uncertain>;

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
    const auto facts = static_cast<Eigen::Index>(run.stated.size());
    Touched& sum = grid.off[index].try_emplace(feature, Touched{0.0, Eigen::VectorXd::Zero(facts)}).first->second;
    sum.out_mm += gap_mm;
    ++sum.count;
    for (Eigen::Index fact = 0; fact < facts; ++fact) {
      const instruments::StatedEffect& effect = run.stated[static_cast<size_t>(fact)];
      if (!effect.is_workpiece) sum.by_fact_mm[fact] += effect.by_sigma_mm(0, k);
    }
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

// Variance of a face's mean, mm2.
double VarianceOf(const MeasuringRun& run, const Touched& sum) { return run.sigma_mm * run.sigma_mm / sum.count; }

// Of the touches at the reference pose, in the order of their faces, and of the facts, in their standard uncertainties.
Eigen::MatrixXd ReferenceCovariance(const MeasuringRun& run, const ByFeature& reference) {
  Eigen::VectorXd variance = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(reference.size() + run.stated.size()));
  Eigen::Index next = 0;
  for (const auto& [feature, sum] : reference) variance[next++] = VarianceOf(run, sum);
  return variance.asDiagonal();
}

// Equations 6 and 9: least squares of what the faces moved along their normals since the reference pose. NaN where the
// touches do not determine all six.
Uncertain PublishedDisplacement(const Machine& machine, const MeasuringRun& run, const Grid& grid, const Index& index) {
  const ByFeature& here = grid.off.at(index);
  const ByFeature& reference = grid.off.at({0, 0});
  Eigen::MatrixXd rows(here.size(), 6);
  Eigen::VectorXd moved_mm(here.size()), variance(here.size());
  std::vector<Eigen::Index> place(here.size());  // among the faces of the reference pose
  const auto facts = static_cast<Eigen::Index>(run.stated.size()), faces = static_cast<Eigen::Index>(reference.size());
  Eigen::MatrixXd by_fact_mm(here.size(), facts);
  const geometry::Rigid<double> table = TableAt(machine, run, grid.reading.at(index), {});
  int count = 0;
  for (const auto& [feature, sum] : here) {
    const auto at_reference = reference.find(feature);
    if (at_reference == reference.end()) continue;
    const touch::Feature& face = run.touches.features[feature];
    const Eigen::Vector3d arm_mm = table * face.point_mm - grid.origin_mm, n = table.rotation * face.normal;
    rows.row(count) << n.transpose(), arm_mm.cross(n).transpose();
    variance[count] = VarianceOf(run, sum);
    place[count] = std::distance(reference.begin(), at_reference);
    const Touched& before = at_reference->second;
    by_fact_mm.row(count) = (sum.by_fact_mm / sum.count - before.by_fact_mm / before.count).transpose();
    moved_mm[count++] = sum.out_mm / sum.count - before.out_mm / before.count;
  }
  Eigen::MatrixXd scaled = rows.topRows(count);
  constexpr double kArmMm = 100.0;  // so that turns and displacements weigh alike in the rank
  scaled.rightCols(3) /= kArmMm;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  qr.setThreshold(1e-6);
  Uncertain out;
  out.by_shared.setZero(6, faces + facts);
  if (count < 6 || qr.rank() < 6) {
    out.value.setConstant(NAN);
    out.own.setConstant(NAN);
    return out;
  }
  Eigen::MatrixXd by_face = qr.solve(Eigen::MatrixXd::Identity(count, count));  // 6 x count
  by_face.bottomRows<3>() /= kArmMm;
  out.value = by_face * moved_mm.head(count);
  if (index == Index(0, 0)) return out;  // nothing has moved, for certain
  out.own = by_face * variance.head(count).asDiagonal() * by_face.transpose();
  for (int i = 0; i < count; ++i) out.by_shared.col(place[i]) = -by_face.col(i);
  out.by_shared.rightCols(facts) = by_face * by_fact_mm.topRows(count);
  return out;
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

// By the declared errors as they were fitted, with what one sigma of each does.
Uncertain ExactDisplacement(const Machine& machine, const MeasuringRun& run, int reading, const identify::Fit& fit,
                            const Eigen::Vector3d& origin_mm) {
  const machine::ErrorModel& model = fit.result.model;
  const std::vector<identify::Parameter> parameters = identify::ListParameters(model, true);
  Uncertain out;
  out.value = Displacement(machine, run, reading, model, origin_mm);
  out.by_shared.resize(6, static_cast<Eigen::Index>(parameters.size()));
  for (size_t i = 0; i < parameters.size(); ++i) {
    machine::ErrorModel moved = model;
    const double sigma = fit.result.estimates[i].sigma;
    identify::SetValue(parameters[i], identify::ValueOf(model, parameters[i]) + sigma, &moved);
    out.by_shared.col(static_cast<Eigen::Index>(i)) = Displacement(machine, run, reading, moved, origin_mm) - out.value;
  }
  return out;
}

// Whether the touches scatter about the declared errors as stated: chi-square within five of its standard deviations.
// Else the table moves otherwise than the declared errors say, by what no sigma of theirs covers.
bool IsExplained(const identify::FitStatistics& fit) {
  constexpr double kDeviations = 5.0;
  constexpr double kMostSetAside = 0.05;  // of the readings; what was set aside is in no chi-square
  return fit.degrees_of_freedom > 0 && fit.used >= (1.0 - kMostSetAside) * fit.readings &&
         fit.chi2_per_dof <= 1.0 + kDeviations * std::sqrt(2.0 / fit.degrees_of_freedom);
}

// Root mean square of the exact numbers' standard uncertainties, displacements and turns, mm and rad. What the columns
// are off enters where their features are known within a stated uncertainty.
Eigen::Vector2d ExactSigma(const Machine& machine, const MeasuringRun& run, const Grid& grid,
                           const identify::Fit& fit) {
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  for (const auto& [index, reading] : grid.reading) {
    const Six sigma = ExactDisplacement(machine, run, reading, fit, grid.origin_mm).Sigma(fit.result.correlation);
    squares += Eigen::Vector2d(sigma.head<3>().squaredNorm(), sigma.tail<3>().squaredNorm());
  }
  return (squares / (3.0 * static_cast<double>(grid.reading.size()))).cwiseSqrt();
}

// What errors of the artefact do to the numbers. The published steps compare each face with itself: where it stands
// takes nothing away from them. The joint fit compares faces with each other wherever not all are touched at each pose.
absl::StatusOr<std::string> ArtefactNote(const Machine& machine, const MeasuringRun& run, const Grid& grid,
                                         const identify::Fit& fit) {
  MeasuringRun perfect = run;
  double sigma_mm = 0.0;
  for (instruments::SetupParameter& offset : perfect.setup) {
    if (!offset.name.starts_with("feature_")) continue;
    sigma_mm = offset.prior_sigma;
    offset.held = 0.0;
  }
  if (sigma_mm == 0.0) return std::string();
  identify::Options options;
  options.set_outliers_aside = options.scale_uncertainties = false;
  ASSIGN_OR_RETURN(const identify::Fit without, identify::FitRuns(machine, {perfect}, options));
  const Eigen::Vector2d with_faces = ExactSigma(machine, run, grid, fit),
                        touches_alone = ExactSigma(machine, run, grid, without);
  return absl::StrFormat(
      "the artefact: each feature stands out by an unknown %.3g um (feature_sigma_um). No published number depends on "
      "it, as each is compared with itself at the reference pose; exact ones at the poses have standard uncertainties "
      "of %.3f um and %.3f urad (rms), %.3f um and %.3f urad if the features stood exactly where they are stated",
      base::kUmPerMm * sigma_mm, base::kUmPerMm * with_faces[0], base::kUradPerRad * with_faces[1],
      base::kUmPerMm * touches_alone[0], base::kUradPerRad * touches_alone[1]);
}

struct Maps {
  std::map<double, Uncertain> of_first;
  ByIndex of_second;
};

// Equations 12 and 13: the carrying axis' map is the mean over the carried one's positions, the rest, turned back, is
// the carried one's.
Maps MapsOf(const Machine& machine, const Grid& grid, const ByIndex& displacements) {
  Maps maps;
  std::map<double, int> count;
  const Eigen::Index shared = displacements.begin()->second.by_shared.cols();
  for (const auto& [index, six] : displacements) {
    Uncertain& mean = maps.of_first[index.first];
    if (count[index.first]++ == 0) mean.by_shared.setZero(6, shared);
    mean.value += six.value;
    mean.own += six.own;
    mean.by_shared += six.by_shared;
  }
  for (auto& [position, mean] : maps.of_first) {
    const double n = count[position];
    mean.value /= n;
    mean.own /= n * n;
    mean.by_shared /= n;
  }
  for (const auto& [index, six] : displacements) {
    const double turn_rad = -index.first * base::kRadPerDeg;
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(turn_rad, machine.axes[grid.first].direction).toRotationMatrix();
    SixBySix back = SixBySix::Zero();
    back.topLeftCorner<3, 3>() = back.bottomRightCorner<3, 3>() = turn;
    const Uncertain& mean = maps.of_first[index.first];
    Uncertain& rest = maps.of_second[index];
    rest.value = back * (six.value - mean.value);
    // The mean holds a share of this index' own touches.
    const SixBySix own = (1.0 - 2.0 / count[index.first]) * six.own + mean.own;
    rest.own = back * own * back.transpose();
    rest.by_shared = back * (six.by_shared - mean.by_shared);
  }
  return maps;
}

// Of the three ways, at one place.
struct ThreeWays {
  const Uncertain &published, &corrected, &exact;
};

struct Shared {
  Eigen::MatrixXd published, exact;  // covariances
};

void AddRows(const std::string& where, const std::string& symbol_of, const ThreeWays& ways, const Shared& shared,
             const char* formula, std::vector<Row>* rows) {
  static const char* const kNames[] = {"dx", "dy", "dz", "a", "b", "c"};
  static const char kLetters[] = "XYZABC";
  const Six published_sigma = ways.published.Sigma(shared.published), exact_sigma = ways.exact.Sigma(shared.exact);
  for (int i = 0; i < 6; ++i) {
    const bool is_angle = i >= 3;
    const double per_unit = is_angle ? base::kUradPerRad : base::kUmPerMm;
    Row& row = rows->emplace_back();
    row.quantity = absl::StrCat(kNames[i], " ", where);
    row.unit = is_angle ? "urad" : "um";
    row.published = per_unit * ways.published.value[i];
    row.published_sigma = per_unit * published_sigma[i];
    row.corrected = per_unit * ways.corrected.value[i];
    row.symbol = symbol_of.empty() ? "" : std::string("E") + kLetters[i] + symbol_of;
    row.exact = per_unit * ways.exact.value[i];
    row.sigma = per_unit * exact_sigma[i];
    row.formula = formula;
    if (!std::isfinite(row.published)) row.note = "the faces touched here and at 0, 0 do not determine all six";
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
  const bool is_determined = fit.result.not_separable.empty() && !fit.result.estimates.empty();
  const bool is_told = is_determined && fit.result.noise_scale == 1.0 && IsExplained(fit.result.fit);
  Comparison out;
  Shared shared;
  shared.published = ReferenceCovariance(run, grid.off.at({0, 0}));
  if (is_told) shared.exact = fit.result.correlation;  // by_shared is per sigma
  ByIndex published, exact, corrected;
  for (const auto& [index, reading] : grid.reading) {
    published[index] = PublishedDisplacement(machine, run, grid, index);
    if (is_told) {
      exact[index] = ExactDisplacement(machine, run, reading, fit, grid.origin_mm);
    } else {
      exact[index].value.setConstant(NAN);
      exact[index].own.setConstant(NAN);
    }
  }
  // What the reference pose takes away: its own error, turned with the table.
  const Six lost = exact.at({0, 0}).value;
  for (const auto& [index, six] : published) {
    const Eigen::Matrix3d turn = TableAt(machine, run, grid.reading.at(index), {}).rotation;
    corrected[index].value << six.value.head<3>() + turn * lost.head<3>(), six.value.tail<3>() + turn * lost.tail<3>();
  }
  const std::string &first = machine.axes[grid.first].name, &second = machine.axes[grid.second].name;
  const auto place = [&](const Index& index) {
    return absl::StrFormat("at %s %g %s %g", first, index.first, second, index.second);
  };
  for (const auto& [index, six] : published)
    AddRows(place(index), "", {six, corrected.at(index), exact.at(index)}, shared, "eqs 6, 9", &out.rows);
  const Maps p = MapsOf(machine, grid, published), c = MapsOf(machine, grid, corrected),
             e = MapsOf(machine, grid, exact);
  for (const auto& [position, six] : p.of_first) {
    AddRows(absl::StrFormat("of %s at %g", first, position), first,
            {six, c.of_first.at(position), e.of_first.at(position)}, shared, "eq 12", &out.rows);
  }
  for (const auto& [index, six] : p.of_second) {
    AddRows("of " + second + " " + place(index), second, {six, c.of_second.at(index), e.of_second.at(index)}, shared,
            "eq 13", &out.rows);
  }
  out.notes.push_back(absl::StrCat("the published steps take the artefact from ", first, " = ", second,
                                   " = 0: that pose's own error is missing everywhere, turned with the table, and "
                                   "constant errors come back as maps"));
  if (is_determined && !is_told) {
    out.notes.push_back(absl::StrFormat(
        "no exact numbers from the declared errors: the touches scatter about them by %.3f um rms, %.1f times the "
        "stated sigma of %.3g um: the table has errors that vary with %s or %s, which the declared ones lack (axiscal "
        "close-loop looks for them), or the stated sigma is too small",
        base::kUmPerMm * fit.result.fit.rms_mm, std::sqrt(fit.result.fit.chi2_per_dof), base::kUmPerMm * run.sigma_mm,
        first, second));
  } else if (!is_told) {
    std::string unknown = fit.result.estimates.empty() ? "the machine declares none" : "";
    for (const std::string& name : fit.result.not_separable)
      absl::StrAppend(&unknown, unknown.empty() ? "the touches cannot tell " : "; ", name);
    out.notes.push_back("no exact numbers from the declared errors: " + unknown);
  } else {
    out.notes.push_back(absl::StrFormat("exact: the machine's declared errors, residual %.3f um rms",
                                        base::kUmPerMm * fit.result.fit.rms_mm));
    ASSIGN_OR_RETURN(const std::string artefact, ArtefactNote(machine, run, grid, fit));
    if (!artefact.empty()) out.notes.push_back(artefact);
  }
  return out;
}

}  // namespace axiscal::published
