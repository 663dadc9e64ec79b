#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/units.h"
#include "core/loop/report.h"
#include "core/machine/error_json.h"

namespace axiscal::loop {
namespace {

using base::kDegPerRad;
using base::kUmPerMm;
using json = nlohmann::ordered_json;

// As in errors.json, with the name that texts call it by: "EBB:harmonic(45)".
json NamedTerm(const machine::Machine& machine, const machine::ErrorTerm& term) {
  json object = machine::TermToJson(term, machine);
  object["name"] = machine::NameOf(machine, term);
  return object;
}

json EffectJson(const machine::Machine& machine, const Effect& effect) {
  json object = NamedTerm(machine, effect.term);
  const double factor = machine::AmplitudeFactor(effect.term);
  object["amplitude"] = effect.amplitude / factor;
  object["amplitude_sigma"] = effect.amplitude_sigma / factor;
  object["unit"] = machine::AmplitudeUnit(effect.term, machine);
  if (shapes::BasisCount(effect.term.shape) == 2) {
    object["phase_deg"] = std::atan2(effect.term.amplitude[1], effect.term.amplitude[0]) * kDegPerRad;
  }
  if (!effect.alias_orders.empty()) object["alias_orders"] = effect.alias_orders;
  object["rms_um"] = effect.rms_mm * kUmPerMm;
  object["evidence"] = effect.evidence;
  json equivalent = json::array();
  for (const machine::ErrorTerm& term : effect.equivalent) equivalent.push_back(NamedTerm(machine, term));
  object["equivalent"] = std::move(equivalent);
  json same_always = json::array();
  for (const machine::ErrorTerm& term : effect.same_always) same_always.push_back(machine::NameOf(machine, term));
  object["same_always"] = std::move(same_always);
  return object;
}

json StatisticsJson(const identify::FitStatistics& fit) {
  return {{"rms_um", fit.rms_mm * kUmPerMm},
          {"max_um", fit.max_mm * kUmPerMm},
          {"rms_without_outliers_um", fit.rms_without_outliers_mm * kUmPerMm},
          {"chi2_per_dof", fit.chi2_per_dof}};
}

json SlipJson(const Slipped& slip) {
  const bool is_table = slip.carrier == instruments::Carrier::kTable;
  json object = {{"carrier", is_table ? "table" : "tool"}};
  if (slip.may_be_other) object["may_be"] = is_table ? "tool" : "table";
  json moved = json::array(), sigma = json::array();
  for (size_t k = 0; k < 3; ++k) {
    moved.push_back(slip.moved_mm[k] ? json(*slip.moved_mm[k] * kUmPerMm) : json());
    sigma.push_back(slip.moved_mm[k] ? json(slip.sigma_mm[k] * kUmPerMm) : json());
  }
  object["moved_um"] = std::move(moved);
  object["sigma_um"] = std::move(sigma);
  return object;
}

json UnexplainedJson(const machine::Machine& machine, const Unexplained& part) {
  const int axis = machine::FindAxis(machine, part.variable);
  const bool is_rotary = axis >= 0 && machine.axes[axis].kind == machine::AxisKind::kRotary;
  const double unit = is_rotary ? kDegPerRad : 1.0;
  constexpr const char* kKinds[] = {"local", "slip", "check-session", "bad-readings", "scatter"};
  json object = {{"kind", kKinds[part.kind]},
                 {"variable", part.variable},
                 {"from", part.from * unit},
                 {"to", part.to * unit},
                 {"unit", axis < 0    ? "s"
                          : is_rotary ? "deg"
                                      : "mm"},
                 {"session", part.session},
                 {"rms_um", part.rms_mm * kUmPerMm}};
  if (part.slip.has_value()) object["slip"] = SlipJson(*part.slip);
  return object;
}

json StepJson(const Step& step) {
  constexpr const char* kChanges[] = {"added", "dropped", "replaced", "withdrawn", "refused"};
  return {{"change", kChanges[step.change]}, {"name", step.name}, {"rms_um", step.rms_mm * kUmPerMm}};
}

json ProposalJson(const machine::Machine& machine, const Proposal& proposal) {
  const auto names = [&machine](const std::vector<machine::ErrorTerm>& terms) {
    json list = json::array();
    for (const machine::ErrorTerm& term : terms) list.push_back(machine::NameOf(machine, term));
    return list;
  };
  json object = {{"effect", machine::NameOf(machine, proposal.effect)}, {"separates", names(proposal.separates)}};
  if (proposal.test.empty()) {
    object["session"] = nullptr;
  } else {
    object["session"] = *session::FindHeader(proposal.session, "session");
    object["test"] = proposal.test;
    object["text"] = proposal.text;
    object["correlation_before"] = proposal.correlation_before;
    object["correlation_after"] = proposal.correlation_after;
    object["expected_chi2"] = proposal.expected_chi2;
    if (proposal.needs_next) object["needs_next"] = true;
    if (!proposal.beyond.empty()) object["beyond"] = proposal.beyond;
  }
  object["remaining"] = names(proposal.remaining);
  object["same_always"] = names(proposal.same_always);
  return object;
}

const char* VerdictText(Verdict::Kind verdict) {
  switch (verdict) {
    case Verdict::kAdequate:
      return "adequate";
    case Verdict::kExtended:
      return "extended";
    case Verdict::kUnexplained:
      return "unexplained";
  }
  return "";
}

}  // namespace

std::string ToJson(const machine::Machine& machine, const Report& report) {
  json root;
  root["verdict"] = VerdictText(report.verdict);
  json effects = json::array();
  for (const Effect& effect : report.effects) effects.push_back(EffectJson(machine, effect));
  root["effects"] = std::move(effects);
  const json fitted = json::parse(identify::ToJson(report.fitted));
  root["errors"] = fitted["errors"];
  root["coverage_factor"] = fitted["coverage_factor"];
  root["not_separable"] = fitted["not_separable"];
  root["determined"] = fitted["determined"];
  json warnings = json::array();  // of the readings; what else an identification warns of, the loop judges itself
  for (const json& warning : fitted["warnings"])
    if (warning["kind"] == "resolution") warnings.push_back(warning);
  root["warnings"] = std::move(warnings);
  root["fit"] = {{"before", StatisticsJson(report.fit_before)}, {"after", StatisticsJson(report.fit_after)}};
  if (report.has_check)
    root["check"] = {{"before", StatisticsJson(report.check_before)},
                     {"after", StatisticsJson(report.check_after)},
                     {"fitted", report.is_check_fitted}};
  json steps = json::array();
  for (const Step& step : report.steps) steps.push_back(StepJson(step));
  root["steps"] = std::move(steps);
  json unexplained = json::array();
  for (const Unexplained& part : report.unexplained) unexplained.push_back(UnexplainedJson(machine, part));
  root["unexplained"] = std::move(unexplained);
  root["outliers"] = fitted["outliers"];
  json next = json::array();
  for (const Proposal& proposal : report.next_measurement) next.push_back(ProposalJson(machine, proposal));
  root["next_measurement"] = std::move(next);
  json noise = json::array();
  for (const SessionNoise& one : report.noise) {
    noise.push_back({{"session", one.session},
                     {"stated_sigma_um", one.stated_mm * kUmPerMm},
                     {"sigma_um", one.sigma_mm * kUmPerMm},
                     {"neighbour_correlation", one.neighbour_correlation}});
  }
  root["noise"] = std::move(noise);
  root["withdrawn"] = report.withdrawn;
  json not_visible = json::array();
  for (const machine::ErrorTerm& term : report.not_visible) not_visible.push_back(NamedTerm(machine, term));
  root["not_visible"] = std::move(not_visible);
  root["axes_at_rest"] = report.axes_at_rest;
  root["stopped_early"] = report.has_stopped_early;
  root["sessions"] = fitted["sessions"];
  root["candidates"] = report.candidates;
  if (!report.budget_json.empty()) root["budget"] = json::parse(report.budget_json);
  if (report.monte_carlo) root["monte_carlo"] = identify::ToJson(*report.monte_carlo);
  return root.dump(1) + "\n";
}

}  // namespace axiscal::loop
