// A PostgreSQL server of the test's own: an unprivileged user's, in a folder that goes with it, reached by a socket
// there.
#ifndef AXISCAL_SERVER_STORAGE_TESTING_POSTGRES_SERVER_H_
#define AXISCAL_SERVER_STORAGE_TESTING_POSTGRES_SERVER_H_

#include <sys/types.h>

#include <memory>
#include <string>

#include "core/base/status.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {

class PostgresServer final : public TestServer {
 public:
  // Debian's newest; NOT_FOUND where none is installed. Its files are not synced: what it keeps outlives a kill of the
  // server, not of the machine.
  static absl::StatusOr<std::unique_ptr<PostgresServer>> Start();
  // Kills it.
  ~PostgresServer() override;
  PostgresServer(const PostgresServer&) = delete;

  std::string MakeDatabase(bool has_schema) override;
  void DropDatabase(const std::string& url) override;

 private:
  PostgresServer(std::string folder, pid_t process) : folder_(std::move(folder)), process_(process) {}
  std::string UrlOf(const std::string& database) const;
  absl::Status WaitUntilUp() const;

  const std::string folder_;
  const pid_t process_;
  int databases_ = 0;
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_TESTING_POSTGRES_SERVER_H_
