// One connection to PostgreSQL, by libpq. libpq and not libpqxx: Debian's libpqxx 6.4 reports errors by exceptions,
// which this product does not throw or catch, gives values as text (bytes at twice their size), and lacks libpq's
// pipelines.
//
// Values travel in binary: INTEGER is bigint, REAL double precision, TEXT text, BLOB bytea; a truth value is read as 0
// or 1. A statement's rows are all fetched by its first step.
#ifndef AXISCAL_SERVER_STORAGE_POSTGRES_CONNECTION_H_
#define AXISCAL_SERVER_STORAGE_POSTGRES_CONNECTION_H_

#include <functional>
#include <memory>
#include <string>

#include "server/storage/connection.h"

// libpq's PGconn: its header is for the sources alone, so that who includes this one needs no path to it.
struct pg_conn;

namespace axiscal::storage {

// Where processes tell each other what has changed (LISTEN, NOTIFY).
inline constexpr char kNewsChannel[] = "axiscal";

// A new connection, as PQconnectdb() gives it. A server that does not answer is noticed within half a minute.
pg_conn* ConnectToPostgres(const std::string& url);

// What a connection that writes wants of the store, by advisory locks of the database.
enum class Hold {
  kAlone,   // nobody else has it for as long as this one lives
  kShared,  // others of this kind have it, too; each transaction that writes waits until those of all others are over
  kBeside,  // another one that this process has open as kShared, and let others in; its transactions wait for nobody's
};

class PostgresConnection final : public Connection {
 public:
  // `url`: what libpq takes, "postgresql://user@host:port/database?..." or "host=... dbname=...".
  //   kWrite: commits wait for the disk whatever the server's default says, and the store is held (`hold`): UNAVAILABLE
  //   STORE_LOCKED where it is not to be had. Whoever shares it and finds nobody else there keeps others off until
  //   LetOthersIn().
  static absl::StatusOr<std::unique_ptr<PostgresConnection>> Open(const std::string& url, Access access,
                                                                  Hold hold = Hold::kAlone);
  ~PostgresConnection() override;

  // Asked each time that it has connected again, before anything else is: what it refuses is the answer of whoever
  // begins a transaction, until it refuses no more. The store is not held meanwhile.
  void CheckAfterReconnect(std::function<absl::Status(Connection&)> check) { check_ = std::move(check); }

  absl::StatusOr<bool> HasTable(const std::string& name) override;
  absl::Status Execute(const std::string& script) override;
  // Connects again where the connection was lost meanwhile.
  absl::Status Begin(Access access) override;
  absl::Status CommitSoon() override;
  bool in_transaction() const override;
  int64_t changed_rows() const override { return changed_rows_; }
  bool was_undone() const override { return was_undone_; }
  absl::StatusOr<bool> HasDetached(SessionId id) override;
  bool has_others() const override { return hold_ != Hold::kAlone && !is_alone_; }
  absl::Status LetOthersIn() override;
  absl::Status Tell(const std::string& what) override;

 private:
  class Statements;

  PostgresConnection(Access access, Hold hold, pg_conn* connection)
      : access_(access), hold_(hold), connection_(connection) {}
  std::string AskingForId(const std::string& sql) const override { return sql + " RETURNING id"; }
  std::optional<int64_t> last_id() const override { return std::nullopt; }
  absl::StatusOr<std::unique_ptr<Prepared>> Compile(const std::string& sql) override;
  // Before `sql` is run: sends a RELEASE that waits for company. Whether `sql` has been done with it.
  absl::StatusOr<bool> SendRelease(const std::string& sql);
  absl::Status Settle(bool is_first);
  absl::Status Reconnect();
  // UNAVAILABLE STORE_LOCKED.
  absl::Status TakeStore(bool is_first);
  // Asks a function that takes or leaves an advisory lock ("pg_try_advisory_lock") for the store: what it says.
  absl::StatusOr<bool> AskLock(const std::string& function);
  // As StatusOf(), and remembers whether it was for another's sake.
  absl::Status Noted(const char* sqlstate, absl::Status status);

  const Access access_;
  const Hold hold_;
  pg_conn* const connection_;
  std::function<absl::Status(Connection&)> check_;  // may be empty
  bool is_settled_ = true;                          // since it connected last
  int64_t changed_rows_ = 0;
  bool was_undone_ = false;
  // A savepoint is over, which the server has not been told: it goes with the next one, or with the end of the
  // transaction, as each answer costs a way there and back.
  bool owes_release_ = false;
  bool is_alone_ = false;  // shares the store, but keeps others off still
  // What has a name on the server: a new connection knows none of them.
  int64_t connections_ = 1, statements_ = 0;
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_POSTGRES_CONNECTION_H_
