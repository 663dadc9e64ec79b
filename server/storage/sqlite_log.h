// The log of a SQLite file (FILE-wal), merged into the file as it grows.
#ifndef AXISCAL_SERVER_STORAGE_SQLITE_LOG_H_
#define AXISCAL_SERVER_STORAGE_SQLITE_LOG_H_

#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

#include "server/storage/sqlite_connection.h"

namespace axiscal::storage {

// When the log is merged into the file, in pages of 4096 bytes. Readers, a backup among them, keep what they
// may still read from being merged; commits never wait for that longer than `max_pauses` pauses for each `merge_pages`
// that were written meanwhile.
struct LogLimits {
  int merge_pages = 4096;  // 16 MB: merged as far as readers allow, and again after each so many more
  int max_pages = 16384;   // 64 MB: short readers are waited for, so that the log begins anew
  int max_pauses = 20;     // 0.1 s in all: our own reads take milliseconds
  std::function<void()> pause = [] { std::this_thread::sleep_for(std::chrono::milliseconds(5)); };
};

class SqliteLog {
 public:
  // `connection`, the one that writes, must not commit any more when this has gone.
  explicit SqliteLog(SqliteConnection& connection, const LogLimits& limits = {});
  SqliteLog(const SqliteLog&) = delete;
  SqliteLog& operator=(const SqliteLog&) = delete;

  // Merges what is to be merged by now. Between transactions of the connection, on its thread.
  void Limit();

  // While one lives, somebody reads one state for long, behind which nothing can be merged: the log grows instead. On
  // any thread.
  class LongReader {
   public:
    explicit LongReader(SqliteLog& log) : log_(log) { ++log_.long_readers_; }
    ~LongReader() { --log_.long_readers_; }
    LongReader(const LongReader&) = delete;
    LongReader& operator=(const LongReader&) = delete;

   private:
    SqliteLog& log_;
  };

 private:
  bool Merge(int mode);
  int PauseForReaders(int pauses);

  SqliteConnection& connection_;
  const LogLimits limits_;
  std::atomic<int> long_readers_ = 0;
  int pages_ = 0;           // in the log
  int merge_at_pages_ = 0;  // not before the log has so many
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_SQLITE_LOG_H_
