// What a store asks of the database system below it, beside connections that take its SQL (connection.h).
#ifndef AXISCAL_SERVER_STORAGE_ENGINE_H_
#define AXISCAL_SERVER_STORAGE_ENGINE_H_

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// While it lives, what other processes tell is heard (Engine::Listen()).
class Listener {
 public:
  virtual ~Listener() = default;
};
// A word that was missed is made up for within so long.
inline constexpr std::chrono::seconds kNewsWithin(5);

// Safe from any thread, but Between(). Outlives all connections.
class Engine {
 public:
  Engine() = default;
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;
  virtual ~Engine() = default;

  virtual absl::StatusOr<std::unique_ptr<Connection>> OpenReader() = 0;
  // One whose transactions that write do not wait for those of the store's writer, nor it for them: for statements that
  // lock the rows they change. Nothing where an engine has one writer only. Once others were let in.
  virtual absl::StatusOr<std::unique_ptr<Connection>> OpenBesideWriter() { return nullptr; }
  // RESOURCE_EXHAUSTED DISK_LOW where room is so low that what grows is refused.
  virtual absl::Status CheckRoom() const = 0;
  // Between groups of writes, on the writer's thread.
  virtual void Between() = 0;
  // Database::Backup().
  virtual absl::StatusOr<BackupResult> Backup(const std::string& path, const std::function<absl::Status()>& go_on) = 0;
  virtual int schema_version() const = 0;

  // Whether several processes may have the store open.
  virtual bool is_shared() const { return false; }
  // Calls `heard`, on a thread of its own, with each word that any process has told (Connection::Tell()), and with ""
  // where some may have been missed, at least every kNewsWithin. Only where the store is shared.
  virtual std::unique_ptr<Listener> Listen(std::function<void(const std::string&)>) { return nullptr; }
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_ENGINE_H_
