#include "core/loop/report.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_join.h"
#include "core/base/units.h"
#include "core/identify/report.h"
#include "core/machine/error_json.h"

namespace axiscal::loop {
namespace {

using base::kDegPerRad;
using base::kUmPerMm;

reports::NamedTerm NamedTerm(const machine::Machine& machine, const machine::ErrorTerm& term) {
  return {machine::Written(term, machine), machine::NameOf(machine, term)};
}

std::vector<std::string> NamesOf(const machine::Machine& machine, const std::vector<machine::ErrorTerm>& terms) {
  std::vector<std::string> names;
  for (const machine::ErrorTerm& term : terms) names.push_back(machine::NameOf(machine, term));
  return names;
}

reports::Effect EffectOf(const machine::Machine& machine, const Effect& found) {
  reports::Effect effect;
  effect.is = NamedTerm(machine, found.term);
  const double factor = machine::AmplitudeFactor(found.term);
  effect.amplitude = found.amplitude / factor;
  effect.amplitude_sigma = found.amplitude_sigma / factor;
  effect.unit = machine::AmplitudeUnit(found.term, machine);
  if (shapes::HasPhase(found.term.shape))
    effect.phase_deg = std::atan2(found.term.amplitude[1], found.term.amplitude[0]) * kDegPerRad;
  effect.alias_orders = found.alias_orders;
  effect.rms_um = found.rms_mm * kUmPerMm;
  effect.evidence = found.evidence;
  for (const machine::ErrorTerm& term : found.equivalent) effect.equivalent.push_back(NamedTerm(machine, term));
  effect.same_always = NamesOf(machine, found.same_always);
  return effect;
}

reports::Statistics StatisticsOf(const identify::FitStatistics& fit) {
  return {.rms_um = fit.rms_mm * kUmPerMm,
          .max_um = fit.max_mm * kUmPerMm,
          .rms_without_outliers_um = fit.rms_without_outliers_mm * kUmPerMm,
          .chi2_per_dof = fit.chi2_per_dof};
}

reports::Slip SlipOf(const Slipped& slipped) {
  reports::Slip slip;
  const bool is_table = slipped.carrier == instruments::Carrier::kTable;
  slip.carrier = is_table ? reports::Carrier::kTable : reports::Carrier::kTool;
  if (slipped.may_be_other) slip.may_be = is_table ? reports::Carrier::kTool : reports::Carrier::kTable;
  for (size_t k = 0; k < 3; ++k) {
    if (!slipped.moved_mm[k]) continue;
    slip.moved_um[k] = *slipped.moved_mm[k] * kUmPerMm;
    slip.sigma_um[k] = slipped.sigma_mm[k] * kUmPerMm;
  }
  return slip;
}

reports::CauseKind KindOf(Cause::Kind kind) {
  switch (kind) {
    case Cause::kInstrument:
      return reports::CauseKind::kInstrument;
    case Cause::kNominal:
      return reports::CauseKind::kNominal;
    case Cause::kNotRepeatable:
      return reports::CauseKind::kNotRepeatable;
  }
  return reports::CauseKind::kInstrument;
}

reports::PartKind KindOf(Unexplained::Kind kind) {
  switch (kind) {
    case Unexplained::kLocal:
      return reports::PartKind::kLocal;
    case Unexplained::kSlip:
      return reports::PartKind::kSlip;
    case Unexplained::kCheckSession:
      return reports::PartKind::kCheckSession;
    case Unexplained::kBadReadings:
      return reports::PartKind::kBadReadings;
    case Unexplained::kScatter:
      return reports::PartKind::kScatter;
  }
  return reports::PartKind::kLocal;
}

reports::Unexplained UnexplainedOf(const machine::Machine& machine, const Unexplained& found) {
  const int axis = machine::FindAxis(machine, found.variable);
  const bool is_rotary = axis >= 0 && machine.axes[axis].kind == machine::AxisKind::kRotary;
  const double unit = is_rotary ? kDegPerRad : 1.0;
  reports::Unexplained part;
  part.kind = KindOf(found.kind);
  part.variable = found.variable;
  part.from = found.from * unit;
  part.to = found.to * unit;
  part.unit = axis < 0 ? "s" : is_rotary ? "deg" : "mm";
  part.session = found.session;
  part.rms_um = found.rms_mm * kUmPerMm;
  if (found.slip.has_value()) part.slip = SlipOf(*found.slip);
  return part;
}

reports::Change ChangeOf(SelectionStep::Change change) {
  switch (change) {
    case SelectionStep::kAdded:
      return reports::Change::kAdded;
    case SelectionStep::kDropped:
      return reports::Change::kDropped;
    case SelectionStep::kReplaced:
      return reports::Change::kReplaced;
    case SelectionStep::kWithdrawn:
      return reports::Change::kWithdrawn;
    case SelectionStep::kRefused:
      return reports::Change::kRefused;
  }
  return reports::Change::kAdded;
}

reports::Proposal ProposalOf(const machine::Machine& machine, const Proposal& found) {
  reports::Proposal proposal;
  proposal.effect = machine::NameOf(machine, found.effect);
  proposal.separates = NamesOf(machine, found.separates);
  if (!found.test.empty()) {
    proposal.test = {.session = *session::FindHeader(found.session, "session"),
                     .test = found.test,
                     .text = found.text,
                     .correlation_before = found.correlation_before,
                     .correlation_after = found.correlation_after,
                     .expected_chi2 = found.expected_chi2,
                     .needs_next = found.needs_next,
                     .beyond = found.beyond};
  }
  proposal.remaining = NamesOf(machine, found.remaining);
  proposal.same_always = NamesOf(machine, found.same_always);
  return proposal;
}

reports::Verdict VerdictOf(Verdict::Kind verdict) {
  switch (verdict) {
    case Verdict::kAdequate:
      return reports::Verdict::kAdequate;
    case Verdict::kExtended:
      return reports::Verdict::kExtended;
    case Verdict::kUnexplained:
      return reports::Verdict::kUnexplained;
  }
  return reports::Verdict::kUnexplained;
}

reports::Fitted FittedOf(const Report& found) {
  reports::Fitted fitted = identify::FittedOf(found.fitted);
  // Of the readings, of sizes that no machine has and of work offsets that were set anew; what else an identification
  // warns of, the loop judges itself.
  std::erase_if(fitted.warnings, [](const reports::Warning& warning) {
    return warning.kind != reports::WarningKind::kResolution && warning.kind != reports::WarningKind::kDatum &&
           warning.kind != reports::WarningKind::kCertificate && warning.kind != reports::WarningKind::kClock &&
           warning.kind != reports::WarningKind::kMoved && !reports::ComesFirst(warning.kind);
  });
  fitted.budget_json = found.budget_json;
  fitted.measured = found.measured;
  if (found.monte_carlo) fitted.monte_carlo = identify::ReportOf(*found.monte_carlo);
  return fitted;
}

// Undecided too where the readings do not tell it from others that were fitted in its place, whatever it was held back
// for.
reports::HeldBack HeldBackOf(const machine::Machine& machine, const Report& found, const HeldBack& held) {
  reports::HeldBack out{.subject = machine::NameOf(machine, held.term), .evidence = held.evidence, .harm = held.harm};
  const bool is_undecided = std::any_of(found.choices.begin(), found.choices.end(),
                                        [&](const predict::OpenChoice& choice) { return choice.name == out.subject; });
  constexpr reports::HeldBackKind kKinds[] = {reports::HeldBackKind::kUncertain, reports::HeldBackKind::kUndecided,
                                              reports::HeldBackKind::kHidden,
                                              reports::HeldBackKind::kNoGain};  // in the order of HeldBack::Why
  out.kind = is_undecided ? reports::HeldBackKind::kUndecided : kKinds[held.why];
  std::vector<std::string> tests;
  for (const Proposal& proposal : found.next_measurement)
    if (!proposal.test.empty() && IsSameEffect(proposal.effect, held.term)) tests.push_back(proposal.text);
  if (is_undecided && !tests.empty()) {
    out.measure = absl::StrCat("measure ", absl::StrJoin(tests, ", then "));
  } else if (held.why == HeldBack::kUndecided) {
    out.measure =
        absl::StrCat("it could be what an acceleration of ", machine.axes[*shapes::VariableAxis(held.term.shape)].name,
                     " leaves: read more often where that axis sets off, stops and turns");
  } else {
    out.measure = "measure more poses, spread over the whole box";
    if (const std::optional<int> axis = shapes::VariableAxis(held.term.shape))
      absl::StrAppend(&out.measure, " and evenly along ", machine.axes[*axis].name);
  }
  return out;
}

reports::VolumetricFigure FigureOf(const predict::RootMeanSquare& figure) {
  return {figure.expected_mm * kUmPerMm, figure.low_mm * kUmPerMm, figure.high_mm * kUmPerMm};
}

reports::Volumetric VolumetricOf(const machine::Machine& machine, const predict::VolumetricError& error) {
  reports::Volumetric out;
  for (int i = 0; i < machine.axis_count(); ++i) {
    const bool is_rotary = machine.axes[i].kind == machine::AxisKind::kRotary;
    const double unit = is_rotary ? kDegPerRad : 1.0;
    if (error.box.low[i] == error.box.high[i]) continue;
    out.box.push_back(
        {machine.axes[i].name, error.box.low[i] * unit, error.box.high[i] * unit, is_rotary ? "deg" : "mm"});
  }
  out.poses = error.poses;
  out.uncorrected = FigureOf(error.uncorrected);
  out.before = FigureOf(error.before);
  out.after = FigureOf(error.after);
  out.gain_is_held = error.is_gain_held;
  out.weakest = error.weakest;
  out.undecided = error.undecided;
  out.unknown = error.unknown;
  return out;
}

}  // namespace

reports::Loop ReportOf(const machine::Machine& machine, const Report& found) {
  reports::Loop report;
  report.verdict = VerdictOf(found.verdict);
  for (const Effect& effect : found.effects) report.effects.push_back(EffectOf(machine, effect));
  for (const Cause& cause : found.causes)
    report.causes.push_back({KindOf(cause.kind), cause.subject, cause.evidence, cause.correction, cause.subject_german,
                             cause.correction_german});
  for (const HeldBack& held : found.held_back) report.held_back.push_back(HeldBackOf(machine, found, held));
  report.fitted = FittedOf(found);
  report.fit = {StatisticsOf(found.fit_before), StatisticsOf(found.fit_after)};
  if (found.has_check) {
    report.check = {.before = StatisticsOf(found.check_before),
                    .after = StatisticsOf(found.check_after),
                    .fitted = found.is_check_fitted};
  }
  if (found.volumetric) report.volumetric = VolumetricOf(machine, *found.volumetric);
  for (const SelectionStep& step : found.steps)
    report.steps.push_back({ChangeOf(step.change), step.name, step.rms_mm * kUmPerMm});
  for (const Unexplained& part : found.unexplained) report.unexplained.push_back(UnexplainedOf(machine, part));
  for (const Proposal& proposal : found.next_measurement)
    report.next_measurement.push_back(ProposalOf(machine, proposal));
  for (const SessionNoise& one : found.noise) {
    report.noise.push_back({one.session, one.stated_mm * kUmPerMm, one.sigma_mm * kUmPerMm, one.neighbour_correlation});
  }
  report.withdrawn = found.withdrawn;
  for (const machine::ErrorTerm& term : found.not_visible) report.not_visible.push_back(NamedTerm(machine, term));
  report.axes_at_rest = found.axes_at_rest;
  report.stopped_early = found.has_stopped_early;
  report.candidates = found.candidates;
  return report;
}

}  // namespace axiscal::loop
