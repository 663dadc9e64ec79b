#include "server/storage/sqlite_database.h"

#include <sys/statvfs.h>

#include <algorithm>
#include <csignal>
#include <limits>

#include "server/storage/seal.h"
#include "server/storage/sqlite_store.h"

namespace axiscal::storage {
namespace {

void IgnoreFileSizeSignal() {
  struct sigaction present;
  if (sigaction(SIGXFSZ, nullptr, &present) == 0 && present.sa_handler == SIG_DFL) std::signal(SIGXFSZ, SIG_IGN);
}

int64_t FreeBytes(const std::string& path) {
  struct statvfs info;
  // A disk that does not answer is not called full: the write itself will tell.
  if (statvfs(path.c_str(), &info) != 0) return std::numeric_limits<int64_t>::max();
  return static_cast<int64_t>(info.f_bavail) * static_cast<int64_t>(info.f_frsize);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Database>> OpenSqlite(const SqliteOptions& given) {
  SqliteOptions options = given;
  if (!options.free_bytes) options.free_bytes = [path = given.path] { return FreeBytes(path); };
  IgnoreFileSizeSignal();
  ASSIGN_OR_RETURN(FileLock lock, FileLock::Take(options.path));
  options.path = lock.path();
  RETURN_IF_ERROR(CheckFile(options.path, EmbeddedMigrations()));
  ASSIGN_OR_RETURN(std::unique_ptr<Connection> connection, Connection::Open(options.path, Access::kWrite));
  RETURN_IF_ERROR(base::Within(options.path, Migrate(*connection, EmbeddedMigrations(), options.clock->UtcNow())));
  RETURN_IF_ERROR(base::Within(options.path, SealOldRows(*connection)));
  ASSIGN_OR_RETURN(const std::chrono::microseconds up, ReadUpTime(*connection));
  auto database = std::make_unique<SqliteStore>(options, up, std::move(lock), std::move(connection));
  ASSIGN_OR_RETURN(const std::vector<JobRecord> rescued, database->RescueJobs());
  if (options.rescued) std::for_each(rescued.begin(), rescued.end(), options.rescued);
  return database;
}

}  // namespace axiscal::storage
