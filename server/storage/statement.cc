#include "server/storage/statement.h"

#include <cerrno>

#include "core/base/utf8.h"
#include "server/storage/sqlite_error.h"

namespace axiscal::storage {

Statement::~Statement() {
  if (statement_ == nullptr) return;
  sqlite3_reset(statement_);
  sqlite3_clear_bindings(statement_);
  give_back_(statement_);
}

absl::StatusOr<bool> Statement::Step() {
  errno = 0;  // SqliteError() tells a full disk by it
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  return SqliteError(sqlite3_db_handle(statement_), sqlite3_sql(statement_));
}

std::string Statement::Text(int column) const {
  const void* bytes = sqlite3_column_blob(statement_, column);
  const int size = sqlite3_column_bytes(statement_, column);
  std::string text = size > 0 ? std::string(static_cast<const char*>(bytes), size) : std::string();
  // Earlier versions let callers store what is no UTF-8; one such text in an answer would spoil all of it.
  return sqlite3_column_type(statement_, column) == SQLITE_TEXT ? base::ToUtf8(std::move(text)) : text;
}

std::optional<double> Statement::OptionalReal(int column) const {
  return IsNull(column) ? std::nullopt : std::optional<double>(Real(column));
}

std::optional<base::UtcTime> Statement::OptionalTime(int column) const {
  return IsNull(column) ? std::nullopt : std::optional<base::UtcTime>(Time(column));
}

void Statement::Bind(int index, const std::string& text) {
  sqlite3_bind_text64(statement_, index, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
}

void Statement::Bind(int index, Blob blob) {
  sqlite3_bind_blob64(statement_, index, blob.bytes.empty() ? "" : blob.bytes.data(), blob.bytes.size(), SQLITE_STATIC);
}

}  // namespace axiscal::storage
