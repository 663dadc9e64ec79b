// One connection to PostgreSQL, by libpq. libpq and not libpqxx: Debian's libpqxx 6.4 reports errors by exceptions,
// which this product does not throw or catch, gives values as text (bytes at twice their size), and lacks libpq's
// pipelines.
//
// Values travel in binary: INTEGER is bigint, REAL double precision, TEXT text, BLOB bytea; a truth value is read as 0
// or 1. A statement's rows are all fetched by its first step.
#ifndef AXISCAL_SERVER_STORAGE_POSTGRES_CONNECTION_H_
#define AXISCAL_SERVER_STORAGE_POSTGRES_CONNECTION_H_

#include <memory>
#include <string>

#include "server/storage/connection.h"

// libpq's PGconn: its header is for the sources alone, so that who includes this one needs no path to it.
struct pg_conn;

namespace axiscal::storage {

class PostgresConnection final : public Connection {
 public:
  // `url`: what libpq takes, "postgresql://user@host:port/database?..." or "host=... dbname=...".
  //   kWrite: commits wait for the disk whatever the server's default says, and the store is this connection's alone:
  //   UNAVAILABLE STORE_LOCKED where another has it.
  static absl::StatusOr<std::unique_ptr<PostgresConnection>> Open(const std::string& url, Access access);
  ~PostgresConnection() override;

  absl::StatusOr<bool> HasTable(const std::string& name) override;
  absl::Status Execute(const std::string& script) override;
  // Connects again where the connection was lost meanwhile.
  absl::Status Begin(Access access) override;
  bool in_transaction() const override;
  int64_t changed_rows() const override { return changed_rows_; }

 private:
  class Statements;

  PostgresConnection(std::string url, Access access, pg_conn* connection)
      : url_(std::move(url)), access_(access), connection_(connection) {}
  std::string AskingForId(const std::string& sql) const override { return sql + " RETURNING id"; }
  std::optional<int64_t> last_id() const override { return std::nullopt; }
  absl::StatusOr<std::unique_ptr<Prepared>> Compile(const std::string& sql) override;
  absl::Status Settle();
  absl::Status Reconnect();

  const std::string url_;
  const Access access_;
  pg_conn* const connection_;
  int64_t changed_rows_ = 0;
  // What has a name on the server: a new connection knows none of them.
  int64_t connections_ = 1, statements_ = 0;
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_POSTGRES_CONNECTION_H_
