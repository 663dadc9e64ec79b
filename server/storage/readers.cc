#include "server/storage/readers.h"

namespace axiscal::storage {
namespace {

// More threads than this may read at once; their connections are closed afterwards.
constexpr size_t kMaxIdle = 16;

}  // namespace

absl::StatusOr<std::unique_ptr<Connection>> Readers::Borrow() {
  {
    const base::MutexLock lock(mutex_);
    if (!idle_.empty()) {
      std::unique_ptr<Connection> connection = std::move(idle_.back());
      idle_.pop_back();
      return connection;
    }
  }
  return open_();
}

void Readers::GiveBack(std::unique_ptr<Connection> connection) {
  const base::MutexLock lock(mutex_);
  if (idle_.size() < kMaxIdle) idle_.push_back(std::move(connection));
}

}  // namespace axiscal::storage
