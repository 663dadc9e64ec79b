// A connection of the store to its database. The store's SQL is written once, against this; an engine is one
// implementation of Connection and Prepared (sqlite_connection.h). One thread at a time.
#ifndef AXISCAL_SERVER_STORAGE_CONNECTION_H_
#define AXISCAL_SERVER_STORAGE_CONNECTION_H_

#include <memory>
#include <optional>
#include <string>
#include <unordered_map>

#include "core/base/ids.h"
#include "server/storage/statement.h"

namespace axiscal::storage {

enum class Access { kWrite, kReadOnly };

class Connection {
 public:
  Connection() = default;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  virtual ~Connection() = default;

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
  // Runs an INSERT of one row into a table that numbers its rows: the number it was given, its id. Nothing where there
  // was such a row and the statement leaves that as it is (ON CONFLICT DO NOTHING).
  template <typename... Parameters>
  absl::StatusOr<std::optional<int64_t>> InsertIfNew(const std::string& sql, const Parameters&... parameters) {
    ASSIGN_OR_RETURN(Statement row, Ask(AskingForId(sql), parameters...));
    ASSIGN_OR_RETURN(const bool has_row, row.Step());
    if (!has_row) return last_id();
    const int64_t id = row.Int(0);
    RETURN_IF_ERROR(row.Step().status());
    return id;
  }
  // The same of a row that must be new.
  template <typename... Parameters>
  absl::StatusOr<int64_t> Insert(const std::string& sql, const Parameters&... parameters) {
    ASSIGN_OR_RETURN(const std::optional<int64_t> id, InsertIfNew(sql, parameters...));
    return id.value();
  }
  virtual absl::StatusOr<bool> HasTable(const std::string& name) = 0;
  // Several statements without parameters.
  virtual absl::Status Execute(const std::string& script) = 0;

  // Begins a transaction (transaction.h).
  //   kWrite: takes the write lock now; a read that turned into a write later could fail at once.
  //   kReadOnly: several reads of one state.
  virtual absl::Status Begin(Access access) = 0;
  // Commits without waiting for the disk, where the engine can: after a crash of its server the last half second of
  // such transactions may be gone, each as a whole. A commit that waits takes those before it with it to the disk.
  virtual absl::Status CommitSoon() { return Run("COMMIT"); }
  // False after the engine has rolled a transaction back by itself.
  virtual bool in_transaction() const = 0;
  virtual int64_t changed_rows() const = 0;  // by the last INSERT, UPDATE or DELETE
  // The transaction failed for another's sake (a deadlock): nothing of it stands, and the same again may succeed.
  virtual bool was_undone() const { return false; }

  // Whether the chunks of this session were taken out of the store by whoever looks after it, with those of its
  // neighbours and such that they can come back. Of a file: never.
  virtual absl::StatusOr<bool> HasDetached(SessionId) { return false; }

  // ---- several processes on one store
  // Whether others may have it open at this moment. Of a file: never.
  virtual bool has_others() const { return false; }
  // The store is open and whole: lets others in that wait for this.
  virtual absl::Status LetOthersIn() { return absl::OkStatus(); }
  // Tells all processes, once the transaction is committed, what has changed: a word that Engine::Listen() gives.
  virtual absl::Status Tell(const std::string&) { return absl::OkStatus(); }

 protected:
  // How an INSERT asks for the id of its row: so that it gives a row with it, or as it is where last_id() tells it.
  virtual std::string AskingForId(const std::string& sql) const = 0;
  // Of an INSERT that gave no row; nothing where it made none.
  virtual std::optional<int64_t> last_id() const = 0;
  virtual absl::StatusOr<std::unique_ptr<Prepared>> Compile(const std::string& sql) = 0;
  // Before an engine closes what its statements belong to.
  void ForgetStatements() { idle_.clear(); }

 private:
  absl::StatusOr<Statement> Prepare(const std::string& sql);

  std::unordered_map<std::string, Statement::Idle> idle_;  // by their SQL: prepared and not in use
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_CONNECTION_H_
