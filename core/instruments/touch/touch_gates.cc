#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

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

double MedianOf(const std::vector<double>& sorted) {
  const size_t middle = sorted.size() / 2;
  return sorted.size() % 2 == 1 ? sorted[middle] : 0.5 * (sorted[middle - 1] + sorted[middle]);
}

// Of all but the k-th.
double MedianWithout(const std::vector<double>& sorted, size_t k) {
  const size_t count = sorted.size() - 1, middle = count / 2;
  const auto at = [&](size_t i) { return sorted[i < k ? i : i + 1]; };
  return count % 2 == 1 ? at(middle) : 0.5 * (at(middle - 1) + at(middle));
}

// Touches of a group that went the same way, by the foot of their line of approach: the point of it that is nearest to
// the origin. Finds those of one line without looking at all others.
class Lines {
 public:
  Lines(const MeasuringRun& run, const Group& group) {
    for (size_t i = 0; i < group.readings.size(); ++i) {
      const Eigen::Vector3d& approach = run.touches.approach[group.readings[i]];
      foot_mm_.push_back(group.turned_mm[i] - group.turned_mm[i].dot(approach) * approach);
      way_.push_back(CellOf(approach, kSameWay));
      cells_[{way_.back(), CellOf(foot_mm_.back(), kSameLineMm)}].push_back(i);
    }
  }

  // Takes out the touches whose foot is within kSameLineMm of the i-th's, in time order; none if it was taken before.
  std::vector<size_t> Take(size_t i) {
    std::vector<size_t> out;
    const Cell cell = CellOf(foot_mm_[i], kSameLineMm);
    for (int64_t n = 0; n < 27; ++n) {
      const auto found = cells_.find({way_[i], {cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1}});
      if (found == cells_.end()) continue;
      std::erase_if(found->second, [&](size_t j) {
        if ((foot_mm_[j] - foot_mm_[i]).norm() > kSameLineMm) return false;
        out.push_back(j);
        return true;
      });
    }
    std::sort(out.begin(), out.end());
    return std::binary_search(out.begin(), out.end(), i) ? out : std::vector<size_t>();
  }

 private:
  using Cell = std::array<int64_t, 3>;
  static constexpr double kSameWay = 1e-6;      // of a unit vector: six decimals, as files state it
  static constexpr double kSameLineMm = 0.010;  // across the approach: what a control's positioning leaves

  static Cell CellOf(const Eigen::Vector3d& v, double size) {
    return {std::llround(v.x() / size), std::llround(v.y() / size), std::llround(v.z() / size)};
  }

  std::vector<Eigen::Vector3d> foot_mm_;
  std::vector<Cell> way_;
  std::map<std::pair<Cell, Cell>, std::vector<size_t>> cells_;
};

// Repeats of one touch have one place across the approach. Of two that differ nobody can say which is wrong; of three
// or more it is the one that is off the median of the others.
void GateRepeats(const MeasuringRun& run, const Group& group, double gate_mm, std::vector<Rejection>* rejected) {
  Lines lines(run, group);
  for (size_t i = 0; i < group.readings.size(); ++i) {
    const std::vector<size_t> repeats = lines.Take(i);
    if (repeats.size() < 2) continue;
    const Eigen::Vector3d& approach = run.touches.approach[group.readings[i]];
    std::vector<double> along_mm;
    for (const size_t j : repeats) along_mm.push_back((group.turned_mm[j] - group.turned_mm[i]).dot(approach));
    std::vector<double> sorted_mm = along_mm;
    std::sort(sorted_mm.begin(), sorted_mm.end());
    for (size_t k = 0; k < repeats.size(); ++k) {
      const auto at = std::lower_bound(sorted_mm.begin(), sorted_mm.end(), along_mm[k]);
      const double off_mm =
          std::abs(along_mm[k] - MedianWithout(sorted_mm, static_cast<size_t>(at - sorted_mm.begin())));
      const double from_all_mm = std::abs(along_mm[k] - MedianOf(sorted_mm));
      if (off_mm > gate_mm && (repeats.size() < 3 || from_all_mm > 0.5 * gate_mm))
        rejected->push_back({group.readings[repeats[k]], "repeat", off_mm, gate_mm});
    }
  }
}

// Rejects the touches that stand off the sphere of the other touches, but for those that are rejected already. A sphere
// of another radius is refused.
absl::Status GateSphere(const MeasuringRun& run, const Feature& feature, const Group& group, double gate_mm,
                        std::vector<Rejection>* rejected) {
  const int first = run.readings_before + group.readings[0] + 1;
  const SphereOfMost judged = FitSphereOfMost(group.in_table_mm, gate_mm);
  const std::optional<Sphere>& sphere = judged.sphere;
  std::set<int> known;
  for (const Rejection& one : *rejected) known.insert(one.reading);
  for (const OffSphere& off : judged.off) {
    const int reading = group.readings[off.point];
    if (known.count(reading) == 0) rejected->push_back({reading, "sphere", off.off_mm, gate_mm});
  }
  const double expected_mm = feature.radius_mm + run.touches.stylus_radius_mm;
  if (!sphere || std::abs(sphere->radius_mm - expected_mm) <= gate_mm) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "session '%s': the %d touches of sphere '%s' from reading %d lie on a radius of %.4f mm, expected %.4f "
      "(sphere %g + stylus_radius_mm %g) within radius_gate_um = %g: was it measured with another stylus?",
      run.session, group.readings.size() - judged.off.size(), feature.name, first, sphere->radius_mm, expected_mm,
      feature.radius_mm, run.touches.stylus_radius_mm, gate_mm / base::kMmPerUm));
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
