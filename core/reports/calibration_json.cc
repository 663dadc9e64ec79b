#include "core/reports/report_json.h"

namespace axiscal::reports {

absl::StatusOr<nlohmann::ordered_json> ParseReport(const std::string& text) {
  constexpr size_t kMaxBytes = size_t{256} << 20;  // our own texts: correlations of many errors are long
  absl::StatusOr<nlohmann::ordered_json> document = base::ParseStrictJson(text, kMaxBytes);
  if (!document.ok()) return base::Within("report", document.status());
  return document;
}

absl::StatusOr<CalibrationReport> ReadCalibrationReport(const nlohmann::ordered_json& document) {
  if (document.is_object() && document.contains("verdict")) return ReadLoop(document);
  return ReadIdentification(document);
}

absl::StatusOr<CalibrationReport> ReadCalibrationReport(const std::string& text) {
  ASSIGN_OR_RETURN(const nlohmann::ordered_json document, ParseReport(text));
  return ReadCalibrationReport(document);
}

const Fitted& FittedOf(const CalibrationReport& report) {
  return std::visit([](const auto& of_a_kind) -> const Fitted& { return of_a_kind.fitted; }, report);
}

}  // namespace axiscal::reports
