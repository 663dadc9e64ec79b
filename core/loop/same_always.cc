#include "core/loop/same_always.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <set>
#include <string>

#include "core/identify/problem.h"
#include "core/instruments/rtest/rtest_model.h"
#include "core/loop/candidate.h"
#include "core/loop/separation.h"

namespace axiscal::loop {
namespace {

// An R-test that no machine could run: every axis anywhere, moving either way at any speed, at any time and any
// temperature of each of `channels`, the nest anywhere, tools of any length. Its three readings are the tool point in
// the table's frame.
instruments::MeasuringRun AnyState(const machine::Machine& machine, const Eigen::Vector3d& tip_mm,
                                   const std::set<std::string>& channels, int number, std::mt19937_64* random) {
  const auto uniform = [random](double low, double high) {
    return low + (high - low) * (static_cast<double>((*random)() >> 11) * 0x1p-53);
  };
  instruments::MeasuringRun run;
  run.session = run.setup_name = absl::StrCat("any-", number);
  run.kind = instruments::Kind::kRtest;
  run.setup = rtest::SetupParameters();
  for (instruments::SetupParameter& offset : run.setup) offset.prior_sigma = INFINITY;
  run.sigma_mm = 1e-3;
  constexpr double kPlaceMm = 300.0;
  run.tip_mm = tip_mm + uniform(-0.5 * kPlaceMm, kPlaceMm) * machine.tool_direction;
  for (int k = 0; k < 3; ++k) run.ball_mm[k] = uniform(-kPlaceMm, kPlaceMm);
  run.axis_count = machine.axis_count();
  run.row_count = 3;
  run.has_time = run.has_temperature = true;
  constexpr int kReadings = 24;
  for (int k = 0; k < kReadings; ++k) {
    for (const machine::Axis& axis : machine.axes) {
      const double reach = axis.kind == machine::AxisKind::kRotary ? M_PI : kPlaceMm;
      shapes::AxisState state;
      state.position = uniform(-reach, reach);
      state.sense = uniform(-1.0, 1.0) < 0.0 ? -1.0 : 1.0;
      state.travel_since_reversal = uniform(0.0, 0.1 * reach);
      state.speed = state.sense * uniform(0.0, 0.1 * reach);
      state.acceleration = uniform(-0.1 * reach, 0.1 * reach);
      state.last_move = state.sense * uniform(0.0, 0.1 * reach);
      state.turned_at[0] = state.position - state.sense * state.travel_since_reversal;
      run.positions.push_back(state.position);
      run.axis_states.Own().push_back(state);
    }
    run.time_s.push_back(uniform(0.0, 2e4));
    run.temperature_celsius.push_back(uniform(10.0, 30.0));
  }
  // What remembers temperatures needs a past: moments in their order, and all channels by themselves.
  std::sort(run.time_s.begin(), run.time_s.end());
  std::vector<shapes::Temperatures::Channel> history;
  for (const std::string& name : channels) {
    history.push_back({name, run.temperature_celsius});
    if (name == shapes::kTemperatureChannel) continue;
    for (double& celsius : history.back().celsius) celsius = uniform(10.0, 30.0);
  }
  run.history = std::make_shared<const shapes::Temperatures>(run.time_s, std::move(history));
  run.measured_mm = Eigen::MatrixXd::Zero(3, kReadings);
  return run;
}

}  // namespace

std::vector<int> FirstOfTheSame(const machine::Machine& machine, const Eigen::Vector3d& tip_mm,
                                const std::vector<machine::ErrorTerm>& terms) {
  std::mt19937_64 random(1);
  std::set<std::string> channels;
  for (const machine::ErrorTerm& term : terms)
    if (const auto* lag = std::get_if<shapes::ThermalLag>(&term.shape)) channels.insert(lag->channel);
  std::vector<instruments::MeasuringRun> runs;
  for (int i = 0; i < 3; ++i) runs.push_back(AnyState(machine, tip_mm, channels, i, &random));
  const absl::StatusOr<identify::Problem> problem = identify::MakeProblem(machine, std::move(runs));
  machine::ErrorModel model;
  std::vector<Member> members;
  std::vector<size_t> asked;  // whose members they are: a free curve is nothing else by another name
  int column = 0;
  constexpr double kTauS = 3600.0, kLength = 1.0;
  for (size_t i = 0; i < terms.size(); ++i) {
    if (shapes::IsFree(terms[i].shape)) continue;
    asked.push_back(i);
    machine::ErrorTerm term = terms[i];
    term.shape = Everywhere(term.shape);
    term.amplitude = {};
    // Another decay length or time constant does not make another effect.
    if (double* parameter = shapes::NonlinearParameter(term.shape))
      *parameter =
          std::holds_alternative<shapes::DriftExp>(term.shape) || std::holds_alternative<shapes::ThermalLag>(term.shape)
              ? kTauS
              : kLength;
    model.terms.push_back(term);
    Member member;
    for (int b = 0; b < shapes::BasisCount(term.shape); ++b) member.columns.push_back(column++);
    members.push_back(std::move(member));
  }
  // Declared errors are fitted along.
  for (const machine::ErrorTerm& declared : machine::DeclaredModel(machine).terms) {
    const auto is_it = [&](const machine::ErrorTerm& term) { return IsSameEffect(term, declared); };
    if (std::none_of(terms.begin(), terms.end(), is_it)) model.terms.push_back(declared);
  }
  std::vector<int> first(terms.size());
  for (size_t i = 0; i < terms.size(); ++i) first[i] = static_cast<int>(i);
  if (!problem.ok() || asked.empty()) return first;
  const Separation separation(
      InformationOf(*problem, identify::StartingPoint(*problem, model), identify::ListParameters(model, false)),
      members);
  constexpr double kSame = 1.0 - 1e-7;
  for (size_t i = 0; i < asked.size(); ++i) {
    int& own = first[asked[i]];
    for (size_t j = 0; j < i && own == static_cast<int>(asked[i]); ++j) {
      if (first[asked[j]] == static_cast<int>(asked[j]) && members[i].columns.size() == members[j].columns.size() &&
          separation.Correlation(static_cast<int>(i), static_cast<int>(j)) > kSame)
        own = static_cast<int>(asked[j]);
    }
  }
  return first;
}

std::vector<machine::ErrorTerm> SameAlways(const machine::Machine& machine, const Eigen::Vector3d& tip_mm,
                                           const machine::ErrorTerm& effect,
                                           const std::vector<machine::ErrorTerm>& others) {
  if (others.empty()) return {};
  std::vector<machine::ErrorTerm> terms = {effect}, same;
  terms.insert(terms.end(), others.begin(), others.end());
  const std::vector<int> first = FirstOfTheSame(machine, tip_mm, terms);
  for (size_t i = 1; i < terms.size(); ++i) {
    if (first[i] == 0) same.push_back(terms[i]);
  }
  return same;
}

}  // namespace axiscal::loop
