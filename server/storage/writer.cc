#include "server/storage/writer.h"

#include <future>
#include <utility>

#include "server/storage/transaction.h"

namespace axiscal::storage {
namespace {

// A copy that shares nothing with the original: statuses go to different threads, and thread sanitizers cannot see into
// the library that counts their references.
absl::Status Separate(const absl::Status& status) {
  absl::Status copy(status.code(), status.message());
  status.ForEachPayload([&](absl::string_view url, const absl::Cord& payload) {
    copy.SetPayload(url, absl::Cord(std::string(payload)));
  });
  return copy;
}

}  // namespace

Writer::Writer(std::unique_ptr<Connection> connection, const LogLimits& limits)
    : connection_(std::move(connection)), limits_(limits), merge_at_pages_(limits.merge_pages) {
  sqlite3_wal_hook(
      connection_->handle(),
      [](void* pages, sqlite3*, const char*, int count) {
        *static_cast<int*>(pages) = count;
        return SQLITE_OK;
      },
      &log_pages_);
  thread_ = std::thread([this] { Loop(); });
}

Writer::~Writer() {
  {
    const base::MutexLock lock(mutex_);
    closing_ = true;
  }
  changed_.NotifyAll();
  thread_.join();
}

absl::Status Writer::Run(Work work) {
  std::promise<absl::Status> promise;
  std::future<absl::Status> result = promise.get_future();
  Start(std::move(work), [&promise](absl::Status status) { promise.set_value(std::move(status)); });
  return result.get();
}

void Writer::Start(Work work, Done done) {
  {
    const base::MutexLock lock(mutex_);
    while (waiting_.size() >= kMaxWaiting) changed_.Wait(mutex_);
    waiting_.push_back({std::move(work), std::move(done), absl::OkStatus()});
  }
  changed_.NotifyAll();
}

void Writer::Loop() {
  while (true) {
    std::vector<Task> group = TakeGroup();
    if (group.empty()) return;
    RunGroup(group);
    for (Task& task : group) task.done(std::move(task.result));
    LimitLog();
  }
}

std::vector<Writer::Task> Writer::TakeGroup() {
  std::vector<Task> group;
  {
    const base::MutexLock lock(mutex_);
    while (!closing_ && waiting_.empty()) changed_.Wait(mutex_);
    while (!waiting_.empty() && group.size() < kMaxGroup) {
      group.push_back(std::move(waiting_.front()));
      waiting_.pop_front();
    }
  }
  changed_.NotifyAll();
  return group;
}

void Writer::RunGroup(std::vector<Task>& group) {
  const absl::Status whole = RunTasks(group);
  if (whole.ok()) return;
  for (Task& task : group) {
    if (task.result.ok()) task.result = Separate(whole);
  }
}

// Each task's own failure is in its result; the returned one undid them all.
absl::Status Writer::RunTasks(std::vector<Task>& group) {
  ASSIGN_OR_RETURN(Transaction transaction, Transaction::BeginWrite(*connection_));
  bool changed = false;
  for (Task& task : group) {
    ASSIGN_OR_RETURN(Savepoint savepoint, Savepoint::Begin(*connection_));
    task.result = task.work(*connection_);
    if (!connection_->in_transaction()) return Separate(task.result);
    if (task.result.ok()) RETURN_IF_ERROR(savepoint.Commit());
    changed = changed || task.result.ok();
  }
  if (!changed) return absl::OkStatus();
  return transaction.Commit();
}

void Writer::LimitLog() {
  if (log_pages_ < merge_at_pages_ || long_readers_ > 0) return;
  // A failure (disk full, a long reader) is not the callers': it is tried again when the log has grown. A backup by
  // another process reads for minutes; waiting for it after each commit would hold up all that come then.
  const bool is_long = log_pages_ >= limits_.max_pages;
  const bool is_merged = Merge(is_long ? SQLITE_CHECKPOINT_RESTART : SQLITE_CHECKPOINT_PASSIVE);
  merge_at_pages_ = (is_merged ? 0 : log_pages_) + limits_.merge_pages;
  if (is_merged) log_pages_ = 0;
}

// Whether all of the log is in the file.
bool Writer::Merge(int mode) {
  sqlite3* const db = connection_->handle();
  sqlite3_busy_handler(
      db, [](void* writer, int pauses) { return static_cast<Writer*>(writer)->PauseForReaders(pauses); }, this);
  int in_log = -1, merged = -1;
  const int code = sqlite3_wal_checkpoint_v2(db, nullptr, mode, &in_log, &merged);
  connection_->WaitForLocks();
  return code == SQLITE_OK && merged == in_log;
}

int Writer::PauseForReaders(int pauses) {
  if (pauses >= limits_.max_pauses) return 0;
  limits_.pause();
  return 1;
}

}  // namespace axiscal::storage
