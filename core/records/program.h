// Byte strings that the service keeps, named by their content: NC programs, tables, reports.
#ifndef AXISCAL_CORE_RECORDS_PROGRAM_H_
#define AXISCAL_CORE_RECORDS_PROGRAM_H_

#include <cstdint>
#include <string>

#include "core/base/clock.h"
#include "core/base/ids.h"

namespace axiscal::records {

// Never renumber.
enum class ProgramState { kOpen = 1, kComplete = 2, kMerged = 3, kExpired = 4 };

struct ProgramRecord {
  ProgramId id;
  std::string kind;  // "nc", "table", "report"; "log", "log-template", "log-plan" of a session
  std::string name;  // file name, informative
  ProgramState state = ProgramState::kOpen;
  int64_t byte_count = 0;  // durable so far: the offset of the next part
  std::string sha256;      // hex, once complete
  std::string created_by;
  base::UtcTime created_at;
};

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_PROGRAM_H_
