#include "server/storage/postgres_connection.h"

#include <libpq-fe.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "core/base/error_detail.h"
#include "server/storage/postgres_error.h"
#include "server/storage/postgres_sql.h"
#include "server/storage/transaction.h"

namespace axiscal::storage {

struct ClearPostgresResult {
  void operator()(PGresult* result) const { PQclear(result); }
};
using PostgresResult = std::unique_ptr<PGresult, ClearPostgresResult>;

namespace {

// Numbers of types: catalog/pg_type.dat of PostgreSQL, which never change.
constexpr Oid kBool = 16, kBytea = 17, kInt8 = 20, kInt4 = 23, kText = 25, kUnknown = 705, kFloat8 = 701;
// "Axis": who has the store of a database open, for the time of the connection. "Axiw": who writes, for the time of a
// transaction.
constexpr int64_t kStoreLock = 0x41786973, kWriteLock = 0x41786977;
// Whoever starts looks for so long whether he is the only one: a process that was killed is gone for the server a
// moment later. And he waits so long for one that keeps him off: on a machine with much to do a new schema takes ten
// seconds.
constexpr std::chrono::milliseconds kAloneWithin(500), kLooksAgain(20);
constexpr char kStoreWait[] = "30s";
// A lock of anything else. And how long a transaction waits for those that write before it: 32 of a process at a time
// take milliseconds; one of a process that stands still is ended after kIdleWriter.
constexpr char kLockWait[] = "2s", kWriteWait[] = "20s", kIdleWriter[] = "10s";

std::string Message(const char* text) { return std::string(absl::StripTrailingAsciiWhitespace(text)); }

// OK, or why there is no result.
absl::Status StatusOf(PGconn* connection, const PGresult* result, const std::string& what) {
  const ExecStatusType status = PQresultStatus(result);
  if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK || status == PGRES_EMPTY_QUERY) return absl::OkStatus();
  const char* const state = PQresultErrorField(result, PG_DIAG_SQLSTATE);
  const char* const primary = PQresultErrorField(result, PG_DIAG_MESSAGE_PRIMARY);
  return PostgresError(state == nullptr ? "" : state,
                       primary == nullptr ? Message(PQerrorMessage(connection)) : Message(primary), what);
}

std::string BigEndian(uint64_t number) {
  std::string bytes(8, '\0');
  for (size_t i = 0; i < 8; ++i) bytes[i] = static_cast<char>(number >> (8 * (7 - i)));
  return bytes;
}

int64_t SignedNumber(const char* bytes, int size) {
  uint64_t number = size > 0 && (bytes[0] & 0x80) != 0 ? ~uint64_t{0} : 0;
  for (int i = 0; i < size; ++i) number = (number << 8) | static_cast<unsigned char>(bytes[i]);
  return static_cast<int64_t>(number);
}

}  // namespace

pg_conn* ConnectToPostgres(const std::string& url) {
  // What stands before `dbname` the URL may say otherwise.
  const char* const keys[] = {"connect_timeout",
                              "fallback_application_name",
                              "keepalives_idle",
                              "keepalives_interval",
                              "keepalives_count",
                              "tcp_user_timeout",
                              "dbname",
                              "client_encoding",
                              nullptr};
  const char* const values[] = {"10", "axiscald", "10", "5", "3", "20000", url.c_str(), "UTF8", nullptr};
  return PQconnectdbParams(keys, values, 1);
}

// A parameter as it is sent.
struct PostgresParameter {
  Oid type = kText;
  std::optional<std::string> bytes;       // none: NULL, or `borrowed`
  const std::string* borrowed = nullptr;  // what a Blob borrows
};

class PostgresConnection::Statements final : public Prepared {
 public:
  Statements(PostgresConnection& connection, const std::string& sql)
      : connection_(connection), sql_(ToPostgres(sql)), values_(sql_.parameters.size()) {}

  absl::StatusOr<bool> Step() override {
    if (result_ == nullptr) {
      RETURN_IF_ERROR(Run());
      row_ = 0;
    } else if (row_ < PQntuples(result_.get())) {
      ++row_;
    }
    return row_ < PQntuples(result_.get());
  }
  void Reset() override {
    result_.reset();
    for (PostgresParameter& value : values_) value = PostgresParameter();
  }

  bool IsNull(int column) const override { return PQgetisnull(result_.get(), row_, column) != 0; }
  int64_t Int(int column) const override {
    if (PQftype(result_.get(), column) == kFloat8) return static_cast<int64_t>(Real(column));
    return SignedNumber(PQgetvalue(result_.get(), row_, column), PQgetlength(result_.get(), row_, column));
  }
  double Real(int column) const override {
    const int64_t number =
        SignedNumber(PQgetvalue(result_.get(), row_, column), PQgetlength(result_.get(), row_, column));
    return PQftype(result_.get(), column) == kFloat8 ? std::bit_cast<double>(number) : static_cast<double>(number);
  }
  std::string Text(int column) const override {
    const Oid type = PQftype(result_.get(), column);
    if (IsNull(column)) return "";
    if (type == kInt8 || type == kInt4) return std::to_string(Int(column));
    return std::string(PQgetvalue(result_.get(), row_, column),
                       static_cast<size_t>(PQgetlength(result_.get(), row_, column)));
  }

  void BindInt(int index, int64_t number) override {
    Set(index, {kInt8, BigEndian(static_cast<uint64_t>(number)), nullptr});
  }
  void BindReal(int index, double number) override {
    Set(index, {kFloat8, BigEndian(std::bit_cast<uint64_t>(number)), nullptr});
  }
  void BindText(int index, const std::string& text) override { Set(index, {kText, text, nullptr}); }
  void BindBlob(int index, Blob blob) override { Set(index, {kBytea, std::nullopt, &blob.bytes}); }
  void BindNull(int index, ValueType type) override {
    constexpr Oid kTypes[] = {kInt8, kFloat8, kText, kBytea};
    Set(index, {kTypes[static_cast<size_t>(type)], std::nullopt, nullptr});
  }

 private:
  // Each parameter of the store stands there once, or not at all.
  void Set(int index, PostgresParameter value) {
    const auto found = std::find(sql_.parameters.begin(), sql_.parameters.end(), index);
    if (found != sql_.parameters.end())
      values_[static_cast<size_t>(found - sql_.parameters.begin())] = std::move(value);
  }

  // The server knows the statement with these types from now on.
  absl::Status Prepare(PGconn* server) {
    std::vector<Oid> types;
    for (const PostgresParameter& value : values_) types.push_back(value.type);
    if (known_to_ == connection_.connections_ && types == types_) return absl::OkStatus();
    name_ = absl::StrCat("s", ++connection_.statements_);
    const PostgresResult prepared(
        PQprepare(server, name_.c_str(), sql_.text.c_str(), static_cast<int>(types.size()), types.data()));
    RETURN_IF_ERROR(StatusOf(server, prepared.get(), sql_.text));
    known_to_ = connection_.connections_;
    types_ = std::move(types);
    return absl::OkStatus();
  }

  absl::Status Run() {
    if (sql_.text == kRelease) {
      connection_.owes_release_ = true;
      return absl::OkStatus();
    }
    ASSIGN_OR_RETURN(const bool is_done, connection_.SendRelease(sql_.text));
    if (is_done) return absl::OkStatus();
    PGconn* const server = connection_.connection_;
    RETURN_IF_ERROR(Prepare(server));
    std::vector<const char*> values;
    std::vector<int> sizes;
    const std::vector<int> formats(values_.size(), 1);
    for (const PostgresParameter& value : values_) {
      const std::string* const bytes = value.bytes.has_value() ? &*value.bytes : value.borrowed;
      values.push_back(bytes == nullptr ? nullptr : bytes->data());
      sizes.push_back(bytes == nullptr ? 0 : static_cast<int>(bytes->size()));
    }
    PostgresResult result(PQexecPrepared(server, name_.c_str(), static_cast<int>(values.size()), values.data(),
                                         sizes.data(), formats.data(), 1));
    RETURN_IF_ERROR(connection_.Noted(PQresultErrorField(result.get(), PG_DIAG_SQLSTATE),
                                      StatusOf(server, result.get(), sql_.text)));
    for (int i = 0; i < PQnfields(result.get()); ++i) {
      const Oid type = PQftype(result.get(), i);
      if (type != kBool && type != kBytea && type != kInt8 && type != kInt4 && type != kText && type != kUnknown &&
          type != kFloat8) {
        return base::Error(absl::StatusCode::kInternal,
                           absl::StrCat(sql_.text, ": column ", i + 1, " is of type ", type, ", which is not read"),
                           {"STORE_BUG", {}});
      }
    }
    if (const std::string changed = PQcmdTuples(result.get()); PQresultStatus(result.get()) == PGRES_COMMAND_OK)
      connection_.changed_rows_ = changed.empty() ? 0 : std::stoll(changed);
    result_ = std::move(result);
    return absl::OkStatus();
  }

  PostgresConnection& connection_;
  const PostgresSql sql_;
  std::vector<PostgresParameter> values_;
  std::string name_;
  int64_t known_to_ = 0;  // connections_ then
  std::vector<Oid> types_;
  PostgresResult result_;
  int row_ = 0;
};

absl::StatusOr<std::unique_ptr<PostgresConnection>> PostgresConnection::Open(const std::string& url, Access access,
                                                                             Hold hold) {
  std::unique_ptr<PostgresConnection> connection(new PostgresConnection(access, hold, ConnectToPostgres(url)));
  RETURN_IF_ERROR(connection->Settle(true));
  return connection;
}

PostgresConnection::~PostgresConnection() {
  ForgetStatements();
  // Told now, so that the next one need not wait until the server finds that this one has gone.
  if (access_ == Access::kWrite && PQstatus(connection_) == CONNECTION_OK)
    Execute("SELECT pg_advisory_unlock_all()").IgnoreError();
  PQfinish(connection_);
}

// After connecting.
absl::Status PostgresConnection::Settle(bool is_first) {
  if (connection_ == nullptr) return PostgresError("", "out of memory", "connect");
  if (PQstatus(connection_) != CONNECTION_OK) return PostgresError("", Message(PQerrorMessage(connection_)), "connect");
  // Notices go to stderr else.
  PQsetNoticeProcessor(
      connection_, [](void*, const char*) {}, nullptr);
  RETURN_IF_ERROR(Execute(absl::StrCat("SET lock_timeout = '", kLockWait, "'")));
  if (access_ == Access::kReadOnly) return Execute("SET default_transaction_read_only = on");
  RETURN_IF_ERROR(
      Execute("SELECT set_config('synchronous_commit', 'on', false) WHERE current_setting('synchronous_commit') = "
              "'off'"));
  // Of a process that stands still, or whose machine is gone, nobody waits for what it has begun.
  RETURN_IF_ERROR(Execute(absl::StrCat("SET idle_in_transaction_session_timeout = '", kIdleWriter,
                                       "'; SET tcp_keepalives_idle = 10; SET tcp_keepalives_interval = 5; SET "
                                       "tcp_keepalives_count = 3")));
  return TakeStore(is_first);
}

absl::StatusOr<bool> PostgresConnection::AskLock(const std::string& function) {
  // What takes a lock and waits for it gives nothing.
  const bool waits = !absl::StrContains(function, "try") && !absl::StrContains(function, "unlock");
  ASSIGN_OR_RETURN(Statement row,
                   Ask(absl::StrCat("SELECT ", function, "(?1)", waits ? " IS NOT NULL" : ""), kStoreLock));
  RETURN_IF_ERROR(row.Step().status());
  return row.Bool(0);
}

absl::Status PostgresConnection::TakeStore(bool is_first) {
  is_alone_ = false;
  if (hold_ == Hold::kShared && is_first) {
    const auto until = std::chrono::steady_clock::now() + kAloneWithin;
    while (true) {
      ASSIGN_OR_RETURN(is_alone_, AskLock("pg_try_advisory_lock"));
      if (is_alone_) return absl::OkStatus();
      if (std::chrono::steady_clock::now() >= until) break;
      std::this_thread::sleep_for(kLooksAgain);
    }
  }
  if (hold_ == Hold::kShared) RETURN_IF_ERROR(Execute(absl::StrCat("SET lock_timeout = '", kStoreWait, "'")));
  const absl::Status taken = AskLock(hold_ == Hold::kAlone ? "pg_advisory_lock" : "pg_advisory_lock_shared").status();
  if (base::ErrorReason(taken) == "STORE_BUSY") {
    return base::Error(absl::StatusCode::kUnavailable,
                       absl::StrCat("database ", PQdb(connection_), " is held by another process"),
                       {"STORE_LOCKED", {}});
  }
  RETURN_IF_ERROR(taken);
  return Execute(absl::StrCat("SET lock_timeout = '", kLockWait, "'"));
}

absl::Status PostgresConnection::LetOthersIn() {
  if (!is_alone_) return absl::OkStatus();
  // One connection may have both; there is no moment with neither.
  RETURN_IF_ERROR(AskLock("pg_advisory_lock_shared").status());
  RETURN_IF_ERROR(AskLock("pg_advisory_unlock").status());
  is_alone_ = false;
  return absl::OkStatus();
}

absl::Status PostgresConnection::Tell(const std::string& what) {
  ASSIGN_OR_RETURN(Statement row, Ask("SELECT pg_notify(?1, ?2) IS NULL", std::string(kNewsChannel), what));
  return row.Step().status();
}

absl::Status PostgresConnection::Noted(const char* sqlstate, absl::Status status) {
  // Class 40: serialization failure, deadlock. 40003: it is not known what became of it.
  if (sqlstate != nullptr && absl::StartsWith(sqlstate, "40") && !absl::StartsWith(sqlstate, "40003"))
    was_undone_ = true;
  return status;
}

absl::StatusOr<bool> PostgresConnection::SendRelease(const std::string& sql) {
  if (!owes_release_) return false;
  owes_release_ = false;
  if (sql == "COMMIT" || sql == "ROLLBACK") return false;  // which end all savepoints
  const bool is_next = sql == kSavepoint;
  RETURN_IF_ERROR(Execute(is_next ? absl::StrCat(kRelease, "; ", kSavepoint) : kRelease));
  return is_next;
}

absl::Status PostgresConnection::Reconnect() {
  owes_release_ = false;
  is_settled_ = false;
  PQreset(connection_);
  ++connections_;
  absl::Status settled = Settle(false);
  if (settled.ok() && check_) settled = check_(*this);
  if (!settled.ok()) {
    // Whoever waits until nobody has the store need not wait for one that cannot use it.
    if (access_ == Access::kWrite && PQstatus(connection_) == CONNECTION_OK)
      Execute("SELECT pg_advisory_unlock_all()").IgnoreError();
    return settled;
  }
  is_settled_ = true;
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<Prepared>> PostgresConnection::Compile(const std::string& sql) {
  return std::make_unique<Statements>(*this, sql);
}

absl::StatusOr<bool> PostgresConnection::HasTable(const std::string& name) {
  ASSIGN_OR_RETURN(Statement row,
                   Ask("SELECT 1 FROM pg_tables WHERE schemaname = current_schema() AND tablename = ?1", name));
  return row.Step();
}

absl::StatusOr<bool> PostgresConnection::HasDetached(SessionId id) {
  // By the bounds of the tables that are attached, whatever their names: FOR VALUES FROM ('65536') TO ('131072'). Of
  // one that is being detached new snapshots see nothing any more.
  ASSIGN_OR_RETURN(Statement row,
                   Ask("SELECT NOT EXISTS (SELECT 1 FROM (SELECT pg_get_expr(c.relpartbound, c.oid) AS bounds FROM "
                       "pg_inherits AS i JOIN pg_class AS c ON c.oid = i.inhrelid WHERE NOT i.inhdetachpending AND "
                       "i.inhparent = CAST('chunk' AS regclass)) AS part WHERE (bounds LIKE '%FROM (MINVALUE)%' OR "
                       "CAST(substring(bounds FROM 'FROM "
                       "[^0-9]*([0-9]+)') AS BIGINT) <= ?1) AND (bounds LIKE '%TO (MAXVALUE)%' OR "
                       "CAST(substring(bounds FROM 'TO [^0-9]*([0-9]+)') AS BIGINT) > ?1))",
                       id));
  RETURN_IF_ERROR(row.Step().status());
  return row.Bool(0);
}

absl::Status PostgresConnection::Execute(const std::string& script) {
  const PostgresResult result(PQexec(connection_, script.c_str()));
  return Noted(PQresultErrorField(result.get(), PG_DIAG_SQLSTATE), StatusOf(connection_, result.get(), script));
}

absl::Status PostgresConnection::Begin(Access access) {
  was_undone_ = owes_release_ = false;
  // Each statement behind the lock sees all that was committed before it: the writers of all processes are as serial as
  // those of one, and what they number is seen in the order of its numbers.
  const std::string write = hold_ != Hold::kShared ? "BEGIN"
                                                   : absl::StrCat("BEGIN; SET LOCAL lock_timeout = '", kWriteWait,
                                                                  "'; SELECT pg_advisory_xact_lock(", kWriteLock,
                                                                  "); SET LOCAL lock_timeout = '", kLockWait, "'");
  const std::string sql = access == Access::kWrite ? write : "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY";
  absl::Status begun = absl::OkStatus();
  if (PQstatus(connection_) == CONNECTION_OK && is_settled_) begun = Execute(sql);
  // A server that went away shows only now. Nothing has been done yet.
  if (PQstatus(connection_) != CONNECTION_OK || !is_settled_) {
    RETURN_IF_ERROR(Reconnect());
    begun = Execute(sql);
  }
  if (!begun.ok() && in_transaction()) Execute("ROLLBACK").IgnoreError();
  return begun;
}

absl::Status PostgresConnection::CommitSoon() {
  owes_release_ = false;  // the end of the transaction ends all savepoints
  return Execute("SET LOCAL synchronous_commit = off; COMMIT");
}

bool PostgresConnection::in_transaction() const {
  const PGTransactionStatusType status = PQtransactionStatus(connection_);
  return status != PQTRANS_IDLE && status != PQTRANS_UNKNOWN;
}

}  // namespace axiscal::storage
