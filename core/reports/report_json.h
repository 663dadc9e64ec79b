// What the readers of reports share.
#ifndef AXISCAL_CORE_REPORTS_REPORT_JSON_H_
#define AXISCAL_CORE_REPORTS_REPORT_JSON_H_

#include <nlohmann/json.hpp>
#include <string>

#include "core/base/json_members.h"
#include "core/base/status.h"
#include "core/reports/calibration.h"

namespace axiscal::reports {

// INVALID_ARGUMENT "report: line 3, column 7: ..." where `text` is no JSON.
absl::StatusOr<nlohmann::ordered_json> ParseReport(const std::string& text);

// INVALID_ARGUMENT "report: " and the member that is wrong.
absl::StatusOr<Identification> ReadIdentification(const nlohmann::ordered_json& document);
absl::StatusOr<Loop> ReadLoop(const nlohmann::ordered_json& document);
absl::StatusOr<CalibrationReport> ReadCalibrationReport(const nlohmann::ordered_json& document);

template <typename Report>
absl::StatusOr<Report> ReadReport(const nlohmann::ordered_json& document) {
  absl::StatusOr<Report> report = base::ReadMembers<Report>(document);
  if (!report.ok()) return base::Within("report", report.status());
  return report;
}

template <typename Report>
absl::StatusOr<Report> ReadReport(const std::string& text) {
  ASSIGN_OR_RETURN(const nlohmann::ordered_json document, ParseReport(text));
  return ReadReport<Report>(document);
}

}  // namespace axiscal::reports

#endif  // AXISCAL_CORE_REPORTS_REPORT_JSON_H_
