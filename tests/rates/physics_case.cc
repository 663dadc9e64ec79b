#include "tests/rates/physics_case.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <type_traits>

#include "core/base/testing/source_path.h"
#include "core/base/units.h"
#include "core/identify/identify.h"
#include "core/machine/chain.h"
#include "core/session/case.h"

namespace axiscal::rates {
namespace {

using instruments::Carrier;
using machine::AxisKind;
using machine::Component;
using synthetic::Effect;
using synthetic::EffectKind;
using synthetic::Fault;
using synthetic::FaultKind;
using synthetic::NominalFault;
using synthetic::NominalKind;
using synthetic::Scenario;

// Draws what is wrong with one machine.
class Author {
 public:
  Author(const machine::Machine& machine, const std::vector<bool>& moves, base::Random* random)
      : machine_(machine), random_(*random) {
    for (int axis = 0; axis < machine.axis_count(); ++axis) {
      if (moves[axis]) (machine.axes[axis].kind == AxisKind::kLinear ? linear_ : rotary_).push_back(axis);
    }
  }

  void Write(Physics kind, Scenario* scenario) {
    switch (kind) {
      case Physics::kNothing:
        return;
      case Physics::kCurves:
        for (int i = random_.Below(3); i >= 0; --i) scenario->effects.push_back(Curve());
        return;
      case Physics::kRipple:
        for (int i = random_.Below(2); i >= 0; --i) scenario->effects.push_back(Ripple());
        return;
      case Physics::kGravity:
        for (int i = random_.Below(2); i >= 0; --i) scenario->effects.push_back(Gravity());
        return;
      case Physics::kCrossed:
        scenario->effects.push_back(Crossed());
        return;
      case Physics::kHeat:
        return WriteHeat(scenario);
      case Physics::kHysteresis:
        for (int i = random_.Below(2); i >= 0; --i) scenario->effects.push_back(Hysteresis());
        return;
      case Physics::kFollowing:
        scenario->effects.push_back(Following());
        if (random_.Chance(0.5)) scenario->faults.push_back(Clock());
        return;
      case Physics::kInstrument:
        for (int i = random_.Below(2); i >= 0; --i) scenario->faults.push_back(AnyFault());
        return;
      case Physics::kNominal:
        scenario->nominal.push_back(Nominal());
        return;
      case Physics::kMixed:
        scenario->effects = {Curve()};
        if (random_.Chance(0.5)) scenario->effects.push_back(Gravity());
        if (random_.Chance(0.5)) scenario->effects.push_back(Hysteresis());
        if (random_.Chance(0.5)) scenario->effects.push_back(Ripple());
        if (random_.Chance(0.5)) WriteHeat(scenario);
        return;
    }
  }

 private:
  int Linear() { return linear_[random_.Below(linear_.size())]; }
  int Rotary() { return rotary_[random_.Below(rotary_.size())]; }
  int Axis() { return linear_.empty() || random_.Chance(0.5) ? Rotary() : Linear(); }
  double UpTo(double low, double high) { return low * std::exp(random_.Uniform() * std::log(high / low)); }

  Component Own(int axis) const {
    int along = 0;
    machine_.axes[axis].direction.cwiseAbs().maxCoeff(&along);
    return static_cast<Component>(along + (machine_.axes[axis].kind == AxisKind::kRotary ? 3 : 0));
  }
  Component Shift() { return static_cast<Component>(random_.Below(3)); }

  // 1.5 to 8 um, or as many times 4 urad.
  Effect Of(EffectKind kind, int joint, Component component) {
    Effect effect;
    effect.kind = kind;
    effect.joint = joint;
    effect.component = component;
    if (joint < machine_.axis_count()) effect.axis = joint;
    const double size = UpTo(1.5, 8.0);
    effect.rms = machine::IsAngle(component) ? 4.0 * size * base::kRadPerUrad : size * base::kMmPerUm;
    return effect;
  }

  Effect Curve() {
    const int axis = Axis();
    return Of(EffectKind::kCurve, axis, random_.Chance(0.3) ? Own(axis) : static_cast<Component>(random_.Below(6)));
  }
  Effect Ripple() {
    const int axis = Axis();
    Effect ripple = Of(EffectKind::kRipple, axis, random_.Chance(0.5) ? Own(axis) : Shift());
    const bool is_rotary = machine_.axes[axis].kind == AxisKind::kRotary;
    ripple.frequency = is_rotary ? random_.Uniform(2.0, 40.0) : 2.0 * M_PI / random_.Uniform(8.0, 50.0);
    ripple.rms *= 0.5;
    return ripple;
  }
  Effect Gravity() {
    // Joints at which a moment changes with the positions: those that others or an overhang load.
    const int axis = Axis();
    Effect gravity = Of(EffectKind::kGravity, axis, static_cast<Component>(3 + random_.Below(2)));
    gravity.axis = -1;
    return gravity;
  }
  Effect Crossed() {
    const int axis = Axis();
    Effect crossed = Of(EffectKind::kCrossed, axis, Shift());
    do crossed.second_axis = Axis();
    while (crossed.second_axis == axis);
    return crossed;
  }
  void WriteHeat(Scenario* scenario) {
    const bool is_recorded = random_.Chance(0.6);
    synthetic::Temperature warming;
    warming.name = is_recorded ? "temp_C" : "hidden";
    warming.is_recorded = is_recorded;
    warming.rise_celsius = random_.Uniform(2.0, 6.0);
    warming.tau_s = random_.Uniform(1500.0, 6000.0);
    warming.swing_celsius = random_.Uniform(0.2, 1.0);
    warming.period_s = random_.Uniform(1500.0, 5000.0);
    scenario->temperatures = {warming};
    const int joint = random_.Chance(0.7) ? machine_.tool_joint() : Axis();
    Effect heat = Of(EffectKind::kHeat, joint, random_.Chance(0.5) ? Component::kZ : Component::kX);
    heat.axis = -1;
    heat.channel = warming.name;
    heat.tau_s = random_.Uniform(300.0, 3000.0);
    if (!linear_.empty() && random_.Chance(0.3)) {
      heat.joint = heat.axis = Linear();
      heat.component = Own(heat.axis);
    }
    scenario->effects.push_back(heat);
    if (!random_.Chance(0.4)) return;
    heat.joint = machine_.tool_joint();
    heat.component = Component::kY;
    heat.axis = -1;
    heat.tau_s = random_.Uniform(600.0, 5000.0);
    if (random_.Chance(0.5)) heat.channel = synthetic::kTimeChannel;
    scenario->effects.push_back(heat);
  }
  Effect Hysteresis() {
    const int axis = Axis();
    const EffectKind kinds[] = {EffectKind::kBacklash, EffectKind::kWindUp, EffectKind::kFriction,
                                EffectKind::kLastMove};
    Effect effect = Of(kinds[random_.Below(4)], axis, Own(axis));
    effect.rms *= 0.6;
    return effect;
  }
  Effect Following() {
    const int axis = Axis();
    Effect effect = Of(EffectKind::kFollowing, axis, Own(axis));
    effect.delay_s = random_.Uniform(0.01, 0.08);
    effect.is_of_speed = random_.Chance(0.7);
    return effect;
  }
  Fault Clock() {
    Fault clock;
    clock.kind = FaultKind::kClock;
    clock.delay_s = (random_.Chance(0.5) ? -1.0 : 1.0) * random_.Uniform(0.002, 0.02);
    return clock;
  }
  Fault AnyFault() {
    const FaultKind kinds[] = {FaultKind::kGain,   FaultKind::kScale,  FaultKind::kBall, FaultKind::kLobes,
                               FaultKind::kGrowth, FaultKind::kMotion, FaultKind::kClock};
    Fault fault = Clock();
    fault.kind = kinds[random_.Below(7)];
    fault.gain = random_.Uniform(0.005, 0.05);
    fault.crosstalk = random_.Uniform(0.0, 0.03);
    fault.scale = random_.Uniform(-30e-6, 30e-6);
    fault.scale_per_kelvin = random_.Uniform(2e-6, 12e-6);
    fault.rms_mm = UpTo(0.5e-3, 3e-3);
    fault.order = 2 + random_.Below(5);
    fault.carrier = fault.kind == FaultKind::kMotion && random_.Chance(0.5) ? Carrier::kTable : Carrier::kTool;
    fault.tau_s = random_.Uniform(60.0, 600.0);
    return fault;
  }
  NominalFault Nominal() {
    NominalFault fault;
    switch (random_.Below(3)) {
      case 0:
        fault.axis = Rotary();
        return fault;
      case 1:
        fault.kind = NominalKind::kPivot;
        fault.axis = Rotary();
        fault.offset_mm = random_.Uniform(0.3, 2.0) * Eigen::Vector3d::Unit(random_.Below(3));
        return fault;
      default:
        fault.kind = NominalKind::kToolLength;
        fault.offset_mm = random_.Uniform(0.3, 2.0) * machine_.tool_direction;
        return fault;
    }
  }

  const machine::Machine& machine_;
  base::Random& random_;
  std::vector<int> linear_, rotary_;
};

std::vector<bool> Moving(const machine::Machine& machine, const std::vector<session::Session>& sessions) {
  std::vector<bool> moves(machine.axis_count(), false);
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    const bool is_rotary = machine.axes[axis].kind == AxisKind::kRotary;
    for (const session::Session& session : sessions) {
      const session::Column* column =
          session::FindColumn(session, machine.axes[axis].name + (is_rotary ? "_deg" : "_mm"));
      for (const double q : column->values) moves[axis] = moves[axis] || q != column->values[0];
    }
  }
  return moves;
}

void MakeDirty(base::Random* random, Scenario* scenario) {
  scenario->noise.sigma_scale = std::exp(random->Uniform(-0.5, 0.5));
  scenario->noise.ar1 = random->Uniform(0.0, 0.7);
  scenario->noise.white_share = 0.3;
  scenario->noise.student_degrees = random->Chance(0.5) ? 5 : 0;
  scenario->noise.resolution_mm = 1e-4;
  scenario->bad_share = random->Chance(0.5) ? 0.01 : 0.0;
  scenario->sampling.kept_share = random->Uniform(0.5, 1.0);
  scenario->sampling.lost_share = random->Uniform(0.0, 0.1);
  scenario->sampling.time_jitter = random->Uniform(0.0, 0.4);
  scenario->sampling.slower = random->Uniform(0.7, 1.5);
}

}  // namespace

const char* const* PhysicsWords() {
  static const char* const kWords[] = {"nothing",    "curves",    "ripple",     "gravity", "crossed", "heat",
                                       "hysteresis", "following", "instrument", "nominal", "mixed",   nullptr};
  return kWords;
}

PhysicsCase DrawPhysics(Physics kind, uint64_t seed, synthetic::Form form) {
  // An effect that a plan cannot show (a joint whose load never changes) is refused; another one is drawn.
  for (uint64_t attempt = 0;; ++attempt) {
    base::Random random(base::StreamSeed(base::StreamSeed(seed, static_cast<uint64_t>(kind)), attempt));
    const char* const plans[] = {"case-003", "case-012", "case-001", "case-013", "case-002", "case-014"};
    const session::Case plan =
        session::ReadCase(base::SourcePath("/tests/data/loop/") + plans[random.Below(std::size(plans))]).value();
    Scenario scenario;
    scenario.text = "{}";
    scenario.errors = machine::DeclaredModel(plan.machine);
    for (machine::ErrorTerm& term : scenario.errors.terms)
      term.amplitude[0] = random.Normal() * (machine::IsAngle(term.component) ? 70e-6 : 30e-3);
    MakeDirty(&random, &scenario);
    Author(plan.machine, Moving(plan.machine, plan.fit), &random).Write(kind, &scenario);
    auto simulated = synthetic::RunScenario(plan.machine, scenario, {plan.fit, plan.check}, form, seed);
    if (!simulated.ok()) continue;
    Scenario sound = scenario;
    sound.effects.clear();
    sound.faults.clear();
    sound.nominal.clear();
    PhysicsCase out;
    out.scenario = scenario;
    out.machine = simulated->described;
    out.fit = identify::BindSessions(out.machine, simulated->measured.fit).value();
    if (!simulated->measured.check.empty())
      out.check = identify::BindSessions(out.machine, simulated->measured.check).value();
    for (const Effect& effect : scenario.effects) out.put_in.push_back(synthetic::NameOf(plan.machine, effect));
    for (const Fault& fault : scenario.faults)
      out.put_in.emplace_back(synthetic::FaultWords()[static_cast<int>(fault.kind)]);
    for (const NominalFault& fault : scenario.nominal)
      out.put_in.emplace_back(synthetic::NominalWords()[static_cast<int>(fault.kind)]);
    constexpr int kPoses = 100 * synthetic::kPosesPerWay;
    out.poses = synthetic::BoxPoses(*simulated, kPoses, seed);
    out.sound = synthetic::RunScenario(plan.machine, sound, {plan.fit, plan.check}, form, seed).value();
    out.simulated = *std::move(simulated);
    return out;
  }
}

namespace {

double LeftOverBox(const synthetic::Truth& truth, const machine::Machine& described, const PhysicsCase& physics,
                   const machine::ErrorModel& model) {
  synthetic::Truth predicted;  // the machine as described, with the model's errors
  predicted.machine = described;
  predicted.errors = model;
  const auto actual = synthetic::ErrorsAlong(truth, truth.tip_mm, physics.poses);
  const auto expected = synthetic::ErrorsAlong(predicted, truth.tip_mm, physics.poses);
  // At the corners of the ways speeds jump: what a servo does there a difference of positions does not say.
  std::vector<int> at;
  for (int k = 0; k < static_cast<int>(actual.size()); ++k) {
    const int on_way = k % synthetic::kPosesPerWay;
    if (on_way >= 2 && on_way + 1 < synthetic::kPosesPerWay) at.push_back(k);
  }
  const auto poses = static_cast<Eigen::Index>(at.size());
  Eigen::VectorXd left(3 * poses);
  Eigen::MatrixXd free(3 * poses, 6);  // a shift in the table's frame, and one of the tool's centre
  for (Eigen::Index row = 0; row < poses; ++row) {
    const int k = at[row];
    const auto nominal = [&](const machine::Machine& machine) {
      return machine::EvaluateChain<double>(machine, physics.poses.PositionsOf(k), machine::JointErrors<double>());
    };
    const machine::ChainPose<double> pose = nominal(truth.machine);
    left.segment<3>(3 * row) = machine::TipInTable(pose, truth.tip_mm) + actual[k].shift_mm -
                               machine::TipInTable(nominal(described), truth.tip_mm) - expected[k].shift_mm;
    free.block<3, 3>(3 * row, 0).setIdentity();
    free.block<3, 3>(3 * row, 3) = pose.bed_from_table.rotation.transpose() * pose.bed_from_tool.rotation;
  }
  const Eigen::VectorXd taken = free.colPivHouseholderQr().solve(left);
  return (left - free * taken).norm() / std::sqrt(static_cast<double>(poses));
}

}  // namespace

double ErrorOverBox(const PhysicsCase& physics, const machine::ErrorModel& model) {
  return LeftOverBox(physics.simulated.truth, physics.machine, physics, model);
}

bool IsOfTheForm(const Effect& effect, const machine::ErrorTerm& term) {
  if (term.joint != effect.joint || term.component != effect.component) return false;
  const shapes::Shape& shape = term.shape;
  const auto is_one_of = [&shape]<typename... Some>(std::type_identity<std::tuple<Some...>>) {
    return (std::holds_alternative<Some>(shape) || ...);
  };
  using shapes::Harmonic;
  using Curves = std::tuple<shapes::Curve, shapes::Linear, shapes::Quadratic, Harmonic>;
  using Warm = std::tuple<shapes::Thermal, shapes::ThermalLag, shapes::TimeCurve, shapes::Drift, shapes::DriftExp>;
  using Plays = std::tuple<shapes::Backlash, shapes::Reversal, shapes::BacklashCurve, shapes::Play, shapes::LastMove>;
  const std::optional<int> axis = shapes::VariableAxis(shape);
  switch (effect.kind) {
    case EffectKind::kCurve:
      return is_one_of(std::type_identity<Curves>()) && axis == effect.axis;
    case EffectKind::kTimeCurve:
      return std::holds_alternative<shapes::TimeCurve>(shape);
    case EffectKind::kRipple:
      return std::holds_alternative<Harmonic>(shape) && axis == effect.axis;
    case EffectKind::kGravity:  // whatever these positions make of it
      return true;
    case EffectKind::kCrossed:
      return std::holds_alternative<shapes::Crossed>(shape);
    case EffectKind::kHeat:
      return is_one_of(std::type_identity<Warm>()) && axis.value_or(-1) == effect.axis;
    case EffectKind::kBacklash:
    case EffectKind::kWindUp:
    case EffectKind::kFriction:
    case EffectKind::kLastMove:
      return is_one_of(std::type_identity<Plays>()) && axis == effect.axis;
    case EffectKind::kFollowing:
      // A servo of second order that is late has an acceleration beside the speed.
      return std::holds_alternative<shapes::Acceleration>(shape) ||
             (effect.is_of_speed && std::holds_alternative<shapes::Lag>(shape));
  }
  return false;
}

bool IsOfTheForm(const PhysicsCase& physics, const loop::Candidate& candidate) {
  if (candidate.family == loop::Family::kInstrument) return !physics.scenario.faults.empty();
  return loop::IsTerm(candidate.family) &&
         std::any_of(physics.scenario.effects.begin(), physics.scenario.effects.end(),
                     [&](const Effect& effect) { return IsOfTheForm(effect, candidate.term); });
}

double ErrorOfOneWhoKnows(const PhysicsCase& physics) {
  const auto fit = identify::Identify(physics.sound.described, physics.sound.measured.fit);
  return LeftOverBox(physics.sound.truth, physics.sound.described, physics,
                     fit.ok() ? fit->model : machine::ErrorModel());
}

}  // namespace axiscal::rates
