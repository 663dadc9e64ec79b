// Read-only connections, each used by one thread at a time and kept for the next.
#ifndef AXISCAL_SERVER_STORAGE_READERS_H_
#define AXISCAL_SERVER_STORAGE_READERS_H_

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/mutex.h"
#include "server/storage/transaction.h"

namespace axiscal::storage {

// Safe from any thread.
class Readers {
 public:
  using Open = std::function<absl::StatusOr<std::unique_ptr<Connection>>()>;
  explicit Readers(Open open) : open_(std::move(open)) {}

  // Runs `read(Connection&)` (StatusOr<T>) on one consistent state of the database.
  template <typename Read>
  auto Run(const Read& read) -> decltype(read(std::declval<Connection&>())) {
    absl::StatusOr<std::unique_ptr<Connection>> connection = Borrow();
    if (!connection.ok()) return connection.status();
    auto result = [&]() -> decltype(read(**connection)) {
      ASSIGN_OR_RETURN(const Transaction snapshot, Transaction::BeginRead(**connection));
      return read(**connection);
    }();
    GiveBack(*std::move(connection));
    return result;
  }

 private:
  absl::StatusOr<std::unique_ptr<Connection>> Borrow();
  void GiveBack(std::unique_ptr<Connection> connection);

  const Open open_;
  base::Mutex mutex_;
  std::vector<std::unique_ptr<Connection>> idle_ AXISCAL_GUARDED_BY(mutex_);
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_READERS_H_
