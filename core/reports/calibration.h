// The report of a calibration: of the identification or the loop that made it.
#ifndef AXISCAL_CORE_REPORTS_CALIBRATION_H_
#define AXISCAL_CORE_REPORTS_CALIBRATION_H_

#include <variant>

#include "core/reports/identification.h"
#include "core/reports/loop.h"

namespace axiscal::reports {

using CalibrationReport = std::variant<Identification, Loop>;

// A report with a verdict is the loop's. INVALID_ARGUMENT naming line and column, or the member that is wrong.
absl::StatusOr<CalibrationReport> ReadCalibrationReport(const std::string& text);

const Fitted& FittedOf(const CalibrationReport& report);

}  // namespace axiscal::reports

#endif  // AXISCAL_CORE_REPORTS_CALIBRATION_H_
