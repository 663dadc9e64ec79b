// What a table is asked for, and what is handed out.
#ifndef AXISCAL_CORE_COMPENSATE_TABLES_REQUEST_H_
#define AXISCAL_CORE_COMPENSATE_TABLES_REQUEST_H_

#include <optional>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/compensate/compensator.h"
#include "core/machine/error_model.h"

namespace axiscal::tables {

struct AxisRange {
  std::string axis;
  double min = 0.0, max = 0.0;  // mm or rad
};
struct AxisPosition {
  std::string axis;
  double position = 0.0;  // mm or rad
};

struct TableRequest {
  std::string format;  // a name of Formats()
  // The tool point at home, and when and at which temperature the table will be used (compensator.h).
  compensate::Options state;
  // Axes to correct: "X", or "Y(X)" for the correction of Y over the position of X where the format has such tables.
  // Empty: all that have something to correct.
  std::vector<std::string> axes;
  // Travel for which the table is made and over which its error is stated; an axis that is not named has its travel
  // limits of machine.json, or stays at the reference.
  std::vector<AxisRange> ranges;
  // Where corrections are zero, and where the other axes stand while one is sampled. Axes that are not named: 0, or the
  // nearest end of their range.
  std::vector<AxisPosition> reference;
  // The error that interpolation may leave: mm, for angles mm at a lever of 1 m.
  double tolerance_mm = 1e-4;
  std::optional<int> max_points;     // fewer than the controller's limit
  std::optional<double> resolution;  // the controller's least step, mm or deg, where that is a setting
  std::string calibration;           // what the file says of where it comes from: "mt v3"
  std::vector<std::string> notes;    // to be said in the file and in the report, one line each
};

struct MadeTable {
  std::string text;
  std::string report_json;  // reports::Table
};

// A table in the controller's format, written, read back, and evaluated on the machine's chain at poses between its
// nodes: report_json states what it leaves and what it cannot carry.
// INVALID_ARGUMENT: the machine, an error term or a field of the request, by name, value and rule.
// FAILED_PRECONDITION: nothing that the format can carry; a machine that it cannot describe; a correction beyond the
// controller's limits; a table that would leave more error than there is without it.
absl::StatusOr<MadeTable> MakeTable(const machine::Machine& machine, const machine::ErrorModel& errors,
                                    const TableRequest& request);

}  // namespace axiscal::tables

#endif  // AXISCAL_CORE_COMPENSATE_TABLES_REQUEST_H_
