#include "tests/rates/planned_case.h"

#include <set>

#include "core/base/demand.h"
#include "core/base/random.h"
#include "core/base/units.h"
#include "core/logs/testing/planned_log.h"
#include "core/plan/testing/situations.h"
#include "core/synthetic/simulate.h"

namespace axiscal::rates {
namespace {

using machine::AxisKind;
using machine::Component;
using machine::Machine;

// One standard deviation of what a machine has.
constexpr double kPlaceMm = 30e-3, kTiltRad = 70e-6;                   // constants
constexpr double kScaleMm = 40e-3, kBacklashMm = 4e-3;                 // of a linear axis: per metre; peak to peak
constexpr double kBowMm = 5e-3, kTurnRad = 30e-6;                      // 250 mm from its zero
constexpr double kRotaryScaleRad = 30e-6, kRotaryBacklashRad = 20e-6;  // of a rotary axis: per rad; peak to peak

machine::ErrorModel DrawTruth(const Machine& machine, bool with_motions, base::Random* random) {
  machine::ErrorModel truth = machine::DeclaredModel(machine);
  for (machine::ErrorTerm& term : truth.terms)
    term.amplitude[0] = random->Normal() * (machine::IsAngle(term.component) ? kTiltRad : kPlaceMm);
  if (!with_motions) return truth;
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    int along = 0;
    machine.axes[axis].direction.cwiseAbs().maxCoeff(&along);
    const auto add = [&](int component, const shapes::Shape& shape, double sigma) {
      truth.terms.push_back({axis, static_cast<Component>(component), shape, {sigma * random->Normal()}});
    };
    if (machine.axes[axis].kind == AxisKind::kRotary) {
      add(along + 3, shapes::Linear{axis, shapes::Linear::kReferenceRad}, kRotaryScaleRad);
      add(along + 3, shapes::Backlash{axis}, kRotaryBacklashRad);
      continue;
    }
    add(along, shapes::Linear{axis}, kScaleMm);
    add(along, shapes::Backlash{axis}, kBacklashMm);
    for (int component = 0; component < machine::kComponents; ++component) {
      if (component == along) continue;
      add(component, shapes::Quadratic{axis}, component < 3 ? kBowMm : kTurnRad);
    }
  }
  return truth;
}

// Linear axes of 800 mm, so that tests along them go farther than where nobody states a travel.
Machine WithTravel(Machine machine) {
  constexpr double kHalfMm = 400.0;
  for (machine::Axis& axis : machine.axes) {
    if (axis.kind != AxisKind::kLinear) continue;
    axis.min_position = -kHalfMm;
    axis.max_position = kHalfMm;
  }
  return machine;
}

}  // namespace

std::vector<PlannedCase> PlannedCases(const std::string& name) {
  const plan::Test* const test = plan::FindTest(name);
  DEMAND(test != nullptr);
  std::vector<PlannedCase> cases;
  std::vector<Machine> machines = plan::testing::Machines();
  machines.push_back(plan::testing::Arm());
  for (const Machine& machine : machines) {
    const Machine with_travel = WithTravel(machine);
    std::vector<instruments::MeasuringRun> runs;
    std::set<std::string> known;
    for (const plan::Situation& situation :
         {plan::testing::NeverMeasured(machine), plan::testing::NeverMeasured(with_travel),
          plan::testing::Measured(machine, &runs)}) {
      PlannedCase all{machine, name, "", {}};
      for (const plan::PlannedSession& one : test->plan(situation)) {
        if (!plan::ReachOf(situation, one.session).is_reachable) continue;
        if (!known.insert(plan::ToTable(one.session)).second) continue;
        all.sessions.push_back(one.session);
      }
      if (all.sessions.empty()) continue;
      all.instrument = logs::testing::HeaderOf(all.sessions[0], "instrument");
      if (all.sessions.size() > 1) cases.push_back(all);
      for (const session::Session& session : all.sessions)
        cases.push_back({machine, name, logs::testing::HeaderOf(session, "instrument"), {session}});
    }
  }
  return cases;
}

namespace {

// Where the simulated probe misses its feature (a set-up that was drawn far off), it is set up once more.
absl::StatusOr<session::Session> Measure(const Machine& machine, const machine::ErrorModel& truth,
                                         const session::Session& planned, uint64_t seed) {
  constexpr uint64_t kAttempts = 10;
  absl::StatusOr<session::Session> read = absl::UnknownError("");
  for (uint64_t attempt = 0; attempt < kAttempts && !read.ok(); ++attempt) {
    synthetic::NoiseOptions noise;
    noise.seed = base::StreamSeed(seed, attempt);
    read = synthetic::Simulate(machine, truth, planned, noise);
  }
  return read;
}

// So few readings are not asked for twenty motions of axes.
bool AreEnough(const PlannedCase& planned) {
  constexpr size_t kFewest = 40;
  size_t readings = 0;
  for (const session::Session& session : planned.sessions) readings += session.reading_count();
  return readings >= kFewest;
}

}  // namespace

absl::StatusOr<PlannedFit> IdentifyPlanned(const PlannedCase& planned, uint64_t seed, bool with_motions) {
  base::Random random(base::StreamSeed(seed, 0));
  PlannedFit out;
  out.truth = DrawTruth(planned.machine, with_motions && AreEnough(planned), &random);
  std::vector<session::Session> measured;
  for (const session::Session& session : planned.sessions) {
    ASSIGN_OR_RETURN(const session::Session read,
                     Measure(planned.machine, out.truth, session, base::StreamSeed(seed, measured.size() + 1)));
    ASSIGN_OR_RETURN(measured.emplace_back(), logs::testing::ThroughLog(planned.machine, session, read));
  }
  identify::Options options;
  options.fit_nonlinear = false;
  options.model = out.truth;
  for (machine::ErrorTerm& term : options.model->terms) term.amplitude.fill(0.0);
  ASSIGN_OR_RETURN(out.fit, identify::FitSessions(planned.machine, measured, options));
  return out;
}

}  // namespace axiscal::rates
