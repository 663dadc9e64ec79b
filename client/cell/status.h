// How a cell stands, as its status file says it (docs/cell.md).
#ifndef AXISCAL_CLIENT_CELL_STATUS_H_
#define AXISCAL_CLIENT_CELL_STATUS_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/spool/spool.h"
#include "core/base/clock.h"

namespace axiscal::cell {

struct FolderStatus {
  std::string folder;
  int growing = 0;      // files that are not whole yet
  int without_end = 0;  // of them such as have not changed for long, but lack their last line
  int links = 0;        // symbolic links, which are not followed
  std::string problem;  // empty: none
};

struct Status {
  std::string cell, server, version;
  base::UtcTime at;
  std::string doing;  // since `doing_since`; empty: it waits for the next round
  base::UtcTime doing_since;
  std::string not_told;       // why the service does not hear how this cell stands; empty: it does
  bool is_connected = false;  // the last attempt reached the server and it answered as to one who may
  spool::Usage spool;
  int64_t max_bytes = 0;
  int64_t sent = 0, refused = 0;  // since it was started
  std::optional<base::UtcTime> last_sent_at;
  std::string last_sent;  // the file
  std::string problem;    // of sending; empty: none
  bool is_later = false;  // it is that the server is not there or has no room now
  std::vector<FolderStatus> folders;
  bool looks_on = false;  // whole files are left for the next round
  // What a person has to do something about, in words; empty: nothing.
  std::vector<std::string> alarms;
};

std::string WriteStatus(const Status& status);

}  // namespace axiscal::cell

#endif  // AXISCAL_CLIENT_CELL_STATUS_H_
