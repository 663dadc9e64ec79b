// Compensation tables as client and service speak of them: what is asked, what is made, which formats there are.
#ifndef AXISCAL_CORE_RECORDS_TABLE_H_
#define AXISCAL_CORE_RECORDS_TABLE_H_

#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/ids.h"
#include "core/compensate/tables/request.h"

namespace axiscal::tables {
struct Format;
}

namespace axiscal::records {

// A table of a stored machine; `request.calibration` and `request.notes` do not travel, the server sets them.
struct TableParams {
  MachineId machine;
  std::optional<CalibrationId> calibration;
  tables::TableRequest request;
};

// A table that a control may have: the newest of its format that was made of a calibration.
struct HandedTable {
  CalibrationId calibration;
  std::string format, handed_to;
  base::UtcTime handed_at;
};

struct MadeTable {
  tables::MadeTable table;
  CalibrationId calibration;
};

// What a format can hold, for people; the engine's own description is tables::Format.
struct TableFormat {
  std::string name, title, values, limits;
  std::optional<int> max_points;
  std::vector<std::string> cannot_carry;
};

TableFormat Summary(const tables::Format& format);
}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_TABLE_H_
