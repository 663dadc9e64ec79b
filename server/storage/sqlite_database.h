// The embedded store: one SQLite file in WAL mode, one process at a time.
#ifndef AXISCAL_SERVER_STORAGE_SQLITE_DATABASE_H_
#define AXISCAL_SERVER_STORAGE_SQLITE_DATABASE_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/base/clock.h"
#include "server/storage/database.h"

namespace axiscal::storage {

// What must stay free on the disk, or what grows is refused (DISK_LOW).
inline constexpr int64_t kMinFreeBytes = int64_t{64} << 20;

struct SqliteOptions {
  // The database file; made when it is not there. "FILE-wal", "FILE-shm" and "FILE.lock" stand beside it; through a
  // symbolic link, beside the file that it leads to.
  std::string path;
  // Refuse growing writes below this much free disk, so that ending, aborting and cleaning up still work.
  int64_t min_free_bytes = kMinFreeBytes;
  // Free bytes on the disk of the file; empty: ask the file system.
  std::function<int64_t()> free_bytes;
  // Told on open, for each job that a process left RUNNING when it died, what became of it. May be empty.
  std::function<void(const JobRecord&)> rescued;
  // Told of what the disk has changed: where a caller sends the same again (a session is made anew, a program gets the
  // parts that came), and once of each row that histories leave out. From the calling threads. May be empty.
  std::function<void(const absl::Status&)> damaged;
  base::Clock* clock = &base::SystemClock();
};

// Opens, locks and migrates the file (made for its owner alone, 0600), and returns RUNNING jobs of a process that died
// to the queue.
//   held by another process or Database, under whichever name: UNAVAILABLE STORE_LOCKED; a file with several names
//   (hard links): FAILED_PRECONDITION STORE_LINKED; written by a newer version, or not ours: FAILED_PRECONDITION
//   SCHEMA_NEWER, NOT_A_DATABASE, SCHEMA_CHANGED; the file is left as it was.
// Ignores SIGXFSZ in this process: a file-size limit is then an error of the write instead of death.
// The database is closed, with the log merged, when it is destroyed; no call may be under way then.
absl::StatusOr<std::unique_ptr<Database>> OpenSqlite(const SqliteOptions& options);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_SQLITE_DATABASE_H_
