#include "core/nc/tool_chain.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "core/shapes/shape.h"

namespace axiscal::nc {
namespace {

// `v` turned about the unit vector `axis` (Rodrigues), which is coordinate axis `along`, or -1.
inline void Turn(const Eigen::Vector3d& axis, int along, double sine, double cosine, Eigen::Vector3d* v) {
  if (along < 0) {
    *v = cosine * *v + sine * axis.cross(*v) + ((1.0 - cosine) * axis.dot(*v)) * axis;
    return;
  }
  const int first = along == 2 ? 0 : along + 1, second = along == 0 ? 2 : along - 1;
  const double signed_sine = sine * axis[along], u = (*v)[first], w = (*v)[second];
  (*v)[first] = cosine * u - signed_sine * w;
  (*v)[second] = cosine * w + signed_sine * u;
}

}  // namespace

ToolChain::ToolChain(const machine::Machine& machine, const machine::ErrorModel& errors, double time_s,
                     double temperature_celsius)
    : machine_(machine), time_s_(time_s), temperature_celsius_(temperature_celsius) {
  const shapes::State nowhere;
  for (const machine::ErrorTerm& term : errors.terms) {
    if (std::holds_alternative<shapes::Constant>(term.shape)) {
      machine::AddErrors(term, nowhere, &constant_);
    } else {
      varying_.terms.push_back(term);
    }
  }
  tool_legs_ = MakeLegs(machine.tool_branch, machine.tool_joint());
  work_legs_ = MakeLegs(machine.work_branch, machine.work_joint());
}

std::vector<ToolChain::Leg> ToolChain::MakeLegs(const std::vector<int>& axes, int end_joint) const {
  std::vector<Leg> legs(1);
  const auto end_leg = [&legs] {
    Leg& leg = legs.back();
    leg.is_turned = !leg.rotation.isIdentity(0.0);
    legs.emplace_back();
  };
  const auto append_error = [&](int joint) {
    const bool is_varying = std::any_of(varying_.terms.begin(), varying_.terms.end(),
                                        [joint](const machine::ErrorTerm& term) { return term.joint == joint; });
    if (is_varying) {
      legs.back().varying_joint = joint;
      end_leg();
      return;
    }
    const auto error = machine::ErrorTransform<double>(constant_[joint], machine::ErrorPoint(machine_, joint));
    Leg& leg = legs.back();
    leg.at_mm += leg.rotation * error.translation_mm;
    leg.rotation = Eigen::Matrix3d(leg.rotation * error.rotation);
  };
  for (const int axis : axes) {
    append_error(axis);
    const machine::Axis& moved = machine_.axes[axis];
    Leg& leg = legs.back();
    if (moved.kind == machine::AxisKind::kLinear) {
      leg.ways.push_back({axis, leg.rotation * moved.direction});
      continue;
    }
    leg.at_mm += leg.rotation * moved.point_mm;
    leg.rotary = axis;
    leg.direction = moved.direction;
    for (int k = 0; k < 3; ++k) {
      if (std::abs(moved.direction[k]) == 1.0) leg.along = k;
    }
    end_leg();
    legs.back().at_mm = -moved.point_mm;
  }
  append_error(end_joint);
  end_leg();
  legs.pop_back();
  return legs;
}

AxesAt ToolChain::Prepare(const machine::Machine& machine, const std::array<double, machine::kMaxAxes>& positions,
                          const AxesAt* like) {
  AxesAt axes;
  axes.position = positions;
  for (size_t i = 0; i < static_cast<size_t>(machine.axis_count()); ++i) {
    if (machine.axes[i].kind != machine::AxisKind::kRotary) continue;
    if (like != nullptr && like->position[i] == positions[i]) {
      axes.sine[i] = like->sine[i], axes.cosine[i] = like->cosine[i];
    } else {
      axes.sine[i] = std::sin(positions[i]), axes.cosine[i] = std::cos(positions[i]);
    }
  }
  return axes;
}

machine::JointErrors<double> ToolChain::VaryingAt(const AxesAt& axes, const AxisSenses& senses) const {
  std::array<shapes::AxisState, machine::kMaxAxes> states;
  for (size_t i = 0; i < static_cast<size_t>(machine_.axis_count()); ++i) {
    states[i].position = axes.position[i];
    states[i].sense = senses[i];
  }
  shapes::State state;
  state.axes = {states.data(), static_cast<size_t>(machine_.axis_count())};
  state.time_s = time_s_;
  state.temperature_celsius = temperature_celsius_;
  machine::JointErrors<double> errors = constant_;
  for (const machine::ErrorTerm& term : varying_.terms) machine::AddErrors(term, state, &errors);
  return errors;
}

ToolPose ToolChain::At(const AxesAt& axes, const AxisSenses& senses, const Eigen::Vector3d& tip_mm) const {
  const bool is_varying = !varying_.terms.empty();
  const machine::JointErrors<double>& varying = is_varying ? VaryingAt(axes, senses) : constant_;
  const auto origin = [&axes](const Leg& leg) {
    Eigen::Vector3d at_mm = leg.at_mm;
    for (const Way& way : leg.ways) at_mm += axes.position[static_cast<size_t>(way.axis)] * way.by_position;
    return at_mm;
  };
  const auto error_of = [&](const Leg& leg) {
    return machine::ErrorTransform<double>(varying[leg.varying_joint],
                                           machine::ErrorPoint(machine_, leg.varying_joint));
  };
  Eigen::Vector3d tip = tip_mm, direction = machine_.tool_direction;
  for (size_t k = tool_legs_.size(); k-- > 0;) {
    const Leg& leg = tool_legs_[k];
    if (leg.rotary >= 0) {
      const auto axis = static_cast<size_t>(leg.rotary);
      Turn(leg.direction, leg.along, axes.sine[axis], axes.cosine[axis], &tip);
      Turn(leg.direction, leg.along, axes.sine[axis], axes.cosine[axis], &direction);
    } else if (leg.varying_joint >= 0) {
      const auto error = error_of(leg);
      tip = error * tip;
      direction = error.rotation * direction;
    }
    if (leg.is_turned) {
      tip = leg.rotation * tip;
      direction = leg.rotation * direction;
    }
    tip += origin(leg);
  }
  for (const Leg& leg : work_legs_) {
    tip -= origin(leg);
    if (leg.is_turned) {
      tip = leg.rotation.transpose() * tip;
      direction = leg.rotation.transpose() * direction;
    }
    if (leg.rotary >= 0) {
      const auto axis = static_cast<size_t>(leg.rotary);
      Turn(leg.direction, leg.along, -axes.sine[axis], axes.cosine[axis], &tip);
      Turn(leg.direction, leg.along, -axes.sine[axis], axes.cosine[axis], &direction);
    } else if (leg.varying_joint >= 0) {
      const auto error = error_of(leg);
      tip = error.rotation.transpose() * (tip - error.translation_mm);
      direction = error.rotation.transpose() * direction;
    }
  }
  return {tip, direction};
}

}  // namespace axiscal::nc
