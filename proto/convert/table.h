// Compensation tables on the wire.
#ifndef AXISCAL_PROTO_CONVERT_TABLE_H_
#define AXISCAL_PROTO_CONVERT_TABLE_H_

#include <optional>
#include <string>
#include <vector>

#include "axiscal/v1/tables_service.pb.h"
#include "core/base/ids.h"
#include "core/base/status.h"
#include "core/compensate/tables/format.h"
#include "core/compensate/tables/request.h"

namespace axiscal::convert {

// A table of a stored machine; `request.calibration` and `request.notes` do not travel, the server sets them.
struct TableParams {
  MachineId machine;
  std::optional<CalibrationId> calibration;
  tables::TableRequest request;
};

v1::MakeTableRequest ToProto(const TableParams& params);
// FIELD_INVALID: a missing or unreadable field, numbers that are not finite. The rules of machine and format are
// checked later.
absl::StatusOr<TableParams> FromProto(const v1::MakeTableRequest& message);

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
v1::TableFormat ToProto(const TableFormat& format);
absl::StatusOr<TableFormat> FromProto(const v1::TableFormat& message);

v1::MakeTableResponse ToProto(const MadeTable& made);
absl::StatusOr<MadeTable> FromProto(const v1::MakeTableResponse& message);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_TABLE_H_
