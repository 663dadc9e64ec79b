#include "core/compensate/carried.h"

#include <cmath>
#include <utility>

#include "core/shapes/depends_on.h"

namespace axiscal::compensate {
namespace {

using machine::ErrorTerm;
using machine::Machine;

bool IsZero(const ErrorTerm& term) {
  for (int i = 0; i < shapes::BasisCount(term.shape); ++i) {
    if (term.amplitude[i] != 0.0) return false;
  }
  return true;
}

// Why a term cannot be carried by a program, or "".
std::string WhyNotCarried(const ErrorTerm& term, const Options& options) {
  const std::string shape = shapes::Name(term.shape);
  if (shape == "drift" || shape == "drift-exp") return options.time_s ? "" : "no time is stated";
  if (shape == "thermal") return options.temperature_celsius ? "" : "no temperature is stated";
  if (shape == "time-curve") return "it is known for the time of its readings only";
  if (const auto* lag = std::get_if<shapes::ThermalLag>(&term.shape)) {
    // The temperature that is stated counts as one that has lasted.
    if (lag->channel != shapes::kTemperatureChannel) return "no temperature " + lag->channel + " can be stated";
    return options.temperature_celsius ? "" : "no temperature is stated";
  }
  if (shape == "reversal") return "it decays along a move, a program's end points cannot follow it";
  if (shape == "lag") return "it follows the speed, which a program does not fix";
  if (shape == "acceleration") return "it follows the acceleration, which a program does not fix";
  return "";
}

absl::Status ValidateTerm(const Machine& machine, const ErrorTerm& term) {
  if (term.joint < 0 || term.joint >= machine.joint_count()) {
    return absl::InvalidArgumentError(
        absl::StrCat("error term of joint ", term.joint, ", the machine has ", machine.joint_count()));
  }
  for (const std::optional<int>& variable : {shapes::VariableAxis(term.shape), shapes::SecondAxis(term.shape)}) {
    if (variable && (*variable < 0 || *variable >= machine.axis_count())) {
      return absl::InvalidArgumentError(
          absl::StrCat("error term over axis ", *variable, ", the machine has ", machine.axis_count()));
    }
  }
  for (int i = 0; i < shapes::BasisCount(term.shape); ++i) {
    if (!std::isfinite(term.amplitude[i])) {
      return absl::InvalidArgumentError(
          absl::StrCat(machine::NameOf(machine, term), " = ", term.amplitude[i], ", must be finite"));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status SelectCarried(const Machine& machine, const machine::ErrorModel& errors, const Options& options,
                           machine::ErrorModel* carried, std::vector<std::string>* not_carried) {
  for (const auto& [name, stated] :
       {std::pair("time_s", options.time_s), std::pair("temperature_celsius", options.temperature_celsius)}) {
    if (stated && !std::isfinite(*stated))
      return absl::InvalidArgumentError(absl::StrCat(name, " = ", *stated, ", must be finite"));
  }
  for (const ErrorTerm& term : errors.terms) {
    RETURN_IF_ERROR(ValidateTerm(machine, term));
    if (IsZero(term)) continue;
    const std::string reason = WhyNotCarried(term, options);
    if (reason.empty()) {
      if (const double value = AsStated(term, options).amplitude[0]; !std::isfinite(value))
        return absl::InvalidArgumentError(absl::StrCat(machine::NameOf(machine, term), " is ", value, " at time_s = ",
                                                       options.time_s.value_or(0.0), ", must be finite"));
      carried->terms.push_back(term);
    } else {
      not_carried->push_back(machine::NameOf(machine, term) + ": " + reason);
    }
  }
  return absl::OkStatus();
}

ErrorTerm AsStated(const ErrorTerm& term, const Options& options) {
  if (!shapes::DependsOnTime(term.shape) && !shapes::ChannelOf(term.shape)) return term;
  shapes::Shape shape = term.shape;
  shapes::Times times;
  if (shapes::Times* its = shapes::TimesOf(shape)) times = std::exchange(*its, {});
  shapes::State state;
  if (options.time_s) state.time_s = *options.time_s;
  if (options.temperature_celsius) state.temperature_celsius = *options.temperature_celsius;
  double basis[shapes::kMaxBasisCount];
  shapes::Basis(shape, state, basis);
  double value = 0.0;
  for (int i = 0; i < shapes::BasisCount(shape); ++i) value += term.amplitude[i] * basis[i];
  ErrorTerm stated{term.joint, term.component, shapes::Constant{}, {value}};
  if (times.axis >= 0) stated.shape = shapes::Linear{times.axis, times.reference};
  return stated;
}

}  // namespace axiscal::compensate
