// The sheet of a calibration: machine, instruments, errors in the terms of ISO 230-1 with expanded uncertainties, what
// the readings do not tell, before and after. It fits on one page of A4: what would not is cut, and says so.
#ifndef AXISCAL_CORE_SHEET_CALIBRATION_SHEET_H_
#define AXISCAL_CORE_SHEET_CALIBRATION_SHEET_H_

#include <optional>
#include <string>
#include <vector>

#include "core/machine/machine.h"
#include "core/records/calibration.h"
#include "core/records/session.h"
#include "core/reports/calibration.h"
#include "core/sheet/sheet.h"

namespace axiscal::sheet {

// What is not known is left out, and the sheet says "not stated".
struct CalibrationToPrint {
  reports::CalibrationReport report;
  std::optional<machine::Machine> machine;           // as it was described for this calibration
  std::optional<records::CalibrationRecord> stored;  // of one that is stored
  std::vector<records::SessionRecord> sessions;      // name, instrument, header and time are read
};

Sheet CalibrationSheet(const CalibrationToPrint& calibration, Language language);

}  // namespace axiscal::sheet

#endif  // AXISCAL_CORE_SHEET_CALIBRATION_SHEET_H_
