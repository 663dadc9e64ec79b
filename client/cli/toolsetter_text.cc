#include "client/cli/toolsetter_text.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_join.h"
#include "client/cli/output.h"

namespace axiscal::cli {
namespace {

std::string Fixed(double number, int decimals) {
  return std::isfinite(number) ? absl::StrFormat("%.*f", decimals, number) : "-";
}

std::string ParameterLine(const std::string& name, const reports::BeamParameter& parameter, const std::string& unit,
                          double sigma_unit, const std::string& sigma_name, int decimals) {
  if (parameter.stated) return absl::StrCat(name, " ", Fixed(*parameter.stated, decimals), " ", unit, ", stated\n");
  if (!parameter.identifiable) return absl::StrCat(name, ": these rods cannot tell\n");
  const std::string estimate = absl::StrCat(name, " ", Fixed(parameter.estimate, decimals), " ", unit);
  if (!std::isfinite(parameter.sigma)) return estimate + ", its sigma is not known\n";
  return absl::StrCat(estimate, " +- ", NumberText(parameter.sigma * sigma_unit), " ", sigma_name, "\n");
}

std::string UnseenText(const reports::Unseen& unseen) {
  std::vector<std::string> parts;
  if (unseen.z_um) parts.push_back("Z " + NumberText(unseen.z_um) + " um");
  if (unseen.yaw_urad) parts.push_back("yaw " + NumberText(unseen.yaw_urad) + " urad");
  if (unseen.pitch_urad) parts.push_back("pitch " + NumberText(unseen.pitch_urad) + " urad");
  return "not told apart: " + absl::StrJoin(parts, " with ") + "\n";
}

}  // namespace

std::string ToText(const reports::BeamReference& report) {
  std::string text = ParameterLine("reference point Z", report.reference_mm, "mm", 1e3, "um", 4);
  absl::StrAppend(&text, ParameterLine("beam yaw", report.yaw_deg, "deg", 1.0, "deg", 4),
                  ParameterLine("beam pitch", report.pitch_deg, "deg", 1.0, "deg", 4));
  std::vector<std::vector<std::string>> rows = {
      {"rod", "readouts", "range um", "Zd mm", "reference mm", "+- um", "residual um"}};
  for (const reports::RodAnswer& rod : report.rods) {
    rows.push_back({rod.rod, std::to_string(rod.readouts), Fixed(rod.range_um, 1), Fixed(rod.trigger_height_mm, 6),
                    Fixed(rod.reference_mm, 4), Fixed(rod.sigma_um, 2), Fixed(rod.residual_um, 2)});
  }
  absl::StrAppend(&text, Table(rows));
  absl::StrAppend(&text, "spread between rods: range ", Fixed(report.range_um, 2), " um, ",
                  report.between_rods_um > 0.0 ? Fixed(report.between_rods_um, 2) +
                                                     " um (1 sigma) more than readouts and stated errors explain\n"
                  : report.chi2 > std::max(1, report.degrees_of_freedom)
                      ? std::string("more than readouts and stated errors explain: sigma is raised by it\n")
                      : std::string("as readouts and stated errors explain\n"));
  for (const reports::Warning& warning : report.warnings) absl::StrAppend(&text, "warning: ", warning.text, "\n");
  constexpr double kNormal = 1.96;
  if (report.coverage_factor > kNormal + 0.01)
    absl::StrAppend(&text, "a 95 % interval is +- ", NumberText(report.coverage_factor),
                    " times the sigma: so few rods tell it\n");
  for (const reports::Unseen& unseen : report.not_told_apart) text += UnseenText(unseen);
  if (report.next_measurement) {
    const reports::RodProposal& next = *report.next_measurement;
    absl::StrAppend(&text, "measure next: ", next.rod, " with the spindle at ", next.theta_th_deg.size(),
                    " angles, 30 deg apart: Z +- ", NumberText(next.sigma_um), " um, yaw +- ",
                    NumberText(next.yaw_sigma_deg), " deg, pitch +- ", NumberText(next.pitch_sigma_deg),
                    " deg, free of the rods' lengths but its own\n");
  }
  return text;
}

std::string ToText(const reports::Wear& report) {
  std::string text =
      absl::StrCat("tool length ", Fixed(report.length_mm, 5), " mm +- ", NumberText(report.length_sigma_um),
                   " um (the longest reading is ", Fixed(report.longest_reading_mm, 5), " mm)\n");
  std::vector<std::vector<std::string>> rows = {
      {"insert", "wear um", "+- um", "readings", "fires first deg", "unseen from um"}};
  for (const reports::InsertWear& insert : report.inserts) {
    const bool seen = insert.identifiable;
    rows.push_back({std::to_string(insert.insert),
                    seen ? Fixed(insert.wear_um, 2) : "> " + Fixed(insert.at_least_um.value_or(NAN), 1),
                    seen ? Fixed(insert.sigma_um, 2) : "-", std::to_string(insert.readings),
                    Fixed(insert.fires_first_deg, 0), Fixed(insert.unseen_from_um, 1)});
  }
  absl::StrAppend(&text, Table(rows));
  absl::StrAppend(&text, "residual rms ", NumberText(report.rms_um), " um, chi2 ", NumberText(report.chi2), " at ",
                  report.degrees_of_freedom, " degrees of freedom\n");
  for (const reports::Warning& warning : report.warnings) absl::StrAppend(&text, "warning: ", warning.text, "\n");
  if (report.next_measurement) {
    absl::StrAppend(
        &text, "an insert never fired: measure with a feed of ", NumberText(report.next_measurement->feed_mm_min),
        " mm/min at ", NumberText(report.next_measurement->spindle_rpm), " rpm, which shows wear of up to ",
        Fixed(report.next_measurement->sees_up_to_um, 1),
        " um by the model. That it is worn by less is an assumption, and that the machine runs this feed\n");
  } else if (std::any_of(report.inserts.begin(), report.inserts.end(),
                         [](const reports::InsertWear& insert) { return !insert.identifiable; })) {
    text +=
        "an insert never fired, and no feed at this speed would show its wear: expected a lower speed, or an offset "
        "nearer to where the inserts' lowest points pass\n";
  }
  return text;
}

}  // namespace axiscal::cli
