#include "server/storage/connection.h"

#include "server/storage/row_checksum.h"
#include "server/storage/sqlite_error.h"

namespace axiscal::storage {
namespace {

constexpr int kBusyTimeoutMs = 5000;

// secure_delete: Debian compiles it on; overwriting dropped chunks with zeros would only cost writes.
// wal_autocheckpoint=0: the writer checkpoints itself, after it has answered.
constexpr char kWritePragmas[] =
    "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON; PRAGMA secure_delete = OFF;"
    "PRAGMA temp_store = MEMORY; PRAGMA cache_size = -16000; PRAGMA wal_autocheckpoint = 0;"
    "PRAGMA journal_size_limit = 67108864;";
constexpr char kReadPragmas[] = "PRAGMA query_only = ON; PRAGMA temp_store = MEMORY; PRAGMA cache_size = -4000;";

}  // namespace

absl::StatusOr<std::unique_ptr<Connection>> Connection::Open(const std::string& path, Access access) {
  const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX | (access == Access::kWrite ? SQLITE_OPEN_CREATE : 0);
  sqlite3* db = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &db, flags, nullptr);
  std::unique_ptr<Connection> connection(new Connection(db));
  if (code != SQLITE_OK || AddRowChecksum(db) != SQLITE_OK) return SqliteError(db, path);
  connection->WaitForLocks();
  const absl::Status set = connection->Execute(access == Access::kWrite ? kWritePragmas : kReadPragmas);
  if (!set.ok()) return base::Within(path, set);
  return connection;
}

void Connection::WaitForLocks() { sqlite3_busy_timeout(db_, kBusyTimeoutMs); }

Connection::~Connection() {
  for (auto& [sql, statements] : idle_) {
    for (sqlite3_stmt* statement : statements) sqlite3_finalize(statement);
  }
  sqlite3_close(db_);
}

absl::StatusOr<Statement> Connection::Prepare(const std::string& sql) {
  std::vector<sqlite3_stmt*>& idle = idle_[sql];
  sqlite3_stmt* statement = nullptr;
  if (idle.empty()) {
    const int code = sqlite3_prepare_v3(db_, sql.data(), static_cast<int>(sql.size()), SQLITE_PREPARE_PERSISTENT,
                                        &statement, nullptr);
    if (code != SQLITE_OK) return SqliteError(db_, sql);
  } else {
    statement = idle.back();
    idle.pop_back();
  }
  // References into an unordered_map stay valid.
  return Statement(statement, [&idle](sqlite3_stmt* used) { idle.push_back(used); });
}

absl::Status Connection::Execute(const std::string& script) {
  if (sqlite3_exec(db_, script.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) return SqliteError(db_, script);
  return absl::OkStatus();
}

}  // namespace axiscal::storage
