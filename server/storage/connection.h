// One SQLite connection with its pragmas and its prepared statements. One thread at a time.
#ifndef AXISCAL_SERVER_STORAGE_CONNECTION_H_
#define AXISCAL_SERVER_STORAGE_CONNECTION_H_

#include <sqlite3.h>

#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "server/storage/statement.h"

namespace axiscal::storage {

enum class Access { kWrite, kReadOnly };

class Connection {
 public:
  // kWrite makes the file when it is missing and puts it into WAL mode with synchronous=FULL.
  static absl::StatusOr<std::unique_ptr<Connection>> Open(const std::string& path, Access access);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // A statement with `parameters` bound to ?1, ?2 ...
  template <typename... Parameters>
  absl::StatusOr<Statement> Ask(const std::string& sql, const Parameters&... parameters) {
    absl::StatusOr<Statement> statement = Prepare(sql);
    if (!statement.ok()) return statement.status();
    int index = 0;
    (statement->Bind(++index, parameters), ...);
    return statement;
  }
  // Runs a statement that gives no rows.
  template <typename... Parameters>
  absl::Status Run(const std::string& sql, const Parameters&... parameters) {
    ASSIGN_OR_RETURN(Statement statement, Ask(sql, parameters...));
    return statement.Step().status();
  }
  // Several statements without parameters.
  absl::Status Execute(const std::string& script);

  int64_t last_insert_id() const { return sqlite3_last_insert_rowid(db_); }
  int64_t changed_rows() const { return sqlite3_changes64(db_); }
  // Statements wait some seconds for a lock that another process holds; so it is from the start.
  void WaitForLocks();
  // False after SQLite has rolled a transaction back by itself (disk full, I/O error).
  bool in_transaction() const { return sqlite3_get_autocommit(db_) == 0; }
  sqlite3* handle() { return db_; }

 private:
  explicit Connection(sqlite3* db) : db_(db) {}
  absl::StatusOr<Statement> Prepare(const std::string& sql);

  sqlite3* const db_;
  std::unordered_map<std::string, std::vector<sqlite3_stmt*>> idle_;  // prepared and not in use
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_CONNECTION_H_
