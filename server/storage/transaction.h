// A transaction, or a savepoint inside one, that rolls back unless Commit() was called and succeeded.
#ifndef AXISCAL_SERVER_STORAGE_TRANSACTION_H_
#define AXISCAL_SERVER_STORAGE_TRANSACTION_H_

#include <utility>

#include "server/storage/connection.h"

namespace axiscal::storage {

// One savepoint at a time. An engine that is far away tells them apart from other statements.
inline constexpr char kSavepoint[] = "SAVEPOINT one", kRelease[] = "RELEASE one";

class Transaction {
 public:
  // As Connection::Begin() says.
  static absl::StatusOr<Transaction> BeginWrite(Connection& connection) { return Begin(connection, Access::kWrite); }
  static absl::StatusOr<Transaction> BeginRead(Connection& connection) { return Begin(connection, Access::kReadOnly); }

  Transaction(Transaction&& other) noexcept : connection_(std::exchange(other.connection_, nullptr)) {}
  Transaction& operator=(Transaction&&) = delete;
  ~Transaction();
  absl::Status Commit();
  absl::Status CommitSoon();  // as Connection::CommitSoon()

 private:
  explicit Transaction(Connection& connection) : connection_(&connection) {}
  static absl::StatusOr<Transaction> Begin(Connection& connection, Access access);

  Connection* connection_;  // null: ended
};

class Savepoint {
 public:
  static absl::StatusOr<Savepoint> Begin(Connection& connection);
  Savepoint(Savepoint&& other) noexcept : connection_(std::exchange(other.connection_, nullptr)) {}
  Savepoint& operator=(Savepoint&&) = delete;
  ~Savepoint();
  absl::Status Commit();

 private:
  explicit Savepoint(Connection& connection) : connection_(&connection) {}

  Connection* connection_;  // null: ended
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_TRANSACTION_H_
