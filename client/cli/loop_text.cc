#include "client/cli/loop_text.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/match.h"
#include "absl/strings/str_join.h"
#include "client/cli/output.h"

namespace axiscal::cli {
namespace {

// The first names of a list, and how many more.
std::string Names(const std::vector<std::string>& names) {
  constexpr size_t kShown = 5;
  const auto end = names.begin() + static_cast<std::ptrdiff_t>(std::min(kShown, names.size()));
  std::string text = absl::StrJoin(names.begin(), end, ", ");
  if (names.size() > kShown) absl::StrAppend(&text, " and ", names.size() - kShown, " more");
  return text;
}

std::vector<std::string> NamesOf(const std::vector<reports::NamedTerm>& terms) {
  std::vector<std::string> names;
  for (const reports::NamedTerm& term : terms) names.push_back(term.name);
  return names;
}

// What `is` may be instead: of its own name with another time constant or length, which the name does not say.
std::vector<std::string> NamesBeside(const reports::NamedTerm& is, const std::vector<reports::NamedTerm>& terms) {
  std::vector<std::string> names;
  for (const reports::NamedTerm& one : terms) {
    std::string name = one.name;
    if (name == is.name && one.term.tau_s)
      absl::StrAppend(&name, absl::StrFormat(" of time constant %.3g s (here %.3g s)", *one.term.tau_s,
                                             is.term.tau_s.value_or(0.0)));
    else if (name == is.name && one.term.length_mm)
      absl::StrAppend(&name, absl::StrFormat(" of length %.3g mm", *one.term.length_mm));
    names.push_back(std::move(name));
  }
  return names;
}

// Names that a proposal leaves beside its effect.
std::string NamesLeft(const reports::Proposal& proposal) {
  std::vector<std::string> names = proposal.remaining;
  for (std::string& name : names)
    if (name == proposal.effect) name = "the same with another time constant or length";
  return Names(names);
}

// What the amplitude of a shape means where its unit does not say it, and the shape's own length or time.
std::string ReferenceText(const machine::WrittenTerm& term) {
  if (term.shape == "backlash") return " peak to peak";
  if (term.shape == "quadratic") return " at 250 mm or 1 rad from zero";
  if (term.shape == "drift-exp") return absl::StrFormat(" when warm (time constant %.4g s)", term.tau_s.value_or(NAN));
  if (term.shape == "reversal" && term.length_mm)
    return absl::StrFormat(" at the reversal, decaying over %.3g mm", *term.length_mm);
  if (term.shape == "reversal" && term.length_deg)
    return absl::StrFormat(" at the reversal, decaying over %.3g deg", *term.length_deg);
  return "";
}

// "EXX:backlash    -2.92 +- 0.02 um peak to peak, 0.9 um rms in the readings" and what else it could be.
std::string EffectText(const reports::Effect& effect) {
  std::string text =
      absl::StrFormat("  %-24s %10.4g +- %.2g %s%s, %.3g um rms in the readings\n", effect.is.name, effect.amplitude,
                      effect.amplitude_sigma, effect.unit, ReferenceText(effect.is.term), effect.rms_um);
  const std::vector<std::string>& same = effect.same_always;
  std::vector<std::string> others = NamesBeside(effect.is, effect.equivalent);
  std::erase_if(others,
                [&same](const std::string& name) { return std::find(same.begin(), same.end(), name) != same.end(); });
  if (!others.empty()) absl::StrAppend(&text, "      these sessions cannot tell it from ", Names(others), "\n");
  if (!same.empty()) absl::StrAppend(&text, "      the same by another name, in any measurement: ", Names(same), "\n");
  std::vector<std::string> orders;
  const std::string before = effect.is.name.substr(0, effect.is.name.find('(') + 1);
  for (const int order : effect.alias_orders) {
    // Likely ones stand in the class already.
    if (std::find(others.begin(), others.end(), absl::StrCat(before, order, ")")) == others.end())
      orders.push_back(std::to_string(order));
  }
  if (!orders.empty())
    absl::StrAppend(&text, "      at these positions it would read the same with order ", Names(orders), "\n");
  return text;
}

// A session that tells the members of a class apart: what to measure, and what it brings.
std::string ProposalText(const reports::Proposal& proposal) {
  if (!proposal.test) return "  no known test tells " + proposal.effect + " from " + NamesLeft(proposal) + "\n";
  const reports::ProposedTest& test = *proposal.test;
  std::string text = absl::StrFormat("  %s (%s)\n", test.text, test.test);
  if (!test.beyond.empty()) absl::StrAppend(&text, "      moves ", test.beyond, "\n");
  if (test.needs_next) return text + "      together with the next one\n";
  // One alone is told from errors that are no members of its class, but that too little would keep apart from it.
  const std::vector<std::string>& separates = proposal.separates;
  absl::StrAppend(&text, "      ",
                  separates.size() == 1 ? "tells " + Names(separates) + " from errors that come close to it"
                                        : "tells apart " + Names(separates),
                  absl::StrFormat(": correlation %.3f -> %.3f, chi-square %.0f or more\n", test.correlation_before,
                                  test.correlation_after, test.expected_chi2));
  if (!proposal.remaining.empty())
    absl::StrAppend(&text, "      leaves ", proposal.effect, " with ", NamesLeft(proposal), "\n");
  return text;
}

std::string CarriedBy(reports::Carrier carrier) {
  return carrier == reports::Carrier::kTool ? "what the tool holder carries" : "what stands on the table";
}

std::string SlippedText(const reports::Slip& slip) {
  return CarriedBy(slip.carrier) + (slip.may_be ? " (or " + CarriedBy(*slip.may_be) + ")" : "");
}

// ", by x 3.01 +- 0.05 um, z -1.2 +- 0.1 um": directions that the session sees.
std::string MovedText(const reports::Slip& slip) {
  std::vector<std::string> moved;
  for (size_t k = 0; k < 3; ++k) {
    if (std::isfinite(slip.moved_um[k]))
      moved.push_back(absl::StrFormat("%c %.3g +- %.2g um", "xyz"[k], slip.moved_um[k], slip.sigma_um[k]));
  }
  return moved.empty() ? "" : ", by " + absl::StrJoin(moved, ", ");
}

std::string PartText(const reports::Unexplained& part) {
  if (part.kind == reports::PartKind::kCheckSession) {
    return absl::StrFormat("  check session %s: its readings leave %.3g um rms that the model does not explain\n",
                           part.session, part.rms_um);
  }
  if (part.kind == reports::PartKind::kScatter) {
    return absl::StrFormat("  session %s: its readings scatter by %.3g um rms, far more than it states\n", part.session,
                           part.rms_um);
  }
  if (part.variable == "t") {
    return absl::StrFormat("  session %s: %s moved between %.6g s and %.6g s%s\n", part.session,
                           part.slip ? SlippedText(*part.slip) : "the artefact or the setup", part.from, part.to,
                           part.slip ? MovedText(*part.slip) : "");
  }
  if (part.kind == reports::PartKind::kBadReadings) {
    return absl::StrFormat("  %s from %.6g to %.6g %s: bad readings cluster there, %.3g um rms: structure, not chips\n",
                           part.variable, part.from, part.to, part.unit, part.rms_um);
  }
  return absl::StrFormat("  %s from %.6g to %.6g %s: local structure without a name, %.3g um rms\n", part.variable,
                         part.from, part.to, part.unit, part.rms_um);
}

// A tracker that is knocked takes all that it sees with it; its references then tell it from the machine.
std::string KnockText(const reports::Loop& report, const reports::Unexplained& part) {
  if (part.variable != "t" || !part.slip) return "";
  for (const reports::SessionFit& session : report.fitted.sessions) {
    const bool has_references = std::any_of(session.setup.begin(), session.setup.end(), [](const auto& offset) {
      return absl::StartsWith(offset.first, "reference_");
    });
    if (session.in.session == part.session && has_references)
      return absl::StrFormat(
          "      or the tracker was knocked: then \"# knocked_s: %.6g\" in the session's header lets its "
          "references tell it from the machine\n",
          0.5 * (part.from + part.to));
  }
  return "";
}

const char* KindText(reports::CauseKind kind) {
  switch (kind) {
    case reports::CauseKind::kInstrument:
      return "the instrument";
    case reports::CauseKind::kNominal:
      return "nominal data";
    case reports::CauseKind::kNotRepeatable:
      return "not repeatable";
  }
  return "";
}

bool HasNominal(const reports::Loop& report) {
  return std::any_of(report.causes.begin(), report.causes.end(),
                     [](const reports::Cause& cause) { return cause.kind == reports::CauseKind::kNominal; });
}

const char* VerdictText(const reports::Loop& report) {
  switch (report.verdict) {
    case reports::Verdict::kAdequate:
      if (!report.causes.empty())
        return "the declared model is adequate: what the readings show beside it is no error of the machine";
      return "the declared model is adequate: nothing significant is left in the readings";
    case reports::Verdict::kExtended:
      return "the model was extended";
    case reports::Verdict::kUnexplained:
      if (report.unexplained.empty() && HasNominal(report)) return "nominal data are wrong: no errors were looked for";
      return "there is structure in the readings that has no name";
  }
  return "";
}

std::string StepText(const reports::SelectionStep& step) {
  switch (step.change) {
    case reports::Change::kAdded:
      return "+ " + step.name;
    case reports::Change::kDropped:
      return "- " + step.name + " (no longer needed)";
    case reports::Change::kReplaced:
      return "= " + step.name + " (in the place of another that these sessions hardly tell from it)";
    case reports::Change::kRefused:
      return "x " + step.name + " (refused: the fit with it is worse)";
    case reports::Change::kWithdrawn:
      return "- " + step.name + " (withdrawn)";
  }
  return step.name;
}

using Rows = std::vector<std::vector<std::string>>;

Rows StepRows(const reports::Loop& report) {
  Rows rows = {{"step", "rms um"}, {"the declared model", NumberText(report.fit.before.rms_um)}};
  for (const reports::SelectionStep& step : report.steps) rows.push_back({StepText(step), NumberText(step.rms_um)});
  return rows;
}

// The residuals before and after.
std::string ResidualText(const reports::Loop& report, bool is_check_fitted) {
  const bool has_outliers = !report.fitted.outliers.empty();
  Rows rows = {{"residual rms, um", "before", "after"}};
  const auto add = [&](const std::string& what, const reports::Statistics& before, const reports::Statistics& after) {
    rows.push_back({what, NumberText(before.rms_um), NumberText(after.rms_um)});
    // Bad readings weigh more in the plain figure than anything that the model could explain.
    if (has_outliers) {
      rows.push_back({"  without readings set aside", NumberText(before.rms_without_outliers_um),
                      NumberText(after.rms_without_outliers_um)});
    }
  };
  add(is_check_fitted ? "all sessions" : "fit sessions", report.fit.before, report.fit.after);
  if (report.check) add("check sessions", report.check->before, report.check->after);
  return Table(rows);
}

std::string FigureText(const reports::VolumetricFigure& figure) {
  return absl::StrFormat("%.3g um rms [%.3g, %.3g]", figure.rms_um, figure.low_um, figure.high_um);
}

// "over the measured box (X -200 to 200 mm, C 0 to 360 deg) ...": what the tool point is off by, before and after.
std::string VolumetricText(const reports::Volumetric& volumetric) {
  std::vector<std::string> box;
  for (const reports::AxisRange& range : volumetric.box)
    box.push_back(absl::StrFormat("%s %.6g to %.6g %s", range.axis, range.from, range.to, range.unit));
  std::string text = absl::StrCat("tool point over the measured box (", absl::StrJoin(box, ", "),
                                  "), less work offset and tool, [95 % interval]:\n  machine as it is ",
                                  FigureText(volumetric.uncorrected));
  if (volumetric.gain_is_held) {
    absl::StrAppend(&text, "\n  corrected for the declared errors ", FigureText(volumetric.before),
                    ", for what was found too ", FigureText(volumetric.after), "\n");
  } else {
    absl::StrAppend(&text, "\n  corrected ", FigureText(volumetric.after),
                    ": no gain over the declared errors alone is promised\n");
  }
  if (!volumetric.weakest.empty())
    absl::StrAppend(&text, "  most of what is left: how well ", Names(volumetric.weakest), " is known\n");
  if (!volumetric.undecided.empty())
    absl::StrAppend(&text, "  most of what is left: whether it is ", Names(volumetric.undecided),
                    " or what these sessions cannot tell from it\n");
  if (!volumetric.unknown.empty())
    absl::StrAppend(&text, "  without what nobody knows there: ", Names(volumetric.unknown), "\n");
  return text;
}

std::string CausesText(const reports::Loop& report) {
  if (report.causes.empty()) return "";
  std::string text = "no errors of the machine, and never compensated:\n";
  for (const reports::Cause& cause : report.causes) {
    absl::StrAppend(&text, "  ", KindText(cause.kind), ": ", cause.subject);
    if (std::isfinite(cause.evidence)) absl::StrAppend(&text, absl::StrFormat(" (chi-square %.0f)", cause.evidence));
    absl::StrAppend(&text, "\n");
    if (!cause.correction.empty()) absl::StrAppend(&text, "      ", cause.correction, "\n");
  }
  return text;
}

std::string HeldBackText(const reports::Loop& report) {
  if (report.held_back.empty()) return "";
  std::string text =
      "found and not corrected, as the machine could be worse for it over the measured box, or no gain is certain:\n";
  for (const reports::HeldBack& held : report.held_back) {
    const auto why = [&]() -> std::string {
      switch (held.kind) {
        case reports::HeldBackKind::kNoGain:
          return "no gain over the box is certain";
        case reports::HeldBackKind::kHidden:
          return "over the box it does many times of all that the readings show";
        case reports::HeldBackKind::kUndecided:
          return absl::StrFormat("these sessions do not tell what it is (worse with probability %.2g)", held.harm);
        case reports::HeldBackKind::kUncertain:
          break;
      }
      return absl::StrFormat("these sessions hardly tell how large it is (worse with probability %.2g)", held.harm);
    };
    absl::StrAppend(&text, "  ", held.subject, ": ", why(), "\n      ", held.measure, "\n");
  }
  return text;
}

}  // namespace

std::string UnexplainedText(const reports::Loop& report) {
  if (report.unexplained.empty()) return "";
  std::string text = "unexplained:\n";
  for (const reports::Unexplained& part : report.unexplained) text += PartText(part) + KnockText(report, part);
  return text;
}

std::string LoopText(const reports::Loop& report) {
  std::string text;
  for (const reports::Warning& warning : report.fitted.warnings) {
    if (reports::ComesFirst(warning.kind)) absl::StrAppend(&text, "warning: ", warning.text, "\n");
  }
  absl::StrAppend(&text, "verdict: ", VerdictText(report), "\n");
  if (!report.effects.empty()) absl::StrAppend(&text, "effects that the declared model lacked:\n");
  for (const reports::Effect& effect : report.effects) text += EffectText(effect);
  text += CausesText(report);
  text += HeldBackText(report);
  text += UnexplainedText(report);
  for (const std::string& name : report.withdrawn)
    absl::StrAppend(&text, "withdrawn: ", name, " does not help on the check sessions\n");
  for (const reports::Warning& warning : report.fitted.warnings) {
    if (!reports::ComesFirst(warning.kind)) absl::StrAppend(&text, "warning: ", warning.text, "\n");
  }
  if (const size_t count = report.fitted.outliers.size(); count > 0) {
    absl::StrAppend(&text, count, " readings stand out of their series and were set aside (listed in the report)\n");
  }
  if (report.stopped_early) {
    const auto unnamed =
        std::count_if(report.unexplained.begin(), report.unexplained.end(), [](const reports::Unexplained& part) {
          return part.kind == reports::PartKind::kLocal || part.kind == reports::PartKind::kSlip;
        });
    absl::StrAppend(&text, "stopped at the limit of --max-effects with ", report.effects.size(), " effects",
                    unnamed > 0 ? absl::StrCat(" and ", unnamed, " parts without a name") : "",
                    ": more may be there\n");
  }
  const bool is_check_fitted = report.check && report.check->fitted;
  const std::string fitted = is_check_fitted ? "these sessions" : "the fit sessions";
  std::vector<std::string> untold;
  for (const reports::Error& error : report.fitted.errors) {
    if (!error.identifiable) untold.push_back(error.name);
  }
  if (!untold.empty()) {
    absl::StrAppend(&text, "errors without a number, which ", fitted, " do not tell: ", Names(untold), "\n");
  }
  if (!report.axes_at_rest.empty()) {
    absl::StrAppend(&text, "axes that never moved in ", fitted,
                    ", of which nothing is known: ", Names(report.axes_at_rest), "\n");
  }
  if (!report.not_visible.empty()) {
    absl::StrAppend(&text, fitted,
                    " could not see (set-ups and declared errors take it up): ", Names(NamesOf(report.not_visible)),
                    "\n");
  }
  if (!report.next_measurement.empty()) absl::StrAppend(&text, "measure next:\n");
  for (const reports::Proposal& proposal : report.next_measurement) text += ProposalText(proposal);
  if (!report.steps.empty()) text += Table(StepRows(report));
  if (is_check_fitted) {
    absl::StrAppend(&text,
                    "the fit sessions alone do not tell these amplitudes: all sessions were fitted together, and the "
                    "check sessions prove nothing\n");
  }
  text += ResidualText(report, is_check_fitted);
  if (report.volumetric) {
    text += VolumetricText(*report.volumetric);
  } else if (HasNominal(report)) {
    absl::StrAppend(&text, "tool point over the measured box: not known before the nominal data are right\n");
  }
  return text;
}

}  // namespace axiscal::cli
