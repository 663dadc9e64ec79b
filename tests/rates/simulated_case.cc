#include "tests/rates/simulated_case.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "core/base/testing/source_path.h"
#include "core/base/units.h"
#include "core/identify/identify.h"
#include "core/loop/dictionary.h"
#include "core/loop/signatures.h"
#include "core/synthetic/simulate.h"

namespace axiscal::rates {
namespace {

using machine::AxisKind;
using machine::Component;
using machine::ErrorTerm;
using machine::Machine;

class Dice {
 public:
  explicit Dice(uint64_t seed) : random_(seed) {}
  double Uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_() >> 11) + 0.5) * 0x1p-53;
  }
  int Below(size_t count) { return static_cast<int>(random_() % count); }
  bool Chance(double share) { return Uniform(0.0, 1.0) < share; }
  double Gauss() { return std::sqrt(-2.0 * std::log(Uniform(0.0, 1.0))) * std::cos(2.0 * M_PI * Uniform(0.0, 1.0)); }
  template <typename T>
  T Of(std::initializer_list<T> values) {
    return *(values.begin() + Below(values.size()));
  }

 private:
  std::mt19937_64 random_;
};

session::Case Plan(const char* name) {
  return session::ReadCase(base::SourcePath("/tests/data/loop/") + name).value();
}

// Every plan with another sampling, speed and temperature.
void Vary(std::vector<session::Session>* sessions, int stride, double slower, double warming_per_s) {
  for (session::Session& session : *sessions) {
    const bool thin = session.reading_count() > 200;
    for (session::Column& column : session.columns) {
      std::vector<double> kept;
      for (size_t k = 0; k < column.values.size(); k += thin ? stride : 1) kept.push_back(column.values[k]);
      column.values = std::move(kept);
    }
    session::Column *time = nullptr, *temperature = nullptr;
    for (session::Column& column : session.columns) {
      if (column.name == "t_s") time = &column;
      if (column.name == "temp_C") temperature = &column;
    }
    for (double& t : time->values) t *= slower;
    if (temperature == nullptr || warming_per_s == 0.0) continue;
    for (size_t k = 0; k < time->values.size(); ++k)
      temperature->values[k] = std::round(1e3 * (20.0 + warming_per_s * time->values[k])) / 1e3;
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
      double order = dice->Chance(0.25) ? dice->Of({10.0, 24.0, 36.0, 45.0}) : dice->Of({1.0, 2.0, 3.0});
      const double finest = 0.8 * M_PI / finest_step[any_rotary];
      if (order > finest) order = finest < 2.0 ? 1.0 : dice->Of({1.0, 2.0});  // the sampling hides it
      const Component component = dice->Of({Component::kX, Component::kY, Component::kZ, own(any_rotary)});
      return {any_rotary, component, shapes::Harmonic{any_rotary, order}, {std::cos(phase), std::sin(phase)}};
    }
    case 3:
      return {any_linear,
              dice->Of({Component::kX, Component::kY, Component::kZ}),
              shapes::Quadratic{any_linear, shapes::Quadratic::kReferenceMm},
              {1.0, 0.0}};
    case 4:
      return {machine.tool_joint(), dice->Of({Component::kX, Component::kZ}), shapes::Drift{}, {1.0, 0.0}};
    case 5:
      return {machine.tool_joint(), Component::kZ, shapes::DriftExp{dice->Uniform(600.0, 2400.0)}, {1.0, 0.0}};
    case 6: {
      const double frequency = 2.0 * M_PI / dice->Uniform(10.0, 30.0), phase = dice->Uniform(0.0, 2.0 * M_PI);
      return {any_linear, own(any_linear), shapes::Harmonic{any_linear, frequency}, {std::cos(phase), std::sin(phase)}};
    }
    default:
      return {machine.tool_joint(), dice->Of({Component::kX, Component::kZ}), shapes::Thermal{}, {1.0, 0.0}};
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
                                      std::vector<BadReading>* bad) {
  std::vector<session::Session> sessions;
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
    const instruments::MeasuringRun run = Bind(machine, {session})[0];
    for (int k = 0; how.is_dirty && k < run.reading_count(); ++k) {
      for (int row = 0; row < run.row_count; ++row) {
        if (!dice->Chance(0.01)) continue;
        const double off =
            (dice->Chance(0.5) ? -1.0 : 1.0) * dice->Uniform(20.0, 100.0) * how.sigma_scale * run.sigma_mm;
        session.columns[session.columns.size() - run.row_count + row].values[k] += off;
        bad->push_back({run.session, k + 1, row});
      }
    }
    sessions.push_back(std::move(session));
  }
  return sessions;
}

}  // namespace

SimulatedCase Draw(Kind kind, uint64_t seed) {
  Dice dice(seed * 977 + static_cast<uint64_t>(kind) * 7919 + 1);
  const bool is_dirty = kind == Kind::kDirty || kind == Kind::kDirtyNull;
  session::Case plan = Plan(dice.Of({"case-003", "case-012", "case-001", "case-013", "case-002", "case-014"}));
  SimulatedCase out;
  out.machine = plan.machine;
  const bool has_warming = dice.Chance(0.5);
  const double slower = dice.Uniform(0.6, 1.6), warming = has_warming ? dice.Uniform(2e-4, 8e-4) : 0.0;
  const int stride = dice.Of({1, 1, 2});
  Vary(&plan.fit, stride, slower, warming);
  Vary(&plan.check, stride, slower, warming);
  out.sigma_scale = is_dirty                   ? std::exp(dice.Uniform(-1.0, 1.0) * std::log(2.0))
                    : kind == Kind::kMisstated ? dice.Of({0.5, 2.0})
                                               : 1.0;
  out.declared = machine::DeclaredModel(out.machine);
  for (ErrorTerm& term : out.declared.terms)
    term.amplitude[0] = dice.Gauss() * (machine::IsAngle(term.component) ? 70e-6 : 30e-3);

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
                dice.Of({Component::kX, Component::kY, Component::kZ}),
                shapes::Bump{axis, dice.Uniform(low + 0.15 * (high - low), high - 0.15 * (high - low)),
                             (high - low) * dice.Uniform(0.03, 0.1)},
                {1.0, 0.0}};
    }
    const bool is_twice = std::any_of(out.effects.terms.begin(), out.effects.terms.end(), [&](const ErrorTerm& other) {
      return other.joint == effect.joint && other.component == effect.component;
    });
    const double ratio = is_dirty                ? dice.Of({0.3, 0.7, 1.5, 3.0})
                         : kind == Kind::kWander ? dice.Of({1.5, 3.0, 6.0})
                         : kind == Kind::kCoarse ? dice.Of({6.0, 12.0})
                                                 : dice.Of({0.5, 0.7, 1.5, 3.0, 6.0});
    if (is_twice || !Scale(problem, point, ratio, &effect)) continue;
    out.effects.terms.push_back(effect);
    out.signal_to_noise.push_back(ratio);
    truth.terms.push_back(effect);
  }

  Measuring how = {out.sigma_scale, is_dirty, kind == Kind::kWander || kind == Kind::kWanderNull};
  if (kind == Kind::kCoarse || kind == Kind::kCoarseNull) how.resolution_sigmas = dice.Of({2.5, 3.3, 5.0, 10.0});
  std::vector<session::Session> fit = Measure(out.machine, truth, plan.fit, how, &dice, &out.bad);
  std::vector<BadReading> bad_check;
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
      slip_mm = Eigen::Vector3d(dice.Gauss(), dice.Gauss(), dice.Gauss()).normalized();
      squares = slip_mm.dot(seen.own * slip_mm);
    } while (squares < 0.1 * seen.own.diagonal().maxCoeff());
    const double numbers = static_cast<double>(problem.runs[which].measured_mm.size());
    slip_mm *= dice.Of({0.5, 0.7, 1.5, 3.0}) * std::sqrt(numbers / squares);
    machine::ErrorModel slipped = truth;
    const int joint = kind == Kind::kSlip ? out.machine.work_joint() : out.machine.tool_joint();
    for (const Component component : {Component::kX, Component::kY, Component::kZ}) {
      slipped.terms.push_back({joint, component, shapes::Constant{}, {slip_mm[static_cast<int>(component)], 0.0}});
    }
    synthetic::NoiseOptions exact;
    exact.sigma_scale = 0.0;
    exact.draw_setup = false;
    const session::Session before = synthetic::Simulate(out.machine, truth, plan.fit[which], exact).value();
    const session::Session after = synthetic::Simulate(out.machine, slipped, plan.fit[which], exact).value();
    const int rows = problem.runs[which].row_count;
    for (int row = 0; row < rows; ++row) {
      const size_t column = fit[which].columns.size() - rows + row;
      for (size_t k = first; k < readings; ++k)
        fit[which].columns[column].values[k] += after.columns[column].values[k] - before.columns[column].values[k];
    }
    out.slipped_session = problem.runs[which].session;
    out.slip_s = problem.runs[which].time_s[first];
  }
  out.fit = Bind(out.machine, fit);
  out.check = Bind(out.machine, check);
  return out;
}

}  // namespace axiscal::rates
