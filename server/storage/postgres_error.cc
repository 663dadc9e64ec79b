#include "server/storage/postgres_error.h"

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "core/base/error_detail.h"

namespace axiscal::storage {

absl::Status PostgresError(const std::string& sqlstate, const std::string& message, const std::string& what) {
  const std::string text =
      absl::StrCat(what, ": ", message, sqlstate.empty() ? "" : absl::StrCat(" (SQLSTATE ", sqlstate, ")"));
  const auto is = [&](const std::string& start) { return absl::StartsWith(sqlstate, start); };
  const auto error = [&](absl::StatusCode code, const std::string& reason) {
    return base::Error(code, text, {reason, {}});
  };
  if (is("53100")) return error(absl::StatusCode::kResourceExhausted, "DISK_FULL");
  // Asking again does not help: somebody must change the rights, or promote the standby.
  if (is("25006") || is("42501")) return error(absl::StatusCode::kFailedPrecondition, "STORE_READ_ONLY");
  // Serialization, deadlock, a lock or a statement that took too long.
  if (is("40") || is("55P03") || is("57014")) return error(absl::StatusCode::kUnavailable, "STORE_BUSY");
  // Damage that the server has found.
  if (is("XX001") || is("XX002")) return error(absl::StatusCode::kDataLoss, "STORE_DAMAGED");
  // What no text of PostgreSQL may hold: U+0000, bytes that are no UTF-8.
  if (is("22021") || is("22P05")) return error(absl::StatusCode::kInvalidArgument, "TEXT_INVALID");
  // No connection, out of connections or memory, shutting down or starting up, input or output failed.
  if (sqlstate.empty() || is("08") || is("53") || is("57P") || is("58")) {
    return error(absl::StatusCode::kUnavailable, "STORE_DOWN");
  }
  return error(absl::StatusCode::kInternal, "STORE_BUG");
}

}  // namespace axiscal::storage
