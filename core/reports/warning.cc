#include "core/reports/warning.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "core/base/number_text.h"
#include "core/reports/digits.h"

namespace axiscal::reports {
namespace {

Warning Of(const Scatter& facts) {
  if (facts.about == Scatter::About::kCutter) {
    return {WarningKind::kScatter,
            absl::StrFormat("the readings scatter by %.1f times their stated sigma about the curves of this cutter: "
                            "a number of it is another, or readings are bad",
                            facts.times_sigma)};
  }
  return {WarningKind::kScatter, absl::StrFormat("the readings scatter by %.1f times their stated sigma about this "
                                                 "model: it lacks something, or a session is bad",
                                                 facts.times_sigma)};
}

Warning Of(const SetAside& facts) {
  return {WarningKind::kSetAside, absl::StrFormat("%d of %d readings stand out and were set aside, too many for "
                                                  "chips: the model lacks something that they show",
                                                  facts.set_aside, facts.readings)};
}

Warning Of(const NoInterval& facts) {
  return {WarningKind::kInterval, absl::StrJoin(facts.errors, ", ") +
                                      ": the readings leave the set-up so open that no interval can be stated "
                                      "(another set-up with other errors explains them as well)"};
}

Warning Of(const NoNumber& facts) {
  std::string sizes;
  for (const NoNumber::Size& error : facts.errors) {
    absl::StrAppend(&sizes, sizes.empty() ? "" : ", ",
                    absl::StrFormat("%s at %.0f %s", error.error, error.size, error.unit));
  }
  return {WarningKind::kNoNumber, sizes +
                                      ": the fit ended there because something had to take up what the readings show, "
                                      "but no reading supports such a size; do not compensate with this model away "
                                      "from the measured poses"};
}

std::string OffsetText(const std::string& name, const std::string& setup) {
  return absl::StrCat(name, setup.empty() ? "" : " of set-up ", setup);
}

Warning Of(const SharedStages& facts) {
  constexpr char kAdvice[] =
      ": the stated sigmas take both stages for independent; identify from all sessions together";
  return {WarningKind::kHeld, !facts.sessions.empty()
                                  ? absl::StrCat("the held errors come from sessions that are used again (",
                                                 absl::StrJoin(facts.sessions, ", "), ")", kAdvice)
                                  : absl::StrCat("the held errors rest on the same stated sigma as this fit (",
                                                 absl::StrJoin(facts.offsets, ", ",
                                                               [](std::string* out, const OffsetOf& offset) {
                                                                 *out += OffsetText(offset.name, offset.setup);
                                                               }),
                                                 ")", kAdvice)};
}

Warning Of(const CoarseReadings& facts) {
  return {WarningKind::kResolution,
          absl::StrFormat("session '%s': readings stand in steps of %.4g um, expected at most %g times the stated "
                          "sigma of %.4g um: what rounding hides is counted as noise of %.4g um",
                          facts.session, facts.step_um, facts.most_sigmas, facts.sigma_um, facts.rounding_sigma_um)};
}

std::string ValueText(const BeyondSize::Value& value) {
  return absl::StrFormat("%s at %.0f %s", OffsetText(value.name, value.setup), value.value, value.unit);
}

Warning Of(const BeyondSize& facts) {
  std::vector<std::string> parts;
  for (const auto* values : {&facts.errors, &facts.offsets}) {
    for (const BeyondSize::Value& value : *values) parts.push_back(ValueText(value));
  }
  std::string text = absl::StrJoin(parts, ", ");
  if (!facts.errors.empty()) {
    absl::StrAppend(&text,
                    absl::StrFormat(": a machine about %.1f m across has errors of at most %.0f um and %.0f urad",
                                    1e-3 * facts.size_mm, facts.limit_um, facts.limit_urad));
  }
  if (!facts.offsets.empty()) absl::StrAppend(&text, ": mounting leaves less by far");
  absl::StrAppend(&text,
                  "; is a tool length (tool_tip_mm), a radius of sphere or stylus (forgotten or counted twice), "
                  "a point_mm of machine.json or the unit of a file (m or inch in place of mm) wrong?");
  if (!facts.near.empty()) {
    absl::StrAppend(
        &text,
        " About as large: ", absl::StrJoin(facts.near, ", ", [](std::string* out, const BeyondSize::Radius& radius) {
          const std::string of = radius.sphere.empty() ? "stylus radius" : "radius of sphere " + radius.sphere;
          absl::StrAppend(out, absl::StrFormat("the %s of %g mm", of, radius.mm));
        }));
  }
  return {WarningKind::kSize, std::move(text)};
}

Warning Of(const Quiet& facts) {
  return {WarningKind::kQuiet,
          absl::StrFormat("session%s %s: the readings scatter about the fit by %.2g of their stated sigma, expected at "
                          "least a tenth: are they in m or inch in place of mm (all errors are then too small by the "
                          "same factor), or is sigma_um too large?",
                          facts.sessions.size() == 1 ? "" : "s", absl::StrJoin(facts.sessions, ", "), facts.share)};
}

Warning Of(const DatumMoved& facts) {
  std::string text;
  for (const DatumMoved::Group& group : facts.groups) {
    std::string axes, names;
    for (const DatumMoved::Axis& axis : group.axes) {
      absl::StrAppend(
          &axes, axes.empty() ? "" : ", ",
          absl::StrFormat("%s by %s +- %s um", axis.name, Digits(axis.moved_um, 4), Digits(axis.sigma_um, 2)));
      absl::StrAppend(&names, " ", axis.name);
    }
    const bool is_one = group.sessions.size() == 1;
    absl::StrAppend(&text, text.empty() ? "" : "; ",
                    absl::StrFormat("session%s %s disagree%s with the others by a constant of the commanded position "
                                    "(%s): was the work offset set anew before? Then '# datum: free%s' belongs into "
                                    "%s header%s",
                                    is_one ? "" : "s", absl::StrJoin(group.sessions, ", "), is_one ? "s" : "", axes,
                                    names, is_one ? "its" : "their", is_one ? "" : "s"));
  }
  if (!facts.in_place_of.empty()) {
    const bool is_one = facts.in_place_of.size() == 1;
    text = absl::StrFormat("%s may be no error%s of the machine: without %s, %s",
                           absl::StrJoin(facts.in_place_of, ", "), is_one ? "" : "s", is_one ? "it" : "them", text);
  }
  return {WarningKind::kDatum, std::move(text)};
}

Warning Of(const NoFreedom& facts) {
  return {WarningKind::kNoFreedom,
          absl::StrCat("no degree of freedom: ", facts.unknowns, " from ", facts.readings,
                       ", so that nothing shows by how much they are wrong: ",
                       facts.without_sigma.empty()
                           ? std::string("the sigmas rest on what was stated beforehand alone")
                           : absl::StrCat(absl::StrJoin(facts.without_sigma, ", "), " without sigma"),
                       "; ", facts.what_to_do)};
}

Warning Of(const Expired& facts) {
  const std::string certificate = absl::StrCat("session ", facts.session, ": certificate ", facts.number, " of ",
                                               facts.of, " is valid until ", facts.due);
  if (facts.started.empty()) {
    return {WarningKind::kCertificate,
            certificate +
                ", and no '# started: ...' says when the session was measured: whether it was valid then is "
                "not known"};
  }
  return {WarningKind::kCertificate,
          absl::StrCat(certificate, " and was expired when the session began on ", facts.started,
                       ": what it states counts as if it were valid; have it "
                       "calibrated and compare")};
}

Warning Of(const TwoClocks& facts) {
  return {WarningKind::kClock,
          absl::StrCat("sessions ", facts.session, " and ", facts.other,
                       " overlap in time: t_s of each counts from a start of its own, and ",
                       absl::StrJoin(facts.errors, ", "),
                       " took the same t_s for the same moment; let t_s run on from session to session")};
}

Warning Of(const TrackerMoved& facts) {
  return {
      WarningKind::kMoved,
      absl::StrFormat("session '%s': the tracker itself moved, not the machine: what stands in the middle of its "
                      "readings seemed to go by up to %s +- %s um and to turn by %s +- %s urad (t_s = %.0f), "
                      "as %d reference targets show in %d looks; it is taken off and in no error",
                      facts.session, Digits(facts.moved_um, 3), Digits(facts.sigma_um, 2), Digits(facts.turned_urad, 3),
                      Digits(facts.turn_sigma_urad, 2), facts.at_s, facts.references, facts.looks)};
}

}  // namespace

Warning InWords(const WarningFacts& facts) {
  Warning warning = std::visit([](const auto& of_a_kind) { return Of(of_a_kind); }, facts);
  warning.german = InGerman(facts);
  return warning;
}

std::string PoorFitText(double chi2_per_dof, bool is_of_loop) {
  return absl::StrCat("the readings scatter by ", base::NumberText(std::sqrt(chi2_per_dof)),
                      " times their stated sigma about this model: it lacks something",
                      is_of_loop ? " that has no name yet" : " (axiscal close-loop looks for it)",
                      ", or a session is bad");
}

}  // namespace axiscal::reports
