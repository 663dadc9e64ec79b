#include "server/storage/sqlite_database.h"

#include <sys/statvfs.h>

#include <csignal>
#include <limits>

#include "core/base/error_detail.h"
#include "server/storage/backup.h"
#include "server/storage/copy_store.h"
#include "server/storage/file_lock.h"
#include "server/storage/migrate.h"
#include "server/storage/sql_store.h"
#include "server/storage/sqlite_connection.h"
#include "server/storage/sqlite_log.h"

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

class SqliteEngine final : public Engine {
 public:
  // `connection`: the one that writes.
  SqliteEngine(const SqliteOptions& options, FileLock lock, SqliteConnection& connection)
      : options_(options), lock_(std::move(lock)), log_(connection) {}

  absl::StatusOr<std::unique_ptr<Connection>> OpenReader() override {
    return SqliteConnection::Open(options_.path, Access::kReadOnly);
  }
  absl::Status CheckRoom() const override {
    const int64_t free_bytes = options_.free_bytes();
    if (free_bytes >= options_.min_free_bytes) return absl::OkStatus();
    return base::Error(absl::StatusCode::kResourceExhausted,
                       absl::StrCat(options_.path, ": ", free_bytes, " bytes free on the disk, at least ",
                                    options_.min_free_bytes, " must stay free"),
                       {"DISK_LOW", {{"free_bytes", std::to_string(free_bytes)}}});
  }
  void Between() override { log_.Limit(); }
  absl::StatusOr<BackupResult> Backup(const std::string& path, const std::function<absl::Status()>& go_on) override {
    auto reader = std::make_unique<SqliteLog::LongReader>(log_);
    return CopyStore(options_.path, path, go_on, [&] {
      // What was written meanwhile would hold up the commit after which the writer merges it. What fails here, it does.
      static_cast<void>(MergeBeside(options_.path));
      reader.reset();
    });
  }
  int schema_version() const override { return static_cast<int>(EmbeddedMigrations().size()); }

 private:
  const SqliteOptions options_;
  const FileLock lock_;
  SqliteLog log_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Database>> OpenSqlite(const SqliteOptions& given) {
  SqliteOptions options = given;
  if (!options.free_bytes) options.free_bytes = [path = given.path] { return FreeBytes(path); };
  IgnoreFileSizeSignal();
  ASSIGN_OR_RETURN(FileLock lock, LockStoreFile(options.path, EmbeddedMigrations()));
  options.path = lock.path();
  ASSIGN_OR_RETURN(std::unique_ptr<SqliteConnection> connection, SqliteConnection::Open(options.path, Access::kWrite));
  RETURN_IF_ERROR(base::Within(options.path, Migrate(*connection, EmbeddedMigrations(), options.clock->UtcNow())));
  RETURN_IF_ERROR(base::Within(options.path, RefuseUnfinishedCopy(*connection)));
  auto engine = std::make_unique<SqliteEngine>(options, std::move(lock), *connection);
  absl::StatusOr<std::unique_ptr<Database>> database =
      SqlStore::Open({options.rescued, options.damaged, options.clock}, std::move(engine), std::move(connection));
  if (!database.ok()) return base::Within(options.path, database.status());
  return database;
}

}  // namespace axiscal::storage
