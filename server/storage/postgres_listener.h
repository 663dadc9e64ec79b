// Hears what the processes on one database of PostgreSQL tell each other (Connection::Tell), on a connection and a
// thread of its own.
#ifndef AXISCAL_SERVER_STORAGE_POSTGRES_LISTENER_H_
#define AXISCAL_SERVER_STORAGE_POSTGRES_LISTENER_H_

#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "server/storage/engine.h"

// libpq's PGconn.
struct pg_conn;

namespace axiscal::storage {

class PostgresListener final : public Listener {
 public:
  // `heard` is called on the listener's thread with each word, also those of this process; with "" where some may have
  // been missed: after each connecting, and every kNewsWithin.
  PostgresListener(std::string url, std::function<void(const std::string&)> heard);
  // Returns when no call of `heard` is under way.
  ~PostgresListener() override;

 private:
  void Loop();
  // Waits for what comes, the end, or the time that is given; false: the connection is gone.
  bool Hear(pg_conn* connection);

  const std::string url_;
  const std::function<void(const std::string&)> heard_;
  int end_ = -1;  // a descriptor that can be read when this ends
  std::thread thread_;
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_POSTGRES_LISTENER_H_
