#include "server/storage/copy_store.h"

#include <algorithm>
#include <bit>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "core/base/error_detail.h"
#include "core/base/files.h"
#include "core/base/sha256.h"
#include "server/storage/check.h"
#include "server/storage/estimates.h"
#include "server/storage/file_lock.h"
#include "server/storage/migrate.h"
#include "server/storage/postgres_connection.h"
#include "server/storage/postgres_migrate.h"
#include "server/storage/postgres_url.h"
#include "server/storage/refusal.h"
#include "server/storage/transaction.h"

namespace axiscal::storage {
namespace {

// Holds where its rows are from. It is there while a copy is not at its end.
constexpr char kMarker[] = "unfinished_copy";
// Rows of one transaction. PostgreSQL gives all rows of an answer at once: of tables whose rows may have megabytes few.
constexpr int kRowsAtATime = 1000, kLongRowsAtATime = 16;

struct Column {
  std::string name;
  ValueType type = ValueType::kInt;
};

struct Table {
  std::string name;
  std::vector<Column> columns;
  std::vector<size_t> key;        // which columns are the primary key, in its order
  std::set<std::string> parents;  // that its rows name
  std::string parent_column;      // names a row of the same table, whose own is NULL; empty: there is none
  bool has_long_rows = false;
  // Has its one row from the start.
  bool is_made_with_schema() const { return name == "up_time" || name == "audit_anchor"; }
  // A sum over the row, which each engine makes in its own way.
  bool is_made_anew(const Column& column) const {
    return column.name == "crc32c" && (name == "estimate" || name == "estimate_week");
  }
  // Conditions on its rows, which are copied in this order.
  std::vector<std::string> Passes() const {
    if (parent_column.empty()) return {"1 = 1"};
    return {Quoted(parent_column) + " IS NULL", Quoted(parent_column) + " IS NOT NULL"};
  }
  static std::string Quoted(const std::string& name) { return "\"" + name + "\""; }
  std::string Names(const std::vector<size_t>& which) const {
    return absl::StrJoin(which, ", ", [&](std::string* out, size_t i) { *out += Quoted(columns[i].name); });
  }
  std::vector<size_t> All() const {
    std::vector<size_t> all(columns.size());
    for (size_t i = 0; i < all.size(); ++i) all[i] = i;
    return all;
  }
};

absl::StatusOr<ValueType> TypeNamed(const std::string& type) {
  if (type == "INTEGER") return ValueType::kInt;
  if (type == "REAL") return ValueType::kReal;
  if (type == "TEXT") return ValueType::kText;
  if (type == "BLOB") return ValueType::kBlob;
  return absl::InternalError("a column of type " + type);
}

// All tables of the present schema but that of migrations, each behind those that its rows name. SQLite's schema tells;
// PostgreSQL's has the same tables and columns.
absl::StatusOr<std::vector<Table>> PresentTables() {
  ASSIGN_OR_RETURN(const std::unique_ptr<SqliteConnection> schema, SqliteConnection::Open(":memory:", Access::kWrite));
  RETURN_IF_ERROR(Migrate(*schema, EmbeddedMigrations(), base::UtcTime()));
  std::map<std::string, Table> left;
  {
    ASSIGN_OR_RETURN(Statement row, schema->Ask("SELECT t.name, c.name, c.type, c.pk FROM sqlite_schema AS t JOIN "
                                                "pragma_table_info(t.name) AS c WHERE t.type = 'table' AND t.name NOT "
                                                "LIKE 'sqlite%' AND t.name <> 'migration' ORDER BY t.name, c.cid"));
    std::map<std::string, std::map<int64_t, size_t>> keys;
    while (true) {
      ASSIGN_OR_RETURN(const bool has_row, row.Step());
      if (!has_row) break;
      Table& table = left[row.Text(0)];
      table.name = row.Text(0);
      if (row.Int(3) > 0) keys[table.name][row.Int(3)] = table.columns.size();
      ASSIGN_OR_RETURN(const ValueType type, TypeNamed(row.Text(2)));
      table.columns.push_back({row.Text(1), type});
      if (type == ValueType::kBlob || absl::EndsWith(row.Text(1), "_json")) table.has_long_rows = true;
    }
    for (const auto& [name, key] : keys)
      for (const auto& [place, column] : key) left[name].key.push_back(column);
  }
  {
    ASSIGN_OR_RETURN(Statement row, schema->Ask("SELECT t.name, f.\"table\", f.\"from\" FROM sqlite_schema AS t JOIN "
                                                "pragma_foreign_key_list(t.name) AS f WHERE t.type = 'table'"));
    while (true) {
      ASSIGN_OR_RETURN(const bool has_row, row.Step());
      if (!has_row) break;
      Table& table = left[row.Text(0)];
      if (row.Text(1) == table.name) {
        table.parent_column = row.Text(2);
      } else {
        table.parents.insert(row.Text(1));
      }
    }
  }
  std::vector<Table> ordered;
  while (!left.empty()) {
    const auto next = std::find_if(left.begin(), left.end(), [&](const auto& one) {
      return std::none_of(one.second.parents.begin(), one.second.parents.end(),
                          [&](const std::string& parent) { return left.contains(parent); });
    });
    if (next == left.end()) return absl::InternalError("tables name each other in a circle");
    ordered.push_back(std::move(next->second));
    left.erase(next);
  }
  return ordered;
}

// One side of a copy, locked.
struct Side {
  std::string name;  // for messages
  bool is_postgres = false;
  std::optional<FileLock> lock;
  std::unique_ptr<Connection> connection;  // goes before the lock
};

// Whether a source is of this schema, and whole as far as copying goes.
absl::Status CheckSource(Connection& connection, const std::vector<Migration>& migrations) {
  ASSIGN_OR_RETURN(const bool is_store, connection.HasTable("migration"));
  if (!is_store) return FailedPrecondition("is empty, and no store of axiscald", "NOT_A_DATABASE");
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT coalesce(max(version), 0) FROM migration"));
  RETURN_IF_ERROR(row.Step().status());
  RETURN_IF_ERROR(CheckMigrations(connection, migrations, row.Int(0)));
  if (row.Int(0) < migrations.back().version)
    return FailedPrecondition("is of an older version: let axiscald open it once", "SCHEMA_OLDER");
  return RefuseUnfinishedCopy(connection);
}

// FAILED_PRECONDITION COPY_DETACHED: a copy would have sessions without their readings, and no place to put them back.
absl::Status CheckNothingDetached(Connection& connection) {
  std::vector<SessionId> first;  // of each table of chunks that sessions should have
  {
    ASSIGN_OR_RETURN(Statement row,
                     connection.Ask("SELECT min(id) FROM session WHERE next_seq > 0 GROUP BY id / 65536 ORDER BY 1"));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      first.push_back(SessionId(row.Int(0)));
    }
  }
  for (const SessionId id : first) {
    ASSIGN_OR_RETURN(const bool is_detached, connection.HasDetached(id));
    if (!is_detached) continue;
    return FailedPrecondition(
        absl::StrCat("the readings of session ", id.number(),
                     " and of those of its time were detached: attach them first (docs/scale.md)"),
        "COPY_DETACHED");
  }
  return absl::OkStatus();
}

absl::StatusOr<Side> OpenPostgresSide(const std::string& url, bool is_source, base::UtcTime now) {
  Side side;
  side.name = WithoutPassword(url);
  side.is_postgres = true;
  const absl::Status opened = [&]() -> absl::Status {
    ASSIGN_OR_RETURN(side.connection, PostgresConnection::Open(url, Access::kWrite));
    if (!is_source) return MigratePostgres(*side.connection, PostgresMigrations(), now);
    RETURN_IF_ERROR(CheckSource(*side.connection, PostgresMigrations()));
    return CheckNothingDetached(*side.connection);
  }();
  if (!opened.ok()) return base::Within(side.name, opened);
  return side;
}

// A source is not written to.
absl::StatusOr<Side> OpenFileSide(const std::string& path, bool is_source, base::UtcTime now) {
  Side side;
  side.name = path;
  if (is_source) RETURN_IF_ERROR(base::RequireFile(path));
  ASSIGN_OR_RETURN(FileLock lock, LockStoreFile(path, EmbeddedMigrations()));
  side.lock.emplace(std::move(lock));
  ASSIGN_OR_RETURN(std::unique_ptr<SqliteConnection> connection,
                   SqliteConnection::Open(side.lock->path(), is_source ? Access::kReadOnly : Access::kWrite));
  const absl::Status checked =
      is_source ? CheckSource(*connection, EmbeddedMigrations()) : Migrate(*connection, EmbeddedMigrations(), now);
  if (!checked.ok()) return base::Within(path, checked);
  side.connection = std::move(connection);
  return side;
}

absl::StatusOr<bool> HasRows(Connection& connection, const std::string& table) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT 1 FROM " + Table::Quoted(table) + " LIMIT 1"));
  return row.Step();
}

absl::StatusOr<int64_t> CountRows(Connection& connection, const std::string& table) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT count(*) FROM " + Table::Quoted(table)));
  RETURN_IF_ERROR(row.Step().status());
  return row.Int(0);
}

// Marks what is new as unfinished; what is marked already goes on.
absl::Status BeginCopy(Side& to, const std::string& source, const std::vector<Table>& tables) {
  ASSIGN_OR_RETURN(const bool goes_on, to.connection->HasTable(kMarker));
  if (goes_on) {
    ASSIGN_OR_RETURN(Statement row, to.connection->Ask(absl::StrCat("SELECT source FROM ", kMarker)));
    ASSIGN_OR_RETURN(const bool has_row, row.Step());
    if (has_row && row.Text(0) == source) return absl::OkStatus();
    return FailedPrecondition("holds an unfinished copy of " + (has_row ? row.Text(0) : "nothing"), "COPY_NOT_EMPTY");
  }
  for (const Table& table : tables) {
    if (table.is_made_with_schema()) continue;
    ASSIGN_OR_RETURN(const bool has_rows, HasRows(*to.connection, table.name));
    if (has_rows) {
      return FailedPrecondition("has rows already (" + table.name + "): a copy goes into a new database",
                                "COPY_NOT_EMPTY");
    }
  }
  ASSIGN_OR_RETURN(Transaction transaction, Transaction::BeginWrite(*to.connection));
  RETURN_IF_ERROR(to.connection->Execute(absl::StrCat("CREATE TABLE ", kMarker, " (source TEXT NOT NULL)")));
  RETURN_IF_ERROR(to.connection->Run(absl::StrCat("INSERT INTO ", kMarker, " (source) VALUES (?1)"), source));
  return transaction.Commit();
}

void BindLike(Statement& to, int index, const Statement& from, int column, ValueType type, std::string& bytes) {
  if (from.IsNull(column)) return to.BindNull(index, type);
  switch (type) {
    case ValueType::kInt:
      return to.Bind(index, from.Int(column));
    case ValueType::kReal:
      return to.Bind(index, from.Real(column));
    case ValueType::kText:
      return to.Bind(index, from.Text(column));
    case ValueType::kBlob:
      bytes = from.Text(column);
      return to.Bind(index, Blob{bytes});
  }
}

// Rows of a table in the order of its key, some at a time.
class Reader {
 public:
  Reader(Connection& connection, const Table& table, const std::string& condition)
      : connection_(connection), table_(table), condition_(condition) {}

  // Goes on behind the last row that `there` has of the condition.
  absl::Status StartBehind(Connection& there) {
    const std::string order = absl::StrJoin(table_.key, ", ", [&](std::string* out, size_t i) {
      absl::StrAppend(out, Table::Quoted(table_.columns[i].name), " DESC");
    });
    ASSIGN_OR_RETURN(Statement row,
                     there.Ask(absl::StrCat("SELECT ", table_.Names(table_.key), " FROM ", Table::Quoted(table_.name),
                                            " WHERE ", condition_, " ORDER BY ", order, " LIMIT 1")));
    ASSIGN_OR_RETURN(const bool has_row, row.Step());
    if (has_row) Remember(row, false);
    return absl::OkStatus();
  }
  // Calls `take` with up to so many rows; false where there was none any more.
  template <typename Take>
  absl::StatusOr<bool> Next(const Take& take) {
    ASSIGN_OR_RETURN(Statement row, connection_.Ask(Sql()));
    for (size_t i = 0; i < last_.size(); ++i) {
      const int index = static_cast<int>(i) + 1;
      if (const auto* text = std::get_if<std::string>(&last_[i])) {
        row.Bind(index, *text);
      } else {
        row.Bind(index, std::get<int64_t>(last_[i]));
      }
    }
    bool has_any = false;
    while (true) {
      ASSIGN_OR_RETURN(const bool has_row, row.Step());
      if (!has_row) return has_any;
      has_any = true;
      RETURN_IF_ERROR(take(row));
      Remember(row, true);
    }
  }

 private:
  std::string Sql() const {
    std::string after;
    if (!last_.empty()) {
      std::vector<std::string> marks;
      for (size_t i = 1; i <= last_.size(); ++i) marks.push_back(absl::StrCat("?", i));
      after = absl::StrCat(" AND (", table_.Names(table_.key), ") > (", absl::StrJoin(marks, ", "), ")");
    }
    return absl::StrCat("SELECT ", table_.Names(table_.All()), " FROM ", Table::Quoted(table_.name), " WHERE ",
                        condition_, after, " ORDER BY ", table_.Names(table_.key), " LIMIT ",
                        table_.has_long_rows ? kLongRowsAtATime : kRowsAtATime);
  }
  // The key of a row, which holds all columns or the key alone. Keys are numbers and texts.
  void Remember(const Statement& row, bool has_all) {
    last_.clear();
    for (size_t i = 0; i < table_.key.size(); ++i) {
      const int column = static_cast<int>(has_all ? table_.key[i] : i);
      if (table_.columns[table_.key[i]].type == ValueType::kText) {
        last_.emplace_back(row.Text(column));
      } else {
        last_.emplace_back(row.Int(column));
      }
    }
  }

  Connection& connection_;
  const Table& table_;
  const std::string condition_;
  std::vector<std::variant<int64_t, std::string>> last_;
};

std::string InsertSql(const Table& table) {
  std::vector<std::string> marks, changes;
  for (size_t i = 0; i < table.columns.size(); ++i) {
    marks.push_back(absl::StrCat("?", i + 1));
    const std::string name = Table::Quoted(table.columns[i].name);
    if (std::find(table.key.begin(), table.key.end(), i) == table.key.end())
      changes.push_back(absl::StrCat(name, " = excluded.", name));
  }
  return absl::StrCat("INSERT INTO ", Table::Quoted(table.name), " (", table.Names(table.All()), ") VALUES (",
                      absl::StrJoin(marks, ", "), ")",
                      table.is_made_with_schema() ? absl::StrCat(" ON CONFLICT (", table.Names(table.key),
                                                                 ") DO UPDATE SET ", absl::StrJoin(changes, ", "))
                                                  : "");
}

// PostgreSQL numbers the audit itself, one by one: from the first that is there on, as its older ones may have left.
absl::Status NumberAudit(Side& from, Side& to) {
  ASSIGN_OR_RETURN(const bool goes_on, HasRows(*to.connection, "audit"));
  if (goes_on) return absl::OkStatus();
  ASSIGN_OR_RETURN(Statement row, from.connection->Ask("SELECT min(id) FROM audit"));
  RETURN_IF_ERROR(row.Step().status());
  if (row.IsNull(0)) return absl::OkStatus();
  return to.connection->Run("UPDATE given_number SET seq = ?1 WHERE name = 'audit'", row.Int(0) - 1);
}

// The last number that each table gave to a row, which is not given again.
absl::StatusOr<std::map<std::string, int64_t>> LastNumbers(Side& side) {
  std::map<std::string, int64_t> numbers;
  const auto read = [&](const std::string& sql) -> absl::Status {
    ASSIGN_OR_RETURN(Statement row, side.connection->Ask(sql));
    while (true) {
      ASSIGN_OR_RETURN(const bool has_row, row.Step());
      if (!has_row) return absl::OkStatus();
      std::string name = row.Text(0);
      if (absl::EndsWith(name, "_id_seq")) name.resize(name.size() - 7);
      numbers[name] = row.Int(1);
    }
  };
  if (!side.is_postgres) {
    RETURN_IF_ERROR(read("SELECT name, seq FROM sqlite_sequence WHERE name IN (SELECT name FROM sqlite_schema)"));
    return numbers;
  }
  // What it numbers without gaps; beside it stands what is no table's (the caretaker ...).
  RETURN_IF_ERROR(read("SELECT name, seq FROM given_number WHERE name = 'audit'"));
  RETURN_IF_ERROR(read("SELECT CAST(sequencename AS TEXT), last_value FROM pg_sequences WHERE last_value IS NOT NULL"));
  return numbers;
}

absl::Status SetLastNumbers(Side& side, const std::map<std::string, int64_t>& numbers) {
  for (const auto& [table, number] : numbers) {
    if (number < 1) continue;
    if (side.is_postgres && table != "audit") {
      RETURN_IF_ERROR(
          side.connection->Run("SELECT setval(CAST(pg_get_serial_sequence(?1, 'id') AS regclass), ?2)", table, number));
      continue;
    }
    RETURN_IF_ERROR(side.connection->Run("UPDATE sqlite_sequence SET seq = ?2 WHERE name = ?1", table, number));
    if (side.connection->changed_rows() == 0)
      RETURN_IF_ERROR(side.connection->Run("INSERT INTO sqlite_sequence (name, seq) VALUES (?1, ?2)", table, number));
  }
  return absl::OkStatus();
}

using Tell = std::function<absl::Status(const CopyProgress&)>;

absl::Status CopyTable(Side& from, Side& to, const Table& table, CopyProgress& progress, int64_t& rows_before,
                       const Tell& tell) {
  if (to.is_postgres && table.name == "audit") RETURN_IF_ERROR(NumberAudit(from, to));
  if (!table.is_made_with_schema()) {
    ASSIGN_OR_RETURN(const int64_t there, CountRows(*to.connection, table.name));
    rows_before += there;
    progress.rows += there;
  }
  const std::string insert = InsertSql(table);
  for (const std::string& condition : table.Passes()) {
    Reader reader(*from.connection, table, condition);
    if (!table.is_made_with_schema()) RETURN_IF_ERROR(reader.StartBehind(*to.connection));
    bool has_more = true;
    while (has_more) {
      ASSIGN_OR_RETURN(Transaction transaction, Transaction::BeginWrite(*to.connection));
      ASSIGN_OR_RETURN(has_more, reader.Next([&](const Statement& row) -> absl::Status {
        ASSIGN_OR_RETURN(Statement put, to.connection->Ask(insert));
        std::vector<std::string> bytes(table.columns.size());
        for (size_t i = 0; i < table.columns.size(); ++i)
          BindLike(put, static_cast<int>(i) + 1, row, static_cast<int>(i), table.columns[i].type, bytes[i]);
        ++progress.rows;
        return put.Step().status();
      }));
      RETURN_IF_ERROR(transaction.Commit());
      RETURN_IF_ERROR(tell(progress));
    }
  }
  return absl::OkStatus();
}

// Of all rows of a table, but what an engine makes anew.
absl::StatusOr<std::string> HashOf(Side& side, const Table& table, CopyProgress* progress, const Tell& tell) {
  base::Sha256 hash;
  const auto add_number = [&](uint64_t bits) { hash.Add(&bits, sizeof(bits)); };
  Reader reader(*side.connection, table, "1 = 1");
  bool has_more = true;
  while (has_more) {
    ASSIGN_OR_RETURN(has_more, reader.Next([&](const Statement& row) {
      for (size_t i = 0; i < table.columns.size(); ++i) {
        const int column = static_cast<int>(i);
        if (table.is_made_anew(table.columns[i])) continue;
        const bool is_null = row.IsNull(column);
        hash.Add(&is_null, 1);
        if (is_null) continue;
        if (table.columns[i].type == ValueType::kInt) {
          add_number(static_cast<uint64_t>(row.Int(column)));
        } else if (table.columns[i].type == ValueType::kReal) {
          add_number(std::bit_cast<uint64_t>(row.Real(column)));
        } else {
          const std::string text = row.Text(column);
          add_number(text.size());
          hash.Add(text);
        }
      }
      if (progress != nullptr) ++progress->rows;
      return absl::OkStatus();
    }));
    if (progress != nullptr) RETURN_IF_ERROR(tell(*progress));
  }
  return hash.HexDigest();
}

absl::StatusOr<CopyResult> Copy(Side& from, Side& to, const Tell& tell) {
  ASSIGN_OR_RETURN(const std::vector<Table> tables, PresentTables());
  ASSIGN_OR_RETURN(const int64_t damaged, CountDamagedEstimates(*from.connection));
  if (damaged > 0) {
    return base::Error(absl::StatusCode::kDataLoss,
                       absl::StrCat(from.name, ": ", damaged,
                                    " rows of the history are not what was stored: ", "axiscald check names them"),
                       {"HISTORY_DAMAGED", {}});
  }
  CopyResult result;
  result.tables = static_cast<int64_t>(tables.size());
  for (const Table& table : tables) {
    ASSIGN_OR_RETURN(const int64_t rows, CountRows(*from.connection, table.name));
    result.rows += rows;
  }
  RETURN_IF_ERROR(base::Within(to.name, BeginCopy(to, from.name, tables)));
  CopyProgress progress{"copies", "", 0, result.rows};
  for (const Table& table : tables) {
    progress.table = table.name;
    RETURN_IF_ERROR(CopyTable(from, to, table, progress, result.rows_before, tell));
  }
  RETURN_IF_ERROR(SealEstimatesAnew(*to.connection));
  ASSIGN_OR_RETURN(const auto numbers, LastNumbers(from));
  RETURN_IF_ERROR(SetLastNumbers(to, numbers));

  progress = {"compares", "", 0, result.rows};
  base::Sha256 all;
  for (const Table& table : tables) {
    progress.table = table.name;
    ASSIGN_OR_RETURN(const std::string was, HashOf(from, table, &progress, tell));
    ASSIGN_OR_RETURN(const std::string is, HashOf(to, table, nullptr, tell));
    if (was != is) {
      return FailedPrecondition(absl::StrCat("table ", table.name, " differs: ", from.name,
                                             " has changed since the copy was begun. Begin again with a new database"),
                                "COPY_DIFFERS");
    }
    all.Add(table.name + is);
  }
  result.sha256 = all.HexDigest();
  const CheckReport report = CheckRows(*to.connection);
  if (report.damage_count > 0) {
    const std::string first = report.damages.empty() ? "" : report.damages[0].resource + ": " + report.damages[0].text;
    return base::Error(absl::StatusCode::kDataLoss,
                       absl::StrCat(from.name, " is damaged in ", report.damage_count, " places, ", first),
                       {"STORE_DAMAGED", {}});
  }
  RETURN_IF_ERROR(to.connection->Execute(absl::StrCat("DROP TABLE ", kMarker)));
  return result;
}

}  // namespace

absl::StatusOr<CopyResult> CopyStoreTo(const std::string& from, const std::string& to, base::UtcTime now,
                                       const std::function<absl::Status(const CopyProgress&)>& tell) {
  const auto open = [now](const std::string& database, bool is_source) {
    return IsPostgresUrl(database) ? OpenPostgresSide(database, is_source, now)
                                   : OpenFileSide(database, is_source, now);
  };
  ASSIGN_OR_RETURN(Side source, open(from, true));
  ASSIGN_OR_RETURN(Side target, open(to, false));
  return Copy(source, target, tell);
}

absl::Status RefuseUnfinishedCopy(Connection& connection) {
  ASSIGN_OR_RETURN(const bool is_unfinished, connection.HasTable(kMarker));
  if (!is_unfinished) return absl::OkStatus();
  return FailedPrecondition("is what a copy that was broken off has left: axiscald copy goes on with it",
                            "COPY_UNFINISHED");
}

}  // namespace axiscal::storage
