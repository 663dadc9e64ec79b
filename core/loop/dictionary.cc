#include "core/loop/dictionary.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "core/base/units.h"
#include "core/identify/outliers.h"
#include "core/loop/aliases.h"

namespace axiscal::loop {
namespace {

using instruments::MeasuringRun;
using machine::Component;
using machine::ErrorTerm;
using machine::kComponents;
using machine::Machine;

bool IsRotary(const Machine& machine, int axis) { return machine.axes[axis].kind == machine::AxisKind::kRotary; }

double StandsStill(const Machine& machine, int axis) {
  return IsRotary(machine, axis) ? kStandsStillRad : kStandsStillMm;
}

// That all sessions together take, in ascending order.
std::vector<double> PositionsOf(const identify::Problem& problem, int axis) {
  std::vector<double> positions;
  for (const MeasuringRun& run : problem.runs)
    for (int k = 0; k < run.reading_count(); ++k) positions.push_back(run.PositionsOf(k)[axis]);
  std::sort(positions.begin(), positions.end());
  return positions;
}

// Median distance of such positions next to each other.
double GapOf(const identify::Problem& problem, int axis) {
  const std::vector<double> positions = PositionsOf(problem, axis);
  std::vector<double> gaps;
  for (size_t k = 1; k < positions.size(); ++k) {
    const double gap = positions[k] - positions[k - 1];
    if (gap > StandsStill(*problem.machine, axis)) gaps.push_back(gap);
  }
  return identify::Median(&gaps);
}

class Builder {
 public:
  Builder(const identify::Problem& problem, const machine::ErrorModel& model)
      : problem_(problem), machine_(*problem.machine), model_(model), spans_(SpansOf(problem)) {}

  std::vector<Candidate> Build() {
    AddConstants();
    // An eccentricity is one number of a whole path: it has no state to look for other shapes at.
    if (std::any_of(problem_.runs.begin(), problem_.runs.end(),
                    [](const MeasuringRun& run) { return run.path_readings != nullptr; }))
      return std::move(candidates_);
    for (int axis = 0; axis < machine_.axis_count(); ++axis) {
      if (spans_[axis].finest_step == 0.0) continue;
      AddShapesOf(axis);
      AddMotionShapes(axis);
      AddBumps(axis);
    }
    AddLobes();
    AddTimeShapes();
    AddSteps();
    return std::move(candidates_);
  }

 private:
  void Add(Family family, int joint, const shapes::Shape& shape) {
    for (int component = 0; component < kComponents; ++component) {
      const ErrorTerm term{joint, static_cast<Component>(component), shape, {}};
      const auto holds = [&](const ErrorTerm& other) {
        return other.joint == joint && other.component == term.component && SameButParameter(other.shape, shape);
      };
      if (std::none_of(model_.terms.begin(), model_.terms.end(), holds)) candidates_.push_back({family, term, -1, 0});
    }
  }

  // A reversal of another length, a drift of another time constant or a pitch less than a period off is the same
  // effect, to be refitted rather than added again.
  bool SameButParameter(shapes::Shape a, shapes::Shape b) const {
    double *of_a = shapes::NonlinearParameter(a), *of_b = shapes::NonlinearParameter(b);
    if (of_a == nullptr || of_b == nullptr) return a == b;
    if (const auto* pitch = std::get_if<shapes::Harmonic>(&a)) {
      const double period = 2.0 * std::numbers::pi / (spans_[pitch->axis].highest - spans_[pitch->axis].lowest);
      if (std::abs(*of_a - *of_b) > period) return false;
    }
    *of_a = *of_b;
    return a == b;
  }

  void AddConstants() { AddAtAllJoints(Family::kConstant, shapes::Constant{}); }

  void AddShapesOf(int axis) {
    const bool is_rotary = IsRotary(machine_, axis);
    const shapes::Linear linear{axis, is_rotary ? shapes::Linear::kReferenceRad : shapes::Linear::kReferenceMm};
    const shapes::Quadratic quadratic{axis,
                                      is_rotary ? shapes::Quadratic::kReferenceRad : shapes::Quadratic::kReferenceMm};
    for (int joint = 0; joint < machine_.joint_count(); ++joint)
      Add(joint == axis ? Family::kLinear : Family::kCross, joint, linear);
    for (int joint = 0; joint < machine_.joint_count(); ++joint)
      Add(joint == axis ? Family::kQuadratic : Family::kCross, joint, quadratic);
    for (int order = 1; is_rotary && order <= 2; ++order) {
      for (int joint = 0; joint < machine_.joint_count(); ++joint) {
        if (joint != axis) Add(Family::kCross, joint, shapes::Harmonic{axis, static_cast<double>(order)});
      }
    }
    AddHarmonics(axis, is_rotary);
  }

  void AddHarmonics(int axis, bool is_rotary) {
    const AxisSpan& span = spans_[axis];
    const double highest = kBelowNyquist * span.highest_frequency;
    if (is_rotary) {
      constexpr int kCoarse = 4;
      // On a part of a turn neighbouring orders are alike; an order must show at least half a period.
      const double lowest = std::numbers::pi / (span.highest - span.lowest);
      for (int order = 1; order <= std::min<int>(kHighestOrder, static_cast<int>(highest)); ++order) {
        if (order < 0.5 * lowest) continue;
        Add(order <= kCoarse ? Family::kHarmonic : Family::kFineHarmonic, axis,
            shapes::Harmonic{axis, static_cast<double>(order)});
      }
    }
    // Pitch errors along a linear axis, ripple of broken order of a rotary one: at least three periods in the measured
    // range. Frequencies stand kPitchStep of a period apart; those of a rotary axis half-way between whole orders,
    // which are there already, or a period apart where that is less.
    const double range = span.highest - span.lowest, period = 2.0 * std::numbers::pi / range;
    const double step = is_rotary ? std::min(1.0, period) : kPitchStep * period;
    const double first = is_rotary ? std::floor(3.0 * period / step) * step + 0.5 * step : 3.0 * period;
    for (double frequency = first; frequency < std::min(highest, kMostPeriods * period); frequency += step)
      Add(Family::kPitch, axis, shapes::Harmonic{axis, frequency, true});
  }

  void AddMotionShapes(int axis) {
    const AxisSpan& span = spans_[axis];
    if (span.has_both_senses) Add(Family::kBacklash, axis, shapes::Backlash{axis});
    const double unit = IsRotary(machine_, axis) ? base::kRadPerDeg : 1.0;
    for (const double length : {1.0, 2.0, 4.0, 8.0, 16.0}) {
      if (length * unit < 4.0 * (span.highest - span.lowest))
        Add(Family::kReversal, axis, shapes::Reversal{axis, length * unit});
    }
    if (!span.has_speeds) return;
    Add(Family::kLag, axis, shapes::Lag{axis});
    Add(Family::kLag, axis, shapes::Acceleration{axis});
  }

  void AddTimeShapes() {
    double first_s = INFINITY, last_s = -INFINITY, coldest = INFINITY, warmest = -INFINITY;
    for (const MeasuringRun& run : problem_.runs) {
      if (run.has_time) {
        first_s = std::min(first_s, run.time_s.front());
        last_s = std::max(last_s, run.time_s.back());
      }
      for (const double celsius : run.temperature_celsius) {
        coldest = std::min(coldest, celsius);
        warmest = std::max(warmest, celsius);
      }
    }
    constexpr double kShortest = 60.0, kSmallestWarming = 0.05;
    if (last_s - first_s > kShortest && AllTimed()) {
      AddAtAllJoints(Family::kDrift, shapes::Drift{});
      for (const double share : kWarmings) AddAtAllJoints(Family::kDriftExp, shapes::DriftExp{share * last_s});
    }
    // A session without temperatures has 20 degrees in their place: nothing is told from that.
    const bool is_recorded = std::all_of(problem_.runs.begin(), problem_.runs.end(), [](const MeasuringRun& run) {
      return run.path_readings != nullptr || run.has_temperature;
    });
    if (is_recorded && warmest - coldest > kSmallestWarming) AddAtAllJoints(Family::kThermal, shapes::Thermal{});
  }

  void AddAtAllJoints(Family family, const shapes::Shape& shape) {
    for (int joint = 0; joint < machine_.joint_count(); ++joint) Add(family, joint, shape);
  }

  // Pre-travel of the touch probe: as many lobes as the directions of the touches tell apart.
  void AddLobes() {
    constexpr double kAcross = 0.1, kApartDeg = 1.0;
    constexpr int kMostLobes = 6;
    std::set<long> azimuths;
    for (const MeasuringRun& run : problem_.runs) {
      for (const shapes::Approach& approach : run.touches.approach_in_spindle) {
        if (approach.across > kAcross)
          azimuths.insert(std::lround(approach.azimuth_rad / (kApartDeg * base::kRadPerDeg)));
      }
    }
    if (std::none_of(problem_.runs.begin(), problem_.runs.end(),
                     [](const MeasuringRun& run) { return run.kind == instruments::Kind::kTouch; }))
      return;
    AddAlongApproach(shapes::PreTravel{});
    const int highest = std::min(kMostLobes, (static_cast<int>(azimuths.size()) - 1) / 2);
    // One lobe is a stylus beside its place: EX0T and EY0T.
    for (int order = 2; order <= highest; ++order) AddAlongApproach(shapes::Lobe{order});
  }

  void AddAlongApproach(const shapes::Shape& shape) {
    const ErrorTerm term = machine::AlongApproachTerm(machine_, shape);
    const auto holds = [&](const ErrorTerm& other) { return other.shape == shape; };
    if (std::none_of(model_.terms.begin(), model_.terms.end(), holds))
      candidates_.push_back({Family::kLobe, term, -1, 0});
  }

  bool AllTimed() const {
    return std::all_of(problem_.runs.begin(), problem_.runs.end(),
                       [](const MeasuringRun& run) { return run.has_time; });
  }

  void AddBumps(int axis) {
    const AxisSpan& span = spans_[axis];
    const double range = span.highest - span.lowest, gap = GapOf(problem_, axis);
    const std::vector<double> positions = PositionsOf(problem_, axis);
    // Of one between the places where readings stand they would see its foot alone, and any height would fit them.
    const auto is_seen = [&](double at, double width) {
      const auto next = std::lower_bound(positions.begin(), positions.end(), at - 0.5 * width);
      return next != positions.end() && *next <= at + 0.5 * width;
    };
    for (const double share : {0.16, 0.08, 0.04, 0.02}) {
      const double width = share * range;
      // An R-test visits its poses in jumps; sorted, they lie as close as those of a sweep.
      if (width < std::min(gap, span.finest_step)) break;
      if (width > WidestBump(machine_, axis)) continue;
      for (double at = span.lowest; at <= span.highest; at += width)
        if (is_seen(at, width)) Add(Family::kBump, axis, shapes::Bump{axis, at, width});
    }
  }

  void AddSteps() {
    for (size_t i = 0; i < problem_.runs.size(); ++i) {
      const MeasuringRun& run = problem_.runs[i];
      if (run.slips.size() == instruments::kMaxSlips) continue;
      if (run.kind == instruments::Kind::kDirection) continue;  // no shift is seen
      // A tracker does not see the table, and a tracker that slips may turn too; nor does a beam have a place.
      const bool has_table =
          run.kind != instruments::Kind::kTracker && !(run.kind == instruments::Kind::kLength && run.length.is_beam);
      if (has_table) AddSteps(static_cast<int>(i), instruments::Carrier::kTable);
      if (!has_table || TurnsAny(run)) AddSteps(static_cast<int>(i), instruments::Carrier::kTool);
    }
  }

  void AddSteps(int index, instruments::Carrier carrier) {
    const MeasuringRun& run = problem_.runs[index];
    for (int k = kSlipReadings; k + kSlipReadings <= run.reading_count(); k += StepStride(run)) {
      const bool is_near = std::any_of(run.slips.begin(), run.slips.end(), [k](const instruments::Slip& slip) {
        return std::abs(slip.first_reading - k) < kSlipReadings;
      });
      if (!is_near) candidates_.push_back({Family::kStep, {}, index, k, 0, 0, carrier});
    }
  }

  // Where no rotary axis turns, a slip of the table and one of the tool look alike.
  bool TurnsAny(const MeasuringRun& run) const {
    for (int axis = 0; axis < machine_.axis_count(); ++axis) {
      if (!IsRotary(machine_, axis)) continue;
      for (int k = 1; k < run.reading_count(); ++k)
        if (std::abs(run.PositionsOf(k)[axis] - run.PositionsOf(0)[axis]) > kStandsStillRad) return true;
    }
    return false;
  }

  const identify::Problem& problem_;
  const Machine& machine_;
  const machine::ErrorModel& model_;
  const std::vector<AxisSpan> spans_;
  std::vector<Candidate> candidates_;
};

bool IsPositioning(const Machine& machine, const ErrorTerm& term) {
  return term.joint < machine.axis_count() && term.component == machine::PositioningOf(machine, term.joint);
}

// ISO 230-1 names location errors of rotary axes and squareness of linear ones, which no turn about their own direction
// is; the constant shift of a linear axis is only where its zero is.
int ConstantComplexity(const Machine& machine, const ErrorTerm& term) {
  const bool is_angle = machine::IsAngle(term.component);
  if (term.joint == machine.tool_joint()) return is_angle ? 4 : 1;
  if (term.joint == machine.work_joint()) return is_angle ? 5 : 3;
  const machine::Axis& axis = machine.axes[term.joint];
  if (IsRotary(machine, term.joint)) return 0;
  if (!is_angle) return 6;
  int along = 0;
  axis.direction.cwiseAbs().maxCoeff(&along);
  return static_cast<int>(term.component) - 3 == along ? 3 : 2;
}

}  // namespace

double WidestBump(const machine::Machine& machine, int axis) {
  constexpr double kWidestRad = 30.0 * base::kRadPerDeg;
  return IsRotary(machine, axis) ? kWidestRad : INFINITY;
}

double StepOf(const Machine& machine, const MeasuringRun& run, int axis) {
  std::vector<double> steps;
  for (int k = 1; k < run.reading_count(); ++k) {
    const double step = std::abs(run.PositionsOf(k)[axis] - run.PositionsOf(k - 1)[axis]);
    if (step > StandsStill(machine, axis)) steps.push_back(step);
  }
  return steps.size() < 4 ? 0.0 : identify::Median(&steps);
}

std::vector<AxisSpan> SpansOf(const identify::Problem& problem) {
  const Machine& machine = *problem.machine;
  std::vector<AxisSpan> spans(machine.axis_count());
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    AxisSpan& span = spans[axis];
    span.lowest = INFINITY;
    span.highest = -INFINITY;
    double slowest = INFINITY, fastest = 0.0;
    bool has_sense[2] = {false, false};
    for (const MeasuringRun& run : problem.runs) {
      for (int k = 0; k < run.reading_count(); ++k) {
        const shapes::AxisState& state = run.AxisStatesOf(k)[axis];
        span.lowest = std::min(span.lowest, state.position);
        span.highest = std::max(span.highest, state.position);
        if (state.sense != 0.0) has_sense[state.sense > 0.0] = true;
        if (state.speed != 0.0) {
          slowest = std::min(slowest, std::abs(state.speed));
          fastest = std::max(fastest, std::abs(state.speed));
        }
      }
      const double step = StepOf(machine, run, axis);
      if (step > 0.0) span.finest_step = span.finest_step == 0.0 ? step : std::min(span.finest_step, step);
    }
    if (span.finest_step > 0.0) {
      const double limit = IsRotary(machine, axis)
                               ? kHighestOrder / kBelowNyquist
                               : kMostPeriods * 2.0 * std::numbers::pi / (span.highest - span.lowest) / kBelowNyquist;
      span.highest_frequency = HighestFrequency(PositionsOf(problem, axis), limit);
    }
    span.has_both_senses = has_sense[0] && has_sense[1];
    constexpr double kOtherSpeed = 1.02;  // of one speed a lag is a backlash
    span.has_speeds = fastest > kOtherSpeed * slowest;
  }
  return spans;
}

double LastReadingS(const identify::Problem& problem) {
  double last_s = 0.0;
  for (const MeasuringRun& run : problem.runs) {
    if (run.has_time && !run.time_s.empty()) last_s = std::max(last_s, run.time_s.back());
  }
  return last_s;
}

int StepStride(const MeasuringRun& run) {
  constexpr int kMoments = 48 * kMomentsPerLook;
  return std::max(1, run.reading_count() / kMoments);
}

std::vector<Candidate> MakeDictionary(const identify::Problem& problem, const machine::ErrorModel& model) {
  return Builder(problem, model).Build();
}

shapes::Shape Everywhere(shapes::Shape shape) {
  if (auto* drift = std::get_if<shapes::Drift>(&shape)) *drift = {};
  if (auto* lag = std::get_if<shapes::ThermalLag>(&shape)) {
    lag->from_celsius = shapes::ThermalLag().from_celsius;
    lag->to_celsius = shapes::ThermalLag().to_celsius;
  }
  return shape;
}

bool IsSameEffect(const ErrorTerm& a, const ErrorTerm& b) {
  if (a.joint != b.joint || a.component != b.component) return false;
  const auto *pitch = std::get_if<shapes::Harmonic>(&a.shape), *other_pitch = std::get_if<shapes::Harmonic>(&b.shape);
  if (pitch != nullptr && other_pitch != nullptr && pitch->is_frequency_free && other_pitch->is_frequency_free) {
    constexpr double kOnePitch = 0.05;
    const double apart = std::abs(pitch->frequency - other_pitch->frequency);
    return pitch->axis == other_pitch->axis && apart < kOnePitch * other_pitch->frequency;
  }
  shapes::Shape one = Everywhere(a.shape), other = Everywhere(b.shape);
  double *of_one = shapes::NonlinearParameter(one), *of_other = shapes::NonlinearParameter(other);
  if (of_one != nullptr && of_other != nullptr) *of_one = *of_other = 1.0;
  auto *curve = shapes::CurveOf(one), *other_curve = shapes::CurveOf(other);
  if (curve != nullptr && other_curve != nullptr) curve->functions = other_curve->functions;  // of any smoothness
  return one == other;
}

int Complexity(const Machine& machine, const Candidate& candidate) {
  int complexity = 10 * static_cast<int>(candidate.family);
  if (candidate.family == Family::kStep) return complexity;
  // A local defect of a linear axis counts as simpler than one of a rotary axis.
  if (candidate.family == Family::kBump) {
    const int axis = *shapes::VariableAxis(candidate.term.shape);
    return complexity + (IsRotary(machine, axis) ? 2 : 0) + (candidate.term.joint == axis ? 0 : 1);
  }
  // Among the joints that may drift the tool comes first (heat acts there first), then the table, then the axes; bodies
  // grow before they tilt, which with one tool length reads the same.
  const bool is_time = candidate.family == Family::kDrift || candidate.family == Family::kDriftExp ||
                       candidate.family == Family::kThermal || candidate.family == Family::kThermalLag;
  if (is_time) {
    const int joint = candidate.term.joint;
    complexity += joint == machine.tool_joint() ? 0 : joint == machine.work_joint() ? 2 : 4;
    complexity += machine::IsAngle(candidate.term.component);
  }
  // Backlash and friction act first along the axis' own motion.
  const bool is_motion = candidate.family == Family::kBacklash || candidate.family == Family::kReversal ||
                         candidate.family == Family::kLag || candidate.family == Family::kHysteresis;
  if (is_motion && !IsPositioning(machine, candidate.term))
    complexity += machine::IsAngle(candidate.term.component) ? 2 : 1;
  if (candidate.family == Family::kConstant) complexity += ConstantComplexity(machine, candidate.term);
  return complexity;
}

}  // namespace axiscal::loop
