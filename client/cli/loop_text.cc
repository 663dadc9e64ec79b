#include "client/cli/loop_text.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_join.h"

namespace axiscal::cli {
namespace {

Json List(const Json& object, const char* name) { return object.value(name, Json::array()); }

double Number(const Json& object, const char* path) {
  const Json value = object.value(Json::json_pointer(path), Json());
  return value.is_number() ? value.get<double>() : NAN;
}

// The first names of a list, and how many more.
std::string Names(const Json& names) {
  constexpr size_t kShown = 5;
  std::string text;
  for (size_t i = 0; i < std::min(kShown, names.size()); ++i)
    absl::StrAppend(&text, i == 0 ? "" : ", ",
                    names[i].is_object()   ? names[i].value("name", "")
                    : names[i].is_string() ? names[i].get<std::string>()
                                           : names[i].dump());
  if (names.size() > kShown) absl::StrAppend(&text, " and ", names.size() - kShown, " more");
  return text;
}

// What the amplitude of a shape means where its unit does not say it, and the shape's own length or time.
std::string ReferenceText(const Json& effect) {
  const std::string shape = effect.value("shape", "");
  if (shape == "backlash") return " peak to peak";
  if (shape == "quadratic") return " at 250 mm or 1 rad from zero";
  if (shape == "drift-exp") return absl::StrFormat(" when warm (time constant %.4g s)", Number(effect, "/tau_s"));
  if (shape == "reversal" && effect.contains("length_mm"))
    return absl::StrFormat(" at the reversal, decaying over %.3g mm", Number(effect, "/length_mm"));
  if (shape == "reversal" && effect.contains("length_deg"))
    return absl::StrFormat(" at the reversal, decaying over %.3g deg", Number(effect, "/length_deg"));
  return "";
}

// "EXX:backlash    -2.92 +- 0.02 um peak to peak, 0.9 um rms in the readings" and what else it could be.
std::string EffectText(const Json& effect) {
  std::string text =
      absl::StrFormat("  %-24s %10.4g +- %.2g %s%s, %.3g um rms in the readings\n", effect.value("name", ""),
                      Number(effect, "/amplitude"), Number(effect, "/amplitude_sigma"), effect.value("unit", ""),
                      ReferenceText(effect), Number(effect, "/rms_um"));
  const Json same = List(effect, "same_always");
  Json others = Json::array();
  for (const Json& other : List(effect, "equivalent")) {
    if (std::find(same.begin(), same.end(), other.value("name", "")) == same.end()) others.push_back(other);
  }
  if (!others.empty()) absl::StrAppend(&text, "      these sessions cannot tell it from ", Names(others), "\n");
  if (!same.empty()) absl::StrAppend(&text, "      the same by another name, in any measurement: ", Names(same), "\n");
  const Json aliases = List(effect, "alias_orders");
  if (!aliases.empty())
    absl::StrAppend(&text, "      at these positions it would read the same with order ", Names(aliases), "\n");
  return text;
}

// A session that tells the members of a class apart: what to measure, and what it brings.
std::string ProposalText(const Json& proposal) {
  const std::string effect = proposal.value("effect", "");
  const Json remaining = List(proposal, "remaining");
  if (!proposal.contains("test")) return "  no known test tells " + effect + " from " + Names(remaining) + "\n";
  std::string text = absl::StrFormat("  %s (%s)\n", proposal.value("text", ""), proposal.value("test", ""));
  if (proposal.contains("beyond")) absl::StrAppend(&text, "      moves ", proposal.value("beyond", ""), "\n");
  if (proposal.value("needs_next", false)) return text + "      together with the next one\n";
  // One alone is told from errors that are no members of its class, but that too little would keep apart from it.
  const Json separates = List(proposal, "separates");
  absl::StrAppend(
      &text, "      ",
      separates.size() == 1 ? "tells " + Names(separates) + " from errors that come close to it"
                            : "tells apart " + Names(separates),
      absl::StrFormat(": correlation %.3f -> %.3f, chi-square %.0f or more\n", Number(proposal, "/correlation_before"),
                      Number(proposal, "/correlation_after"), Number(proposal, "/expected_chi2")));
  if (!remaining.empty()) absl::StrAppend(&text, "      leaves ", effect, " with ", Names(remaining), "\n");
  return text;
}

std::string CarriedBy(const std::string& carrier) {
  return carrier == "tool" ? "what the tool holder carries" : "what stands on the table";
}

std::string SlippedText(const Json& slip) {
  const std::string other = slip.value("may_be", "");
  return CarriedBy(slip.value("carrier", "")) + (other.empty() ? "" : " (or " + CarriedBy(other) + ")");
}

// ", by x 3.01 +- 0.05 um, z -1.2 +- 0.1 um": directions that the session sees.
std::string MovedText(const Json& slip) {
  std::vector<std::string> moved;
  for (size_t k = 0; k < 3; ++k) {
    const std::string at = absl::StrCat("/", k);
    if (const double by = Number(slip, ("/moved_um" + at).c_str()); std::isfinite(by))
      moved.push_back(absl::StrFormat("%c %.3g +- %.2g um", "xyz"[k], by, Number(slip, ("/sigma_um" + at).c_str())));
  }
  return moved.empty() ? "" : ", by " + absl::StrJoin(moved, ", ");
}

std::string PartText(const Json& part) {
  const std::string variable = part.value("variable", ""), unit = part.value("unit", "");
  const double from = Number(part, "/from"), to = Number(part, "/to");
  if (part.value("kind", "") == "check-session") {
    return absl::StrFormat("  check session %s: its readings leave %.3g um rms that the model does not explain\n",
                           part.value("session", ""), Number(part, "/rms_um"));
  }
  if (part.value("kind", "") == "scatter") {
    return absl::StrFormat("  session %s: its readings scatter by %.3g um rms, far more than it states\n",
                           part.value("session", ""), Number(part, "/rms_um"));
  }
  if (variable == "t") {
    return absl::StrFormat("  session %s: %s moved between %.6g s and %.6g s%s\n", part.value("session", ""),
                           part.contains("slip") ? SlippedText(part["slip"]) : "the artefact or the setup", from, to,
                           part.contains("slip") ? MovedText(part["slip"]) : "");
  }
  if (part.value("kind", "") == "bad-readings") {
    return absl::StrFormat("  %s from %.6g to %.6g %s: bad readings cluster there, %.3g um rms: structure, not chips\n",
                           variable, from, to, unit, Number(part, "/rms_um"));
  }
  return absl::StrFormat("  %s from %.6g to %.6g %s: local structure without a name, %.3g um rms\n", variable, from, to,
                         unit, Number(part, "/rms_um"));
}

std::string VerdictText(const std::string& verdict) {
  if (verdict == "adequate") return "the declared model is adequate: nothing significant is left in the readings";
  if (verdict == "extended") return "the model was extended";
  return "there is structure in the readings that has no name";
}

using Rows = std::vector<std::vector<std::string>>;

Rows StepRows(const Json& report) {
  Rows rows = {{"step", "rms um"}, {"the declared model", NumberText(Number(report, "/fit/before/rms_um"))}};
  for (const Json& step : List(report, "steps")) {
    const std::string change = step.value("change", ""), name = step.value("name", "");
    const std::string text = change == "added"     ? "+ " + name
                             : change == "dropped" ? "- " + name + " (no longer needed)"
                             : change == "replaced"
                                 ? "= " + name + " (in the place of another that these sessions hardly tell from it)"
                             : change == "refused" ? "x " + name + " (refused: the fit with it is worse)"
                                                   : "- " + name + " (withdrawn)";
    rows.push_back({text, NumberText(Number(step, "/rms_um"))});
  }
  return rows;
}

}  // namespace

std::string UnexplainedText(const Json& report) {
  if (!report.is_object() || List(report, "unexplained").empty()) return "";
  std::string text = "unexplained:\n";
  for (const Json& part : List(report, "unexplained")) absl::StrAppend(&text, PartText(part));
  return text;
}

std::string LoopText(const Json& report) {
  std::string text = absl::StrCat("verdict: ", VerdictText(report.value("verdict", "")), "\n");
  const Json effects = List(report, "effects");
  if (!effects.empty()) absl::StrAppend(&text, "effects that the declared model lacked:\n");
  for (const Json& effect : effects) absl::StrAppend(&text, EffectText(effect));
  absl::StrAppend(&text, UnexplainedText(report));
  for (const Json& name : List(report, "withdrawn")) {
    absl::StrAppend(&text, "withdrawn: ", name.get<std::string>(), " does not help on the check sessions\n");
  }
  for (const Json& warning : List(report, "warnings"))
    absl::StrAppend(&text, "warning: ", warning.value("text", ""), "\n");
  if (const size_t count = List(report, "outliers").size(); count > 0) {
    absl::StrAppend(&text, count, " readings stand out of their series and were set aside (listed in the report)\n");
  }
  if (report.value("stopped_early", false)) {
    const Json parts = List(report, "unexplained");
    const auto unnamed = std::count_if(parts.begin(), parts.end(), [](const Json& part) {
      return part.value("kind", "") == "local" || part.value("kind", "") == "slip";
    });
    absl::StrAppend(&text, "stopped at the limit of --max-effects with ", List(report, "effects").size(), " effects",
                    unnamed > 0 ? absl::StrCat(" and ", unnamed, " parts without a name") : "",
                    ": more may be there\n");
  }
  const bool is_check_fitted = report.contains("check") && report["check"].value("fitted", false);
  const std::string fitted = is_check_fitted ? "these sessions" : "the fit sessions";
  Json untold = Json::array();
  for (const Json& error : List(report, "errors"))
    if (!error.value("identifiable", true)) untold.push_back(error.value("name", error.value("symbol", "")));
  if (!untold.empty()) {
    absl::StrAppend(&text, "errors without a number, which ", fitted, " do not tell: ", Names(untold), "\n");
  }
  if (const Json rest = List(report, "axes_at_rest"); !rest.empty()) {
    absl::StrAppend(&text, "axes that never moved in ", fitted, ", of which nothing is known: ", Names(rest), "\n");
  }
  if (const Json hidden = List(report, "not_visible"); !hidden.empty()) {
    absl::StrAppend(&text, fitted, " could not see (set-ups and declared errors take it up): ", Names(hidden), "\n");
  }
  const Json proposals = List(report, "next_measurement");
  if (!proposals.empty()) absl::StrAppend(&text, "measure next:\n");
  for (const Json& proposal : proposals) absl::StrAppend(&text, ProposalText(proposal));
  if (!List(report, "steps").empty()) absl::StrAppend(&text, Table(StepRows(report)));
  if (is_check_fitted) {
    absl::StrAppend(&text,
                    "the fit sessions alone do not tell these amplitudes: all sessions were fitted together, and the "
                    "check sessions prove nothing\n");
  }
  const bool has_outliers = !List(report, "outliers").empty();
  Rows rows = {{"residual rms, um", "before", "after"}};
  const auto add = [&rows](const std::string& what, const Json& both, const std::string& field) {
    rows.push_back({what, NumberText(Number(both, ("/before/" + field).c_str())),
                    NumberText(Number(both, ("/after/" + field).c_str()))});
  };
  for (const char* sessions : {"fit", "check"}) {
    if (!report.contains(sessions)) continue;
    const bool is_all = is_check_fitted && std::string(sessions) == "fit";
    add(is_all ? "all sessions" : absl::StrCat(sessions, " sessions"), report[sessions], "rms_um");
    // Bad readings weigh more in the plain figure than anything that the model could explain.
    if (has_outliers) add("  without readings set aside", report[sessions], "rms_without_outliers_um");
  }
  return text + Table(rows);
}

}  // namespace axiscal::cli
