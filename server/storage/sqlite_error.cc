#include "server/storage/sqlite_error.h"

#include <cerrno>

#include "core/base/error_detail.h"

namespace axiscal::storage {
namespace {

bool IsDiskFull(int code, int system_error) {
  // A file-size limit or quota shows as a failed write, only errno tells why.
  return code == SQLITE_FULL ||
         (code == SQLITE_IOERR && (system_error == ENOSPC || system_error == EFBIG || system_error == EDQUOT));
}

}  // namespace

bool IsNotWritable(int system_error) {
  return system_error == EACCES || system_error == EPERM || system_error == EROFS;
}

absl::Status SqliteError(sqlite3* db, const std::string& what) {
  // A failed COMMIT leaves sqlite3_system_errno at 0; Statement::Step() cleared errno before it.
  const int left_errno = errno;
  if (db == nullptr) return base::Error(absl::StatusCode::kUnavailable, what + ": out of memory", {"STORE_DOWN", {}});
  const int extended = sqlite3_extended_errcode(db);
  const int code = extended & 0xff;
  const int system_error = sqlite3_system_errno(db) != 0 ? sqlite3_system_errno(db) : left_errno;
  const std::string message = absl::StrCat(what, ": ", sqlite3_errmsg(db), " (SQLite result ", extended, ", errno ",
                                           sqlite3_system_errno(db), ")");
  if (IsDiskFull(code, system_error)) {
    return base::Error(absl::StatusCode::kResourceExhausted, message, {"DISK_FULL", {}});
  }
  // Asking again does not help: somebody must change the rights.
  if (code == SQLITE_READONLY || code == SQLITE_PERM || (code == SQLITE_CANTOPEN && IsNotWritable(system_error))) {
    return base::Error(absl::StatusCode::kFailedPrecondition, message, {"STORE_READ_ONLY", {}});
  }
  switch (code) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return base::Error(absl::StatusCode::kUnavailable, message, {"STORE_BUSY", {}});
    case SQLITE_NOTADB:
      return base::Error(absl::StatusCode::kFailedPrecondition, message, {"NOT_A_DATABASE", {}});
    case SQLITE_CORRUPT:
      return base::Error(absl::StatusCode::kDataLoss, message, {"STORE_DAMAGED", {}});
    case SQLITE_IOERR:
    case SQLITE_CANTOPEN:
    case SQLITE_NOMEM:
      return base::Error(absl::StatusCode::kUnavailable, message, {"STORE_DOWN", {}});
    default:
      return base::Error(absl::StatusCode::kInternal, message, {"STORE_BUG", {}});
  }
}

}  // namespace axiscal::storage
