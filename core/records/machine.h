// A machine as the service knows it: its description, in revisions.
#ifndef AXISCAL_CORE_RECORDS_MACHINE_H_
#define AXISCAL_CORE_RECORDS_MACHINE_H_

#include <cstdint>
#include <optional>
#include <string>

#include "core/base/clock.h"
#include "core/base/ids.h"

namespace axiscal::records {

struct MachineRecord {
  MachineId id;
  int64_t revision = 0;          // 1, 2, ...: the etag; every description stays readable by its revision
  std::string description_json;  // machine.json of this revision
  base::UtcTime created_at, updated_at;
  std::optional<base::UtcTime> deleted_at;
};

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_MACHINE_H_
