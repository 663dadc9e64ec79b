#include "server/storage/postgres_connection.h"

#include <libpq-fe.h>

#include <algorithm>
#include <bit>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "core/base/error_detail.h"
#include "server/storage/postgres_error.h"
#include "server/storage/postgres_sql.h"

namespace axiscal::storage {

struct ClearPostgresResult {
  void operator()(PGresult* result) const { PQclear(result); }
};
using PostgresResult = std::unique_ptr<PGresult, ClearPostgresResult>;

namespace {

// Numbers of types: catalog/pg_type.dat of PostgreSQL, which never change.
constexpr Oid kBool = 16, kBytea = 17, kInt8 = 20, kInt4 = 23, kText = 25, kUnknown = 705, kFloat8 = 701;
// "Axis": who has the store of a database open.
constexpr int64_t kStoreLock = 0x41786973;

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
    RETURN_IF_ERROR(StatusOf(server, result.get(), sql_.text));
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

absl::StatusOr<std::unique_ptr<PostgresConnection>> PostgresConnection::Open(const std::string& url, Access access) {
  // What stands before `dbname` the URL may say otherwise.
  const char* const keys[] = {"connect_timeout", "fallback_application_name", "dbname", "client_encoding", nullptr};
  const char* const values[] = {"10", "axiscald", url.c_str(), "UTF8", nullptr};
  std::unique_ptr<PostgresConnection> connection(
      new PostgresConnection(url, access, PQconnectdbParams(keys, values, 1)));
  RETURN_IF_ERROR(connection->Settle());
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
absl::Status PostgresConnection::Settle() {
  if (connection_ == nullptr) return PostgresError("", "out of memory", "connect");
  if (PQstatus(connection_) != CONNECTION_OK) return PostgresError("", Message(PQerrorMessage(connection_)), "connect");
  // Notices go to stderr else.
  PQsetNoticeProcessor(
      connection_, [](void*, const char*) {}, nullptr);
  RETURN_IF_ERROR(Execute("SET lock_timeout = '2s'"));
  if (access_ == Access::kReadOnly) return Execute("SET default_transaction_read_only = on");
  RETURN_IF_ERROR(
      Execute("SELECT set_config('synchronous_commit', 'on', false) WHERE current_setting('synchronous_commit') = "
              "'off'"));
  // A process that has just ended may have it still for a moment.
  ASSIGN_OR_RETURN(Statement row, Ask("SELECT pg_advisory_lock(?1) IS NULL", kStoreLock));
  const absl::Status taken = row.Step().status();
  if (base::ErrorReason(taken) != "STORE_BUSY") return taken;
  return base::Error(absl::StatusCode::kUnavailable,
                     absl::StrCat("database ", PQdb(connection_), " is held by another process"), {"STORE_LOCKED", {}});
}

absl::Status PostgresConnection::Reconnect() {
  PQreset(connection_);
  ++connections_;
  return Settle();
}

absl::StatusOr<std::unique_ptr<Prepared>> PostgresConnection::Compile(const std::string& sql) {
  return std::make_unique<Statements>(*this, sql);
}

absl::StatusOr<bool> PostgresConnection::HasTable(const std::string& name) {
  ASSIGN_OR_RETURN(Statement row,
                   Ask("SELECT 1 FROM pg_tables WHERE schemaname = current_schema() AND tablename = ?1", name));
  return row.Step();
}

absl::Status PostgresConnection::Execute(const std::string& script) {
  const PostgresResult result(PQexec(connection_, script.c_str()));
  return StatusOf(connection_, result.get(), script);
}

absl::Status PostgresConnection::Begin(Access access) {
  const std::string sql = access == Access::kWrite ? "BEGIN" : "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY";
  if (PQstatus(connection_) == CONNECTION_OK) {
    const absl::Status begun = Execute(sql);
    // A server that went away shows only now. Nothing has been done yet.
    if (begun.ok() || PQstatus(connection_) == CONNECTION_OK) return begun;
  }
  RETURN_IF_ERROR(Reconnect());
  return Execute(sql);
}

bool PostgresConnection::in_transaction() const {
  const PGTransactionStatusType status = PQtransactionStatus(connection_);
  return status != PQTRANS_IDLE && status != PQTRANS_UNKNOWN;
}

}  // namespace axiscal::storage
