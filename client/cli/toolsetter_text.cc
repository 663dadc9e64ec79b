#include "client/cli/toolsetter_text.h"

namespace axiscal::cli {
namespace {

std::string Fixed(const Json& number, int decimals) {
  return number.is_number() ? absl::StrFormat("%.*f", decimals, number.get<double>()) : "-";
}

std::string ParameterLine(const std::string& name, const Json& parameter, const std::string& unit, double sigma_unit,
                          const std::string& sigma_name, int decimals) {
  if (parameter.contains("stated"))
    return absl::StrCat(name, " ", Fixed(parameter["stated"], decimals), " ", unit, ", stated\n");
  if (!parameter["identifiable"].get<bool>()) return absl::StrCat(name, ": these rods cannot tell\n");
  return absl::StrCat(name, " ", Fixed(parameter["estimate"], decimals), " ", unit, " +- ",
                      NumberText(parameter["sigma"].get<double>() * sigma_unit), " ", sigma_name, "\n");
}

}  // namespace

std::string ReferenceText(const Json& report) {
  std::string text = ParameterLine("reference point Z", report["reference_mm"], "mm", 1e3, "um", 4);
  absl::StrAppend(&text, ParameterLine("beam yaw", report["yaw_deg"], "deg", 1.0, "deg", 4),
                  ParameterLine("beam pitch", report["pitch_deg"], "deg", 1.0, "deg", 4));
  std::vector<std::vector<std::string>> rows = {
      {"rod", "readouts", "range um", "Zd mm", "reference mm", "+- um", "residual um"}};
  for (const Json& rod : report["rods"]) {
    rows.push_back({rod["rod"].get<std::string>(), rod["readouts"].dump(), Fixed(rod["range_um"], 1),
                    Fixed(rod["trigger_height_mm"], 6), Fixed(rod["reference_mm"], 4), Fixed(rod["sigma_um"], 2),
                    Fixed(rod["residual_um"], 2)});
  }
  absl::StrAppend(&text, Table(rows));
  absl::StrAppend(
      &text, "spread between rods: range ", Fixed(report["range_um"], 2), " um, ",
      report["between_rods_um"].get<double>() > 0.0
          ? Fixed(report["between_rods_um"], 2) + " um (1 sigma) more than readouts and stated errors explain\n"
      : report["chi2"].get<double>() > std::max(1, report["degrees_of_freedom"].get<int>())
          ? std::string("more than readouts and stated errors explain: sigma is raised by it\n")
          : std::string("as readouts and stated errors explain\n"));
  for (const Json& unseen : report["not_told_apart"]) {
    std::string parts;
    for (const auto& [name, change] : unseen.items()) {
      const size_t unit = name.rfind('_');
      absl::StrAppend(&parts, parts.empty() ? "" : " with ", name.substr(0, unit), " ",
                      NumberText(change.get<double>()), " ", name.substr(unit + 1));
    }
    absl::StrAppend(&text, "not told apart: ", parts, "\n");
  }
  if (report.contains("next_measurement")) {
    const Json& next = report["next_measurement"];
    absl::StrAppend(&text, "measure next: ", next["rod"].get<std::string>(), " with the spindle at ",
                    next["theta_th_deg"].size(), " angles, 30 deg apart: Z +- ",
                    NumberText(next["sigma_um"].get<double>()), " um, yaw +- ",
                    NumberText(next["yaw_sigma_deg"].get<double>()), " deg, pitch +- ",
                    NumberText(next["pitch_sigma_deg"].get<double>()), " deg, free of the rods' lengths but its own\n");
  }
  return text;
}

std::string WearText(const Json& report) {
  std::string text = absl::StrCat("tool length ", Fixed(report["length_mm"], 5), " mm +- ",
                                  NumberText(report["length_sigma_um"].get<double>()), " um (the longest reading is ",
                                  Fixed(report["longest_reading_mm"], 5), " mm)\n");
  std::vector<std::vector<std::string>> rows = {
      {"insert", "wear um", "+- um", "readings", "fires first deg", "unseen from um"}};
  for (const Json& insert : report["inserts"]) {
    const bool seen = insert["identifiable"].get<bool>();
    rows.push_back({insert["insert"].dump(),
                    seen ? Fixed(insert["wear_um"], 2) : "> " + Fixed(insert["at_least_um"], 1),
                    seen ? Fixed(insert["sigma_um"], 2) : "-", insert["readings"].dump(),
                    Fixed(insert["fires_first_deg"], 0), Fixed(insert["unseen_from_um"], 1)});
  }
  absl::StrAppend(&text, Table(rows));
  absl::StrAppend(&text, "residual rms ", NumberText(report["fit"]["rms_um"].get<double>()), " um, chi2 ",
                  NumberText(report["fit"]["chi2"].get<double>()), " at ", report["fit"]["degrees_of_freedom"].dump(),
                  " degrees of freedom\n");
  for (const Json& warning : report.value("warnings", Json::array()))
    absl::StrAppend(&text, "warning: ", warning["text"].get<std::string>(), "\n");
  if (report.contains("next_measurement")) {
    absl::StrAppend(&text, "an insert never fired: measure with a feed of ",
                    NumberText(report["next_measurement"]["feed_mm_min"].get<double>()), " mm/min at ",
                    NumberText(report["next_measurement"]["spindle_rpm"].get<double>()), " rpm to see its wear\n");
  }
  return text;
}

}  // namespace axiscal::cli
