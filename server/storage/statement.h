// One prepared SQL statement with its parameters bound; steps through its rows.
#ifndef AXISCAL_SERVER_STORAGE_STATEMENT_H_
#define AXISCAL_SERVER_STORAGE_STATEMENT_H_

#include <sqlite3.h>

#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "core/base/clock.h"
#include "core/base/ids.h"
#include "core/base/status.h"

namespace axiscal::storage {

// Marks bytes to be bound as BLOB, without a copy: they must outlive the statement.
struct Blob {
  const std::string& bytes;
};

// Borrowed from its connection's cache, given back reset when it goes.
class Statement {
 public:
  using GiveBack = std::function<void(sqlite3_stmt*)>;
  Statement(sqlite3_stmt* statement, GiveBack give_back) : statement_(statement), give_back_(std::move(give_back)) {}
  Statement(Statement&& other) noexcept
      : statement_(std::exchange(other.statement_, nullptr)), give_back_(std::move(other.give_back_)) {}
  Statement& operator=(Statement&&) = delete;
  ~Statement();

  // The next row is there, or not.
  absl::StatusOr<bool> Step();

  // Columns of the present row, from 0.
  bool IsNull(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
  int64_t Int(int column) const { return sqlite3_column_int64(statement_, column); }
  bool Bool(int column) const { return Int(column) != 0; }
  double Real(int column) const { return sqlite3_column_double(statement_, column); }
  std::string Text(int column) const;  // as UTF-8; or a blob as it is; NULL is ""
  base::UtcTime Time(int column) const { return base::FromUtcUs(Int(column)); }
  template <typename Enum>
  Enum As(int column) const {
    return static_cast<Enum>(Int(column));
  }
  std::optional<double> OptionalReal(int column) const;
  std::optional<base::UtcTime> OptionalTime(int column) const;

  // Parameters, from 1.
  void Bind(int index, int64_t number) { sqlite3_bind_int64(statement_, index, number); }
  void Bind(int index, int number) { sqlite3_bind_int64(statement_, index, number); }
  void Bind(int index, bool flag) { sqlite3_bind_int64(statement_, index, flag ? 1 : 0); }
  void Bind(int index, double number) { sqlite3_bind_double(statement_, index, number); }
  void Bind(int index, const std::string& text);
  void Bind(int index, const char* text) = delete;
  void Bind(int index, Blob blob);
  void Bind(int index, std::nullopt_t) { sqlite3_bind_null(statement_, index); }
  void Bind(int index, base::UtcTime time) { Bind(index, base::ToUtcUs(time)); }
  template <typename Tag>
  void Bind(int index, base::NumberId<Tag> id) {
    Bind(index, id.number());
  }
  template <typename T>
  void Bind(int index, const std::optional<T>& present) {
    present.has_value() ? Bind(index, *present) : Bind(index, std::nullopt);
  }

 private:
  sqlite3_stmt* statement_;
  GiveBack give_back_;
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_STATEMENT_H_
