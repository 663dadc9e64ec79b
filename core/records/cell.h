// A cell beside a machine, as it says itself how it stands (docs/cell.md).
#ifndef AXISCAL_CORE_RECORDS_CELL_H_
#define AXISCAL_CORE_RECORDS_CELL_H_

#include <chrono>
#include <cstdint>
#include <string>

#include "core/base/clock.h"
#include "core/base/ids.h"

namespace axiscal::records {

// Of one machine that it serves.
struct CellReport {
  MachineId machine;
  std::string name;                                              // the cell's
  std::string version = {};                                      // of its software
  std::chrono::seconds silent_after = std::chrono::minutes(15);  // not heard for so long it is silent
  std::string problem = {};                                      // what wants a person there; empty: nothing
  int64_t waiting_files = 0, waiting_bytes = 0;                  // in its spool
  int64_t quarantined_files = 0, quarantined_bytes = 0;
  int64_t max_bytes = 0;  // that the spool may hold
};

struct CellRecord {
  int64_t id = 0;     // pages are in order of it
  CellReport report;  // the newest
  std::string reported_by;
  base::UtcTime reported_at;             // by the server's clock
  std::chrono::microseconds silence{0};  // since then, without the time that no server had the database
  bool is_silent() const { return silence > report.silent_after; }
};

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_CELL_H_
