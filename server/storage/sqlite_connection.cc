#include "server/storage/sqlite_connection.h"

#include <cerrno>

#include "core/base/utf8.h"
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

class SqlitePrepared final : public Prepared {
 public:
  explicit SqlitePrepared(sqlite3_stmt* statement) : statement_(statement) {}
  ~SqlitePrepared() override { sqlite3_finalize(statement_); }

  absl::StatusOr<bool> Step() override {
    errno = 0;  // SqliteError() tells a full disk by it
    const int code = sqlite3_step(statement_);
    if (code == SQLITE_ROW) return true;
    if (code == SQLITE_DONE) return false;
    return SqliteError(sqlite3_db_handle(statement_), sqlite3_sql(statement_));
  }
  void Reset() override {
    sqlite3_reset(statement_);
    sqlite3_clear_bindings(statement_);
  }

  bool IsNull(int column) const override { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
  int64_t Int(int column) const override { return sqlite3_column_int64(statement_, column); }
  double Real(int column) const override { return sqlite3_column_double(statement_, column); }
  std::string Text(int column) const override {
    const void* bytes = sqlite3_column_blob(statement_, column);
    const int size = sqlite3_column_bytes(statement_, column);
    std::string text = size > 0 ? std::string(static_cast<const char*>(bytes), size) : std::string();
    // Earlier versions let callers store what is no UTF-8; one such text in an answer would spoil all of it.
    return sqlite3_column_type(statement_, column) == SQLITE_TEXT ? base::ToUtf8(std::move(text)) : text;
  }

  void BindInt(int index, int64_t number) override { sqlite3_bind_int64(statement_, index, number); }
  void BindReal(int index, double number) override { sqlite3_bind_double(statement_, index, number); }
  void BindText(int index, const std::string& text) override {
    sqlite3_bind_text64(statement_, index, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
  }
  void BindBlob(int index, Blob blob) override {
    sqlite3_bind_blob64(statement_, index, blob.bytes.empty() ? "" : blob.bytes.data(), blob.bytes.size(),
                        SQLITE_STATIC);
  }
  void BindNull(int index, ValueType) override { sqlite3_bind_null(statement_, index); }

 private:
  sqlite3_stmt* const statement_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<SqliteConnection>> SqliteConnection::Open(const std::string& path, Access access) {
  const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX | (access == Access::kWrite ? SQLITE_OPEN_CREATE : 0);
  sqlite3* db = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &db, flags, nullptr);
  std::unique_ptr<SqliteConnection> connection(new SqliteConnection(db));
  if (code != SQLITE_OK || AddRowChecksum(db) != SQLITE_OK) return SqliteError(db, path);
  connection->WaitForLocks();
  if (!connection->Execute(access == Access::kWrite ? kWritePragmas : kReadPragmas).ok()) return SqliteError(db, path);
  return connection;
}

SqliteConnection::~SqliteConnection() {
  ForgetStatements();
  sqlite3_close(db_);
}

void SqliteConnection::WaitForLocks() { sqlite3_busy_timeout(db_, kBusyTimeoutMs); }

absl::StatusOr<std::unique_ptr<Prepared>> SqliteConnection::Compile(const std::string& sql) {
  sqlite3_stmt* statement = nullptr;
  const int code =
      sqlite3_prepare_v3(db_, sql.data(), static_cast<int>(sql.size()), SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
  if (code != SQLITE_OK) return SqliteError(db_, sql);
  return std::make_unique<SqlitePrepared>(statement);
}

absl::StatusOr<bool> SqliteConnection::HasTable(const std::string& name) {
  ASSIGN_OR_RETURN(Statement row, Ask("SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = ?1", name));
  return row.Step();
}

absl::Status SqliteConnection::Execute(const std::string& script) {
  if (sqlite3_exec(db_, script.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) return SqliteError(db_, script);
  return absl::OkStatus();
}

}  // namespace axiscal::storage
