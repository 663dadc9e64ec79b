// One SQLite connection with its pragmas.
#ifndef AXISCAL_SERVER_STORAGE_SQLITE_CONNECTION_H_
#define AXISCAL_SERVER_STORAGE_SQLITE_CONNECTION_H_

#include <sqlite3.h>

#include <memory>
#include <string>

#include "server/storage/connection.h"

namespace axiscal::storage {

class SqliteConnection final : public Connection {
 public:
  // kWrite makes the file when it is missing and puts it into WAL mode with synchronous=FULL.
  static absl::StatusOr<std::unique_ptr<SqliteConnection>> Open(const std::string& path, Access access);
  ~SqliteConnection() override;

  absl::StatusOr<bool> HasTable(const std::string& name) override;
  absl::Status Execute(const std::string& script) override;
  absl::Status Begin(Access access) override { return Run(access == Access::kWrite ? "BEGIN IMMEDIATE" : "BEGIN"); }
  // SQLite rolls back by itself where the disk is full or fails.
  bool in_transaction() const override { return sqlite3_get_autocommit(db_) == 0; }
  int64_t changed_rows() const override { return sqlite3_changes64(db_); }

  // Statements wait some seconds for a lock that another process holds; so it is from the start.
  void WaitForLocks();
  sqlite3* handle() { return db_; }

 private:
  explicit SqliteConnection(sqlite3* db) : db_(db) {}
  // Behind RETURNING it would look for rows that name the new one before it was there.
  std::string AskingForId(const std::string& sql) const override { return sql; }
  std::optional<int64_t> last_id() const override {
    return changed_rows() == 0 ? std::nullopt : std::optional<int64_t>(sqlite3_last_insert_rowid(db_));
  }
  absl::StatusOr<std::unique_ptr<Prepared>> Compile(const std::string& sql) override;

  sqlite3* const db_;
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_SQLITE_CONNECTION_H_
