#include <nlohmann/json.hpp>

#include "core/base/strict_json.h"
#include "core/compare/side.h"
#include "core/reports/report_json.h"

namespace axiscal::compare {

absl::StatusOr<Side> ReadSide(const std::string& text, const machine::Machine& machine) {
  Side side;
  // A calibration's report holds the correlations of many errors.
  constexpr size_t kMaxBytes = size_t{256} << 20;
  ASSIGN_OR_RETURN(const nlohmann::ordered_json root, base::ParseStrictJson(text, kMaxBytes));
  const bool is_calibration = root.is_object() && root.contains("model") && root.contains("report");
  if (!is_calibration) {
    if (root.is_object() && (root.contains("verdict") || root.contains("estimates"))) {
      return absl::InvalidArgumentError(
          "a report without its errors, expected an errors.json or a calibration (calibration show ID --json)");
    }
    ASSIGN_OR_RETURN(side.errors, machine::ReadKnownErrors(text, machine));
    return side;
  }
  const auto of = root.find("machine");
  if (of != root.end() && of->is_string() && !of->get<std::string>().empty() && *of != machine.id) {
    return absl::InvalidArgumentError(
        absl::StrCat("it is of machine ", of->get<std::string>(), ", expected of ", machine.id));
  }
  ASSIGN_OR_RETURN(side.errors, machine::ReadKnownErrors(root["model"].dump(), machine));
  ASSIGN_OR_RETURN(const reports::CalibrationReport report, reports::ReadCalibrationReport(root["report"]));
  AddReport(report, &side);
  return side;
}

}  // namespace axiscal::compare
