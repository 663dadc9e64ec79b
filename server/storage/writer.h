// The one writing connection and its thread. Writes that wait together share one transaction and one fsync (group
// commit); each is a savepoint of its own, so one that fails leaves the others alone.
#ifndef AXISCAL_SERVER_STORAGE_WRITER_H_
#define AXISCAL_SERVER_STORAGE_WRITER_H_

#include <atomic>
#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "core/base/mutex.h"
#include "server/storage/connection.h"

namespace axiscal::storage {

// When the log (FILE-wal) is merged into the file, in pages of 4096 bytes. Readers, a backup among them, keep what they
// may still read from being merged; commits never wait for that longer than `max_pauses` pauses for each `merge_pages`
// that were written meanwhile.
struct LogLimits {
  int merge_pages = 4096;  // 16 MB: merged as far as readers allow, and again after each so many more
  int max_pages = 16384;   // 64 MB: short readers are waited for, so that the log begins anew
  int max_pauses = 20;     // 0.1 s in all: our own reads take milliseconds
  std::function<void()> pause = [] { std::this_thread::sleep_for(std::chrono::milliseconds(5)); };
};

// Safe from any thread.
class Writer {
 public:
  // Changes rows; anything but OK undoes them. Runs on the writer's thread.
  using Work = std::function<absl::Status(Connection&)>;
  // Told once, on the writer's thread, in order of submission, after COMMIT or failure.
  using Done = std::function<void(absl::Status)>;

  explicit Writer(std::unique_ptr<Connection> connection, const LogLimits& limits = {});
  // Does what waits, merges the log, joins.
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  // While one lives, somebody reads one state for long, behind which nothing can be merged: the log grows instead.
  class LongReader {
   public:
    explicit LongReader(Writer& writer) : writer_(writer) { ++writer_.long_readers_; }
    ~LongReader() { --writer_.long_readers_; }
    LongReader(const LongReader&) = delete;
    LongReader& operator=(const LongReader&) = delete;

   private:
    Writer& writer_;
  };

  // Durable when it returns OK.
  absl::Status Run(Work work);
  // Blocks only while kMaxWaiting writes wait.
  void Start(Work work, Done done);

 private:
  struct Task {
    Work work;
    Done done;
    absl::Status result;
  };
  static constexpr size_t kMaxWaiting = 256;
  static constexpr size_t kMaxGroup = 32;

  void Loop();
  std::vector<Task> TakeGroup();
  void RunGroup(std::vector<Task>& group);
  absl::Status RunTasks(std::vector<Task>& group);
  void LimitLog();
  bool Merge(int mode);
  int PauseForReaders(int pauses);

  const std::unique_ptr<Connection> connection_;  // used by thread_ alone
  const LogLimits limits_;
  std::atomic<int> long_readers_ = 0;
  int log_pages_ = 0;       // in the WAL; thread_ alone
  int merge_at_pages_ = 0;  // not before the WAL has so many; thread_ alone
  base::Mutex mutex_;
  base::CondVar changed_;
  std::deque<Task> waiting_ AXISCAL_GUARDED_BY(mutex_);
  bool closing_ AXISCAL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_WRITER_H_
