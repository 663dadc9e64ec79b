#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/units.h"
#include "core/instruments/touch/sphere_fit.h"
#include "core/instruments/touch/touch_bind.h"
#include "core/instruments/touch/touch_model.h"

namespace axiscal::touch {
namespace {

using instruments::MeasuringRun;

absl::StatusOr<double> GateMm(const session::Session& session, const char* key) {
  const std::optional<std::string> text = session::FindHeader(session, key);
  if (!text) return kDefaultGateMm;
  double gate_um = 0.0;
  if (!absl::SimpleAtod(*text, &gate_um) || !std::isfinite(gate_um) || gate_um <= 0.0) {
    return absl::InvalidArgumentError(
        absl::StrCat("header '", key, ": ", *text, "', expected a number of micrometres above 0"));
  }
  return gate_um * base::kMmPerUm;
}

// Touches of one feature at one rotary pose, in time order.
std::map<std::vector<double>, std::vector<int>> Groups(const machine::Machine& machine, const MeasuringRun& run) {
  std::map<std::vector<double>, std::vector<int>> groups;
  for (int k = 0; k < run.reading_count(); ++k) {
    std::vector<double> key = {static_cast<double>(run.touches.feature_of[k])};
    for (int i = 0; i < run.axis_count; ++i) {
      constexpr double kSamePoseRad = 1e-6;
      if (machine.axes[i].kind != machine::AxisKind::kRotary) continue;
      key.push_back(std::round(run.PositionsOf(k)[i] / kSamePoseRad));
    }
    groups[key].push_back(k);
  }
  return groups;
}

// Touches of one feature at one rotary pose, with where the stylus centre stood: on the table, which linear axes may
// carry, in its axes and turned into the machine's.
struct Group {
  std::vector<int> readings;
  std::vector<Eigen::Vector3d> in_table_mm, turned_mm;
};

void Reject(int reading, const char* gate, double off_mm, double limit_mm, std::vector<Rejection>* rejected) {
  const auto is_it = [reading](const Rejection& one) { return one.reading == reading; };
  if (std::none_of(rejected->begin(), rejected->end(), is_it)) rejected->push_back({reading, gate, off_mm, limit_mm});
}

double MedianOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

// Repeats of one touch have one place across the approach. Of two that differ nobody can say which is wrong; of three
// or more it is the one that is off the median of the others.
void GateRepeats(const MeasuringRun& run, const Group& group, double gate_mm, std::vector<Rejection>* rejected) {
  constexpr double kSamePlaceMm = 0.010;  // across the approach: what a control's positioning leaves
  std::vector<bool> is_seen(group.readings.size(), false);
  for (size_t i = 0; i < group.readings.size(); ++i) {
    if (is_seen[i]) continue;
    const Eigen::Vector3d& approach = run.touches.approach[group.readings[i]];
    std::vector<int> repeats;
    std::vector<double> along_mm;
    for (size_t j = i; j < group.readings.size(); ++j) {
      const Eigen::Vector3d apart_mm = group.turned_mm[j] - group.turned_mm[i];
      const double along = apart_mm.dot(approach);
      if ((approach - run.touches.approach[group.readings[j]]).norm() > 1e-6 ||
          (apart_mm - along * approach).norm() > kSamePlaceMm)
        continue;
      is_seen[j] = true;
      repeats.push_back(group.readings[j]);
      along_mm.push_back(along);
    }
    for (size_t k = 0; k < repeats.size(); ++k) {
      std::vector<double> others_mm = along_mm;
      others_mm.erase(others_mm.begin() + static_cast<std::ptrdiff_t>(k));
      if (others_mm.empty()) continue;
      const double off_mm = std::abs(along_mm[k] - MedianOf(others_mm));
      const double from_all_mm = std::abs(along_mm[k] - MedianOf(along_mm));
      if (off_mm > gate_mm && (repeats.size() < 3 || from_all_mm > 0.5 * gate_mm))
        Reject(repeats[k], "repeat", off_mm, gate_mm, rejected);
    }
  }
}

// Rejects, one after the other, the touches that stand off the sphere of the other touches. A sphere of another radius
// is refused.
absl::Status GateSphere(const MeasuringRun& run, const Feature& feature, Group group, double gate_mm,
                        std::vector<Rejection>* rejected) {
  const int first = run.readings_before + group.readings[0] + 1;
  const size_t most = group.readings.size() / 3 + 1;
  while (rejected->size() < most) {
    const std::optional<Sphere> of_all = FitSphere(group.in_table_mm);
    if (of_all && of_all->max_mm <= 0.25 * gate_mm) break;  // nor is any far off the others'
    // The one without which the others agree best.
    double least_rms_mm = INFINITY, worst_mm = 0.0;
    size_t worst = 0;
    for (size_t k = 0; k < group.readings.size(); ++k) {
      std::vector<Eigen::Vector3d> fellows_mm = group.in_table_mm;
      fellows_mm.erase(fellows_mm.begin() + static_cast<std::ptrdiff_t>(k));
      const std::optional<Sphere> sphere = FitSphere(fellows_mm);
      if (!sphere || sphere->rms_mm >= least_rms_mm) continue;
      least_rms_mm = sphere->rms_mm;
      worst_mm = std::abs((group.in_table_mm[k] - sphere->centre_mm).norm() - sphere->radius_mm);
      worst = k;
    }
    if (worst_mm <= gate_mm) break;
    Reject(group.readings[worst], "sphere", worst_mm, gate_mm, rejected);
    group.readings.erase(group.readings.begin() + static_cast<std::ptrdiff_t>(worst));
    group.in_table_mm.erase(group.in_table_mm.begin() + static_cast<std::ptrdiff_t>(worst));
  }
  const std::optional<Sphere> sphere = FitSphere(group.in_table_mm);
  const double expected_mm = feature.radius_mm + run.touches.stylus_radius_mm;
  if (!sphere || std::abs(sphere->radius_mm - expected_mm) <= gate_mm) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "session '%s': the %d touches of sphere '%s' from reading %d lie on a radius of %.4f mm, expected %.4f "
      "(sphere %g + stylus_radius_mm %g) within radius_gate_um = %g: was it measured with another stylus?",
      run.session, group.readings.size(), feature.name, first, sphere->radius_mm, expected_mm, feature.radius_mm,
      run.touches.stylus_radius_mm, gate_mm / base::kMmPerUm));
}

// Where the stylus centre stood on the nominal machine, table frame.
Eigen::Vector3d StylusInTable(const machine::Machine& machine, const MeasuringRun& run, int reading) {
  const auto pose = machine::EvaluateChain<double>(machine, run.PositionsOf(reading), {});
  return pose.bed_from_table.Inverse() * (pose.bed_from_tool * run.tip_mm);
}

// From the face's point to a point, along the face.
double AsideMm(const Feature& face, const Eigen::Vector3d& at_mm) {
  const Eigen::Vector3d apart_mm = at_mm - face.point_mm;
  return (apart_mm - apart_mm.dot(face.normal) * face.normal).norm();
}

// A face is stored without its borders: a touch on top of the next column lies in the plane of this column's top too.
absl::Status GateNeighbours(const machine::Machine& machine, const MeasuringRun& run, int reading) {
  const Feature& face = run.touches.features[run.touches.feature_of[reading]];
  if (face.is_sphere) return absl::OkStatus();
  const Eigen::Vector3d at_mm = StylusInTable(machine, run, reading);
  const double aside_mm = AsideMm(face, at_mm);
  if (aside_mm <= kWrongFeatureMm) return absl::OkStatus();
  for (const Feature& other : run.touches.features) {
    if (other.is_sphere || other.normal.dot(face.normal) < 0.99) continue;
    const double gap_mm = (at_mm - other.point_mm).dot(other.normal) - run.touches.stylus_radius_mm;
    if (std::abs(gap_mm) > kWrongFeatureMm || AsideMm(other, at_mm) > 0.5 * aside_mm) continue;
    return absl::InvalidArgumentError(absl::StrFormat(
        "session '%s': reading %d of feature '%s' stands %.1f mm aside of its point and %.1f mm aside of that of '%s', "
        "expected a touch of the nearer: is it a touch of another feature?",
        run.session, run.readings_before + reading + 1, face.name, aside_mm, AsideMm(other, at_mm), other.name));
  }
  return absl::OkStatus();
}

absl::Status GateFeature(const machine::Machine& machine, const MeasuringRun& run, int reading) {
  const double no_setup[instruments::kMaxSetupParameters] = {};
  double gap_mm = 0.0;
  Predict<double>(machine, run, reading, run.PositionsOf(reading), {}, no_setup, &gap_mm);
  const std::string& name = run.touches.features[run.touches.feature_of[reading]].name;
  if (std::abs(gap_mm) > kWrongFeatureMm) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "session '%s': reading %d stands %.3f mm off feature '%s', expected a touch within %g mm: is it a touch of "
        "another feature, are tool_tip_mm and stylus_radius_mm right?",
        run.session, run.readings_before + reading + 1, gap_mm, name, kWrongFeatureMm));
  }
  RETURN_IF_ERROR(GateNeighbours(machine, run, reading));
  const double cosine = run.touches.approach[reading].dot(NominalNormal(machine, run, reading));
  // 60 deg: no probe is sent that far off the normal, and another face of a block stands at 90.
  if (cosine < -0.5) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "session '%s': reading %d approaches feature '%s' at %.0f deg to its inward normal, expected within 60: is it a "
      "touch of another feature, or nx, ny, nz of the other sign?",
      run.session, run.readings_before + reading + 1, name,
      std::acos(std::clamp(-cosine, -1.0, 1.0)) / base::kRadPerDeg));
}

}  // namespace

absl::Status GateTouches(const machine::Machine& machine, const session::Session& session, MeasuringRun* run) {
  for (int k = 0; k < run->reading_count(); ++k) RETURN_IF_ERROR(GateFeature(machine, *run, k));
  ASSIGN_OR_RETURN(const double radius_gate_mm, GateMm(session, "radius_gate_um"));
  ASSIGN_OR_RETURN(const double repeat_gate_mm, GateMm(session, "repeat_gate_um"));
  std::vector<Rejection>& all = run->touches.rejected;
  for (const auto& [key, readings] : Groups(machine, *run)) {
    const Feature& feature = run->touches.features[run->touches.feature_of[readings[0]]];
    Group group{readings, {}, {}};
    for (const int k : readings) {
      const auto pose = machine::EvaluateChain<double>(machine, run->PositionsOf(k), {});
      group.in_table_mm.push_back(pose.bed_from_table.Inverse() * (pose.bed_from_tool * run->tip_mm));
      group.turned_mm.push_back(pose.bed_from_table.rotation * group.in_table_mm.back());
    }
    std::vector<Rejection> rejected;
    GateRepeats(*run, group, repeat_gate_mm, &rejected);
    if (feature.is_sphere) RETURN_IF_ERROR(GateSphere(*run, feature, group, radius_gate_mm, &rejected));
    if (AreTooMany(rejected.size(), readings.size())) {
      const Rejection& worst = rejected[0];
      return absl::InvalidArgumentError(absl::StrFormat(
          "session '%s': %d of the %d touches of '%s' from reading %d fail a gate (reading %d is %.1f um off its %s, "
          "expected within %g um), expected at most a third: what is wrong with them all?",
          run->session, rejected.size(), readings.size(), feature.name, run->readings_before + readings[0] + 1,
          run->readings_before + worst.reading + 1, worst.off_mm / base::kMmPerUm,
          worst.gate == "sphere" ? "fellows' sphere" : "repeats", worst.limit_mm / base::kMmPerUm));
    }
    all.insert(all.end(), rejected.begin(), rejected.end());
  }
  std::sort(all.begin(), all.end(), [](const Rejection& a, const Rejection& b) { return a.reading < b.reading; });
  return absl::OkStatus();
}

}  // namespace axiscal::touch
