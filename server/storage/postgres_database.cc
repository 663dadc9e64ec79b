#include "server/storage/postgres_database.h"

#include <utility>

#include "server/storage/copy_store.h"
#include "server/storage/postgres_connection.h"
#include "server/storage/postgres_listener.h"
#include "server/storage/postgres_migrate.h"
#include "server/storage/postgres_url.h"
#include "server/storage/refusal.h"
#include "server/storage/sql_store.h"

namespace axiscal::storage {
namespace {

absl::Status CheckStillRuns(Connection& connection) { return CheckPostgresSchema(connection, PostgresMigrations()); }

class PostgresEngine final : public Engine {
 public:
  explicit PostgresEngine(std::string url) : url_(std::move(url)) {}

  absl::StatusOr<std::unique_ptr<Connection>> OpenReader() override {
    ASSIGN_OR_RETURN(std::unique_ptr<PostgresConnection> connection, PostgresConnection::Open(url_, Access::kReadOnly));
    RETURN_IF_ERROR(CheckStillRuns(*connection));
    connection->CheckAfterReconnect(CheckStillRuns);
    return connection;
  }
  absl::StatusOr<std::unique_ptr<Connection>> OpenBesideWriter() override {
    ASSIGN_OR_RETURN(std::unique_ptr<PostgresConnection> connection,
                     PostgresConnection::Open(url_, Access::kWrite, Hold::kBeside));
    RETURN_IF_ERROR(CheckStillRuns(*connection));
    connection->CheckAfterReconnect(CheckStillRuns);
    return connection;
  }
  // Its disk is the server's business; a full one is DISK_FULL.
  absl::Status CheckRoom() const override { return absl::OkStatus(); }
  void Between() override {}
  absl::StatusOr<BackupResult> Backup(const std::string&, const std::function<absl::Status()>&) override {
    return FailedPrecondition("the store is a database of PostgreSQL: pg_dump makes its backups",
                              "STORE_HAS_OTHER_BACKUPS");
  }
  int schema_version() const override { return PostgresMigrations().back().version; }
  bool is_shared() const override { return true; }
  std::unique_ptr<Listener> Listen(std::function<void(const std::string&)> heard) override {
    return std::make_unique<PostgresListener>(url_, std::move(heard));
  }

 private:
  const std::string url_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Database>> OpenPostgres(const PostgresOptions& options) {
  const auto open = [&]() -> absl::StatusOr<std::unique_ptr<Database>> {
    ASSIGN_OR_RETURN(std::unique_ptr<PostgresConnection> connection,
                     PostgresConnection::Open(options.url, Access::kWrite, Hold::kShared));
    RETURN_IF_ERROR(MigratePostgres(*connection, PostgresMigrations(), options.clock->UtcNow(), NewerSchema::kRunOn));
    RETURN_IF_ERROR(RefuseUnfinishedCopy(*connection));
    connection->CheckAfterReconnect(CheckStillRuns);
    return SqlStore::Open({options.rescued, options.damaged, options.clock},
                          std::make_unique<PostgresEngine>(options.url), std::move(connection));
  };
  absl::StatusOr<std::unique_ptr<Database>> database = open();
  if (!database.ok()) return base::Within(WithoutPassword(options.url), database.status());
  return database;
}

}  // namespace axiscal::storage
