#include "server/storage/transaction.h"

namespace axiscal::storage {

absl::StatusOr<Transaction> Transaction::Begin(Connection& connection, Access access) {
  RETURN_IF_ERROR(connection.Begin(access));
  return Transaction(connection);
}

Transaction::~Transaction() {
  // The engine may have rolled back by itself; then there is nothing left to do.
  if (connection_ != nullptr && connection_->in_transaction()) connection_->Run("ROLLBACK").IgnoreError();
}

absl::Status Transaction::Commit() {
  RETURN_IF_ERROR(connection_->Run("COMMIT"));
  connection_ = nullptr;
  return absl::OkStatus();
}

absl::Status Transaction::CommitSoon() {
  RETURN_IF_ERROR(connection_->CommitSoon());
  connection_ = nullptr;
  return absl::OkStatus();
}

absl::StatusOr<Savepoint> Savepoint::Begin(Connection& connection) {
  RETURN_IF_ERROR(connection.Run(kSavepoint));
  return Savepoint(connection);
}

Savepoint::~Savepoint() {
  if (connection_ == nullptr || !connection_->in_transaction()) return;
  connection_->Run("ROLLBACK TO one").IgnoreError();
  connection_->Run(kRelease).IgnoreError();
}

absl::Status Savepoint::Commit() {
  RETURN_IF_ERROR(connection_->Run(kRelease));
  connection_ = nullptr;
  return absl::OkStatus();
}

}  // namespace axiscal::storage
