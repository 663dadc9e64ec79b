// Admin.Diagnose: what is well on the server's side, what is not, and what to do about it.
#ifndef AXISCAL_SERVER_HANDLERS_DIAGNOSE_H_
#define AXISCAL_SERVER_HANDLERS_DIAGNOSE_H_

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "axiscal/v1/admin_service.pb.h"
#include "core/records/diagnosis.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

// What is looked at. What could not be asked is absent.
struct ServerFacts {
  base::UtcTime now;
  std::string version;
  int schema_version = 0;
  absl::Status read, write;  // of the store
  bool has_file = true;      // the store is a file here, and not a server's database
  std::optional<int64_t> disk_free_bytes, database_bytes;
  std::vector<std::pair<std::string, base::UtcTime>> certificates;  // file, and when it ends
  std::vector<std::string> open_files;  // that everybody on the machine may read: "FILE (0644)"
  std::optional<int64_t> descriptors, most_descriptors;
  std::string backup_folder;   // empty: none
  std::string backup_problem;  // why nothing can be written there; empty: it can
  std::optional<base::UtcTime> last_backup;
  std::optional<std::vector<records::CellRecord>> cells;
  std::optional<int64_t> queued_jobs;
  std::chrono::microseconds oldest_queued{0};
  std::vector<std::pair<std::string, int64_t>> dead_letters;  // webhooks that have some, and how many
  bool is_draining = false;
};
// In the order in which they are shown; each thing once, well or not.
std::vector<records::Finding> FindingsOf(const ServerFacts& facts);

absl::StatusOr<v1::DiagnoseResponse> Diagnose(Core& core, const Call& call, const v1::DiagnoseRequest& request);

absl::StatusOr<v1::SetLogLevelResponse> SetLogLevel(Core& core, const Call& call,
                                                    const v1::SetLogLevelRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_DIAGNOSE_H_
