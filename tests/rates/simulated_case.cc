#include "tests/rates/simulated_case.h"

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/base/testing/source_path.h"
#include "core/base/units.h"
#include "core/identify/identify.h"
#include "core/loop/dictionary.h"
#include "core/loop/signatures.h"
#include "core/synthetic/sampling.h"
#include "core/synthetic/simulate.h"

namespace axiscal::rates {
namespace {

using machine::AxisKind;
using machine::Component;
using machine::ErrorTerm;
using machine::Machine;

using Dice = base::Random;

template <typename T>
T Of(std::initializer_list<T> values, Dice* dice) {
  return *(values.begin() + dice->Below(values.size()));
}

session::Case Plan(const char* name) { return session::ReadCase(base::SourcePath("/tests/data/loop/") + name).value(); }

// Every plan with another sampling, speed and temperature.
void Vary(std::vector<session::Session>* sessions, int stride, int density, double slower, double warming_per_s) {
  for (session::Session& session : *sessions) {
    if (session.reading_count() > 200) {
      synthetic::KeepEvery(stride, &session);
      synthetic::Refine(density, &session);
    }
    synthetic::Slow(slower, &session);
    if (warming_per_s == 0.0 || session::FindColumn(session, "temp_C") == nullptr) continue;
    synthetic::SetTemperature(
        "temp_C", [&](double time_s) { return 20.0 + warming_per_s * time_s; }, &session);
  }
}

bool Moves(const std::vector<instruments::MeasuringRun>& runs, int axis) {
  for (const instruments::MeasuringRun& run : runs) {
    for (int k = 1; k < run.reading_count(); ++k) {
      if (run.PositionsOf(k)[axis] != run.PositionsOf(0)[axis]) return true;
    }
  }
  return false;
}

ErrorTerm DrawEffect(const Machine& machine, const std::vector<instruments::MeasuringRun>& runs,
                     const std::vector<double>& finest_step, bool has_warming, Dice* dice) {
  std::vector<int> linear, rotary;
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    if (Moves(runs, axis)) (machine.axes[axis].kind == AxisKind::kLinear ? linear : rotary).push_back(axis);
  }
  const auto own = [&](int axis) {
    int along = 0;
    machine.axes[axis].direction.cwiseAbs().maxCoeff(&along);
    return static_cast<Component>(along + (machine.axes[axis].kind == AxisKind::kRotary ? 3 : 0));
  };
  const int any_linear = linear[dice->Below(linear.size())], any_rotary = rotary[dice->Below(rotary.size())];
  const int any_axis = dice->Chance(0.5) ? any_linear : any_rotary;
  switch (dice->Below(has_warming ? 8 : 7)) {
    case 0:
      return {any_axis, own(any_axis), shapes::Backlash{any_axis}, {1.0, 0.0}};
    case 1:
      return {any_linear, own(any_linear), shapes::Reversal{any_linear, dice->Uniform(3.0, 9.0)}, {1.0, 0.0}};
    case 2: {
      const double phase = dice->Uniform(0.0, 2.0 * M_PI);
      double order = dice->Chance(0.25) ? Of({10.0, 24.0, 36.0, 45.0}, dice) : Of({1.0, 2.0, 3.0}, dice);
      const double finest = 0.8 * M_PI / finest_step[any_rotary];
      if (order > finest) order = finest < 2.0 ? 1.0 : Of({1.0, 2.0}, dice);  // the sampling hides it
      const Component component = Of({Component::kX, Component::kY, Component::kZ, own(any_rotary)}, dice);
      return {any_rotary, component, shapes::Harmonic{any_rotary, order}, {std::cos(phase), std::sin(phase)}};
    }
    case 3:
      return {any_linear,
              Of({Component::kX, Component::kY, Component::kZ}, dice),
              shapes::Quadratic{any_linear, shapes::Quadratic::kReferenceMm},
              {1.0, 0.0}};
    case 4:
      return {machine.tool_joint(), Of({Component::kX, Component::kZ}, dice), shapes::Drift{}, {1.0, 0.0}};
    case 5:
      return {machine.tool_joint(), Component::kZ, shapes::DriftExp{dice->Uniform(600.0, 2400.0)}, {1.0, 0.0}};
    case 6: {
      const double frequency = 2.0 * M_PI / dice->Uniform(10.0, 30.0), phase = dice->Uniform(0.0, 2.0 * M_PI);
      return {any_linear, own(any_linear), shapes::Harmonic{any_linear, frequency}, {std::cos(phase), std::sin(phase)}};
    }
    default:
      return {machine.tool_joint(), Of({Component::kX, Component::kZ}, dice), shapes::Thermal{}, {1.0, 0.0}};
  }
}

// Scales the effect until its unexplained signature has the wanted rms; false where the data hardly sees it.
bool Scale(const identify::Problem& problem, const identify::Point& point, double signal_to_noise, ErrorTerm* effect) {
  const loop::Signatures signatures(problem, point, identify::ListParameters(point.model, true));
  const loop::Projection projection = signatures.Project({{loop::Family::kHarmonic, *effect, -1, 0}})[0];
  const int n = projection.columns;
  const Eigen::Vector3d shape(effect->amplitude[0], effect->amplitude[1], 0.0);
  const double squares = shape.head(n).dot(projection.own.topLeftCorner(n, n) * shape.head(n));
  if (projection.visible < 1e-3 || !(squares > 0.0)) return false;
  const double factor = signal_to_noise * std::sqrt(signatures.row_count() / squares);
  for (double& amplitude : effect->amplitude) amplitude *= factor;
  // Nobody overlooks a millimetre: where only a huge amplitude shows, the data does not see the effect.
  const double limit = machine::IsAngle(effect->component) ? 1e-3 : 0.2;
  return std::abs(effect->amplitude[0]) + std::abs(effect->amplitude[1]) < limit;
}

std::vector<instruments::MeasuringRun> Bind(const Machine& machine, const std::vector<session::Session>& sessions) {
  return identify::BindSessions(machine, sessions).value();
}

// The same of all sessions.
struct Measuring {
  double sigma_scale = 1.0;
  bool is_dirty = false, does_wander = false;
  double resolution_sigmas = 0.0;  // readings are rounded to; 0: as finely as files are written
};

std::vector<session::Session> Measure(const Machine& machine, const machine::ErrorModel& truth,
                                      const std::vector<session::Session>& planned, const Measuring& how, Dice* dice,
                                      std::vector<synthetic::BadReading>* bad) {
  std::vector<session::Session> measured;
  for (const session::Session& plan : planned) {
    const bool is_ballbar = session::FindHeader(plan, "instrument") == "ballbar";
    synthetic::NoiseOptions noise;
    noise.sigma_scale = how.sigma_scale;
    noise.ar1 = !is_ballbar ? 0.0 : how.is_dirty ? 0.6 : how.does_wander ? 0.8 : 0.0;
    noise.white_share = is_ballbar && how.does_wander ? 0.5 : 0.0;
    const double stated_mm = Bind(machine, {plan})[0].sigma_mm;
    noise.resolution_mm = how.resolution_sigmas > 0.0 ? how.resolution_sigmas * stated_mm : 1e-4;
    noise.seed = static_cast<uint64_t>(dice->Uniform(1.0, 1e15));
    session::Session session = synthetic::Simulate(machine, truth, plan, noise).value();
    if (how.is_dirty) {
      const auto spoiled = synthetic::SpoilReadings(Bind(machine, {session})[0], 0.01, how.sigma_scale, dice, &session);
      bad->insert(bad->end(), spoiled.begin(), spoiled.end());
    }
    measured.push_back(std::move(session));
  }
  return measured;
}

// Something slips in a session that was measured: from a reading on its readings are those of a machine on which it
// stands elsewhere. Added to what was read, so that noise and rounding stay.
void AddSlip(const Machine& machine, const machine::ErrorModel& truth, const session::Session& planned,
             instruments::Carrier carrier, size_t first, const Eigen::Vector3d& slip_mm, session::Session* measured) {
  const int joint = carrier == instruments::Carrier::kTable ? machine.work_joint() : machine.tool_joint();
  synthetic::Measuring exact;
  exact.noise.sigma_scale = 0.0;
  exact.noise.draw_setup = false;
  const auto readings = [&](const Eigen::Vector3d& off_mm) {
    exact.errors_at = [&](int, const shapes::State& state) {
      machine::JointErrors<double> errors = machine::ErrorsAt(machine, truth, state);
      errors[joint].head<3>() += off_mm;
      return errors;
    };
    return synthetic::Measure(machine, exact, planned).value();
  };
  const session::Session before = readings(Eigen::Vector3d::Zero()), after = readings(slip_mm);
  const int rows = Bind(machine, {*measured})[0].row_count;
  for (size_t column = measured->columns.size() - rows; column < measured->columns.size(); ++column) {
    for (size_t k = first; k < measured->reading_count(); ++k)
      measured->columns[column].values[k] += after.columns[column].values[k] - before.columns[column].values[k];
  }
}

}  // namespace

SimulatedCase Draw(Kind kind, uint64_t seed, int density) {
  Dice dice(seed * 977 + static_cast<uint64_t>(kind) * 7919 + 1);
  const bool is_dirty = kind == Kind::kDirty || kind == Kind::kDirtyNull;
  session::Case plan = Plan(Of({"case-003", "case-012", "case-001", "case-013", "case-002", "case-014"}, &dice));
  SimulatedCase out;
  out.machine = plan.machine;
  const bool has_warming = dice.Chance(0.5);
  const double slower = dice.Uniform(0.6, 1.6), warming = has_warming ? dice.Uniform(2e-4, 8e-4) : 0.0;
  const int stride = Of({1, 1, 2}, &dice);
  Vary(&plan.fit, stride, density, slower, warming);
  Vary(&plan.check, stride, density, slower, warming);
  out.sigma_scale = is_dirty                   ? std::exp(dice.Uniform(-1.0, 1.0) * std::log(2.0))
                    : kind == Kind::kMisstated ? Of({0.5, 2.0}, &dice)
                                               : 1.0;
  out.declared = machine::DeclaredModel(out.machine);
  for (ErrorTerm& term : out.declared.terms)
    term.amplitude[0] = dice.Normal() * (machine::IsAngle(term.component) ? 70e-6 : 30e-3);

  // Amplitudes from the signatures at the declared errors.
  machine::ErrorModel truth = out.declared;
  identify::Problem problem = identify::MakeProblem(out.machine, Bind(out.machine, plan.fit)).value();
  for (identify::Noise& noise : problem.noise) noise.sigma_mm *= out.sigma_scale;
  const identify::Point point = identify::StartingPoint(problem, out.declared);
  std::vector<double> finest_step;
  for (const loop::AxisSpan& span : loop::SpansOf(problem)) finest_step.push_back(span.finest_step);
  const bool has_one = kind == Kind::kOne || kind == Kind::kMisstated || kind == Kind::kBump || kind == Kind::kWander ||
                       kind == Kind::kCoarse;
  const int count = has_one ? 1 : kind == Kind::kPair ? 2 : kind == Kind::kDirty ? 2 + dice.Below(3) : 0;
  while (static_cast<int>(out.effects.terms.size()) < count) {
    ErrorTerm effect = DrawEffect(out.machine, problem.runs, finest_step, has_warming, &dice);
    if (kind == Kind::kBump) {
      int axis = 0;
      do axis = dice.Below(out.machine.axis_count());
      while (out.machine.axes[axis].kind == AxisKind::kRotary || !Moves(problem.runs, axis));
      double low = INFINITY, high = -INFINITY;
      for (const instruments::MeasuringRun& run : problem.runs) {
        for (int k = 0; k < run.reading_count(); ++k) {
          low = std::min(low, run.PositionsOf(k)[axis]);
          high = std::max(high, run.PositionsOf(k)[axis]);
        }
      }
      effect = {axis,
                Of({Component::kX, Component::kY, Component::kZ}, &dice),
                shapes::Bump{axis, dice.Uniform(low + 0.15 * (high - low), high - 0.15 * (high - low)),
                             (high - low) * dice.Uniform(0.03, 0.1)},
                {1.0, 0.0}};
    }
    const bool is_twice = std::any_of(out.effects.terms.begin(), out.effects.terms.end(), [&](const ErrorTerm& other) {
      return other.joint == effect.joint && other.component == effect.component;
    });
    const double ratio = is_dirty                ? Of({0.3, 0.7, 1.5, 3.0}, &dice)
                         : kind == Kind::kWander ? Of({1.5, 3.0, 6.0}, &dice)
                         : kind == Kind::kCoarse ? Of({6.0, 12.0}, &dice)
                                                 : Of({0.5, 0.7, 1.5, 3.0, 6.0}, &dice);
    if (is_twice || !Scale(problem, point, ratio, &effect)) continue;
    out.effects.terms.push_back(effect);
    out.signal_to_noise.push_back(ratio);
    truth.terms.push_back(effect);
  }

  Measuring how = {out.sigma_scale, is_dirty, kind == Kind::kWander || kind == Kind::kWanderNull};
  if (kind == Kind::kCoarse || kind == Kind::kCoarseNull) how.resolution_sigmas = Of({2.5, 3.3, 5.0, 10.0}, &dice);
  std::vector<session::Session> fit = Measure(out.machine, truth, plan.fit, how, &dice, &out.bad);
  std::vector<synthetic::BadReading> bad_check;
  const std::vector<session::Session> check = Measure(out.machine, truth, plan.check, how, &dice, &bad_check);
  if (IsSlip(kind)) {
    // The table's ball slips in one session, or what the tool holder carries.
    int which = 0;
    do which = dice.Below(fit.size());
    while (fit[which].reading_count() < 60);
    const size_t readings = fit[which].reading_count();
    const auto first = static_cast<size_t>(dice.Uniform(0.2, 0.8) * static_cast<double>(readings));
    // As large as it takes to show in the session's own readings; a slip across the bar does not.
    const loop::Signatures signatures(problem, point, identify::ListParameters(point.model, true));
    out.carrier = kind == Kind::kSlip ? instruments::Carrier::kTable : instruments::Carrier::kTool;
    const loop::Projection seen =
        signatures.Project({{loop::Family::kStep, {}, which, static_cast<int>(first), 0, 0, out.carrier}})[0];
    Eigen::Vector3d slip_mm;
    double squares = 0.0;
    do {
      slip_mm = Eigen::Vector3d(dice.Normal(), dice.Normal(), dice.Normal()).normalized();
      squares = slip_mm.dot(seen.own * slip_mm);
    } while (squares < 0.1 * seen.own.diagonal().maxCoeff());
    const double numbers = static_cast<double>(problem.runs[which].measured_mm.size());
    slip_mm *= Of({0.5, 0.7, 1.5, 3.0}, &dice) * std::sqrt(numbers / squares);
    AddSlip(out.machine, truth, plan.fit[which], out.carrier, first, slip_mm, &fit[which]);
    out.slipped_session = problem.runs[which].session;
    out.slip_s = problem.runs[which].time_s[first];
  }
  out.fit = Bind(out.machine, fit);
  out.check = Bind(out.machine, check);
  return out;
}

}  // namespace axiscal::rates
