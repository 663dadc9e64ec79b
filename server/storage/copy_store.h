// Carries a whole store over to another engine: from a file of SQLite to a database of PostgreSQL, or back.
#ifndef AXISCAL_SERVER_STORAGE_COPY_STORE_H_
#define AXISCAL_SERVER_STORAGE_COPY_STORE_H_

#include <functional>
#include <string>

#include "core/base/clock.h"
#include "server/storage/connection.h"

namespace axiscal::storage {

struct CopyProgress {
  std::string doing;  // "copies", "compares"
  std::string table;
  int64_t rows = 0, all_rows = 0;  // of all tables
};

struct CopyResult {
  int64_t tables = 0, rows = 0;
  int64_t rows_before = 0;  // that an earlier copy had brought
  std::string sha256;       // of all rows, read again on both sides and the same
};

// `from` and `to`: files, or URLs of PostgreSQL; no server has either meanwhile, and both stay locked. `to` is new, or
// what a copy from `from` that was broken off has left, which goes on; nobody can open it before the copy has ended.
// At the end all rows are read again on both sides and compared, and those of `to` with their checksums. Memory: some
// rows at a time. `tell` is called every some thousand rows; its error ends the copy, and is returned.
//   as opening either; FAILED_PRECONDITION SCHEMA_OLDER (`from` is to be opened by this axiscald once), COPY_NOT_EMPTY
//   (`to` holds something else), COPY_DIFFERS (`from` has changed since the copy was begun: begin again with a new
//   one); DATA_LOSS where `from` is damaged.
absl::StatusOr<CopyResult> CopyStoreTo(const std::string& from, const std::string& to, base::UtcTime now,
                                       const std::function<absl::Status(const CopyProgress&)>& tell);

// FAILED_PRECONDITION COPY_UNFINISHED: it is what a copy that was broken off has left.
absl::Status RefuseUnfinishedCopy(Connection& connection);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_COPY_STORE_H_
