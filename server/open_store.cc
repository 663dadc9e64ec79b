#include "server/open_store.h"

#include <utility>
#include <vector>

#include "absl/strings/str_join.h"
#include "core/base/error_detail.h"
#include "server/log.h"
#include "server/log_job.h"
#include "server/storage/file_mode.h"
#include "server/storage/postgres_database.h"
#include "server/storage/postgres_url.h"
#include "server/storage/sqlite_database.h"

namespace axiscal::server {

absl::StatusOr<std::unique_ptr<storage::Database>> OpenStore(const std::string& database) {
  const auto rescued = [](const records::JobRecord& job) {
    LogJob({jobs::JobEvent::What::kLost, job, jobs::OutcomeOf(job), {}});
  };
  const auto damaged = [](const absl::Status& status) {
    const std::string reason = base::ErrorReason(status);
    Log(LogLevel::kWarning, "damaged",
        {{"reason", reason},
         {"text", std::string(status.message())},
         {"then", reason == "HISTORY_DAMAGED" ? "histories leave it out; axiscald check names all, a backup has it"
                                              : "it is being sent again, and stored anew"}});
  };
  if (storage::IsPostgresUrl(database)) {
    storage::PostgresOptions options;
    options.url = database;
    options.rescued = rescued;
    options.damaged = damaged;
    return storage::OpenPostgres(options);
  }
  storage::SqliteOptions options;
  options.path = database;
  options.rescued = rescued;
  options.damaged = damaged;
  ASSIGN_OR_RETURN(std::unique_ptr<storage::Database> store, storage::OpenSqlite(options));
  if (const std::vector<std::string> files = storage::OpenToOthers(database); !files.empty()) {
    Log(LogLevel::kWarning, "readable_by_others",
        {{"files", absl::StrJoin(files, ", ")}, {"text", "everybody on this machine may read them: chmod 600"}});
  }
  return store;
}

}  // namespace axiscal::server
