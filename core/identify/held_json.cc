#include <nlohmann/json.hpp>

#include "core/base/strict_json.h"
#include "core/identify/held.h"
#include "core/machine/error_json.h"
#include "core/machine/error_symbol.h"
#include "core/reports/report_json.h"

namespace axiscal::identify {
namespace {

using json = nlohmann::ordered_json;

bool IsCalibration(const json& root) { return root.is_object() && root.contains("model") && root.contains("report"); }

absl::StatusOr<machine::ErrorModel> ReadModel(const std::string& text, const machine::Machine& machine) {
  absl::StatusOr<machine::ErrorModel> model = machine::ReadErrors(text, machine);
  if (!model.ok()) return base::Within("held errors", model.status());
  return model;
}

absl::StatusOr<reports::CalibrationReport> ReadReport(absl::StatusOr<reports::CalibrationReport> report) {
  if (!report.ok()) return base::Within("held errors", report.status());
  return report;
}

}  // namespace

absl::StatusOr<HeldErrors> ReadHeldErrors(const std::string& text, const machine::Machine& machine) {
  const auto root = base::ParseStrictJson(text);
  if (!root.ok()) return base::Within("held errors", root.status());
  if (!IsCalibration(*root)) {
    if (root->is_object() && (root->contains("verdict") || root->contains("estimates"))) {
      return absl::InvalidArgumentError(
          "held errors: a report, expected an errors.json or a calibration (calibration show ID --json)");
    }
    ASSIGN_OR_RETURN(machine::ErrorModel model, ReadModel(text, machine));
    return HoldErrors(std::move(model), std::nullopt, machine);
  }
  ASSIGN_OR_RETURN(machine::ErrorModel model, ReadModel((*root)["model"].dump(), machine));
  const auto of = root->find("machine");
  if (of != root->end() && of->is_string() && !of->get<std::string>().empty() && *of != machine.id) {
    return absl::InvalidArgumentError(
        absl::StrCat("held errors: they are of machine ", of->get<std::string>(), ", expected of ", machine.id));
  }
  ASSIGN_OR_RETURN(const reports::CalibrationReport report,
                   ReadReport(reports::ReadCalibrationReport((*root)["report"])));
  return HoldErrors(std::move(model), report, machine);
}

absl::StatusOr<HeldErrors> ReadHeldErrors(const std::string& model_json, const std::string& report_json,
                                          const machine::Machine& machine) {
  ASSIGN_OR_RETURN(machine::ErrorModel model, ReadModel(model_json, machine));
  ASSIGN_OR_RETURN(const reports::CalibrationReport report, ReadReport(reports::ReadCalibrationReport(report_json)));
  return HoldErrors(std::move(model), report, machine);
}

absl::StatusOr<std::string> OnlyConstants(const std::string& option, const std::vector<std::string>& names,
                                          const std::string& text) {
  const auto root = base::ParseStrictJson(text);
  if (!root.ok()) return root.status();
  json document = *root;
  if (!document.is_object()) return text;  // refused where it is read
  json& errors = document.contains("model") && document["model"].is_object() ? document["model"] : document;
  json kept = json::object();
  for (const std::string& name : names) {
    ASSIGN_OR_RETURN(const machine::ErrorSymbol symbol, machine::ParseErrorSymbol(name));
    const std::string written = machine::ToString(symbol);
    if (!errors.contains(written))
      return absl::InvalidArgumentError(absl::StrCat(option, ": ", name, " is no constant error of what is held"));
    kept[written] = errors[written];
  }
  if (&errors == &document) return kept.dump();
  json calibration = json::object();
  for (const char* const key : {"id", "machine", "report"}) {
    if (document.contains(key)) calibration[key] = document[key];
  }
  calibration["model"] = std::move(kept);
  return calibration.dump();
}

}  // namespace axiscal::identify
