#include "server/storage/sqlite_log.h"

namespace axiscal::storage {

SqliteLog::SqliteLog(SqliteConnection& connection, const LogLimits& limits)
    : connection_(connection), limits_(limits), merge_at_pages_(limits.merge_pages) {
  sqlite3_wal_hook(
      connection_.handle(),
      [](void* pages, sqlite3*, const char*, int count) {
        *static_cast<int*>(pages) = count;
        return SQLITE_OK;
      },
      &pages_);
}

void SqliteLog::Limit() {
  if (pages_ < merge_at_pages_ || long_readers_ > 0) return;
  // A failure (disk full, a long reader) is not the callers': it is tried again when the log has grown. A backup by
  // another process reads for minutes; waiting for it after each commit would hold up all that come then.
  const bool is_long = pages_ >= limits_.max_pages;
  const bool is_merged = Merge(is_long ? SQLITE_CHECKPOINT_RESTART : SQLITE_CHECKPOINT_PASSIVE);
  merge_at_pages_ = (is_merged ? 0 : pages_) + limits_.merge_pages;
  if (is_merged) pages_ = 0;
}

// Whether all of the log is in the file.
bool SqliteLog::Merge(int mode) {
  sqlite3* const db = connection_.handle();
  sqlite3_busy_handler(
      db, [](void* log, int pauses) { return static_cast<SqliteLog*>(log)->PauseForReaders(pauses); }, this);
  int in_log = -1, merged = -1;
  const int code = sqlite3_wal_checkpoint_v2(db, nullptr, mode, &in_log, &merged);
  connection_.WaitForLocks();
  return code == SQLITE_OK && merged == in_log;
}

int SqliteLog::PauseForReaders(int pauses) {
  if (pauses >= limits_.max_pauses) return 0;
  limits_.pause();
  return 1;
}

}  // namespace axiscal::storage
