#include "server/storage/writer.h"

#include <future>
#include <utility>

#include "core/base/error_detail.h"
#include "server/storage/transaction.h"

namespace axiscal::storage {

absl::Status Separate(const absl::Status& status) {
  absl::Status copy(status.code(), status.message());
  status.ForEachPayload([&](absl::string_view url, const absl::Cord& payload) {
    copy.SetPayload(url, absl::Cord(std::string(payload)));
  });
  return copy;
}

namespace {

// Of a task that met with the end of its transaction: also where it took no notice, nothing of it stands.
absl::Status UndoneOr(const absl::Status& result) {
  if (!result.ok()) return Separate(result);
  return base::Error(absl::StatusCode::kUnavailable, "undone for the sake of another write", {"STORE_BUSY", {}});
}

}  // namespace

Writer::Writer(std::unique_ptr<Connection> connection, std::function<void()> between)
    : connection_(std::move(connection)), between_(std::move(between)), thread_([this] { Loop(); }) {}

Writer::~Writer() {
  {
    const base::MutexLock lock(mutex_);
    closing_ = true;
  }
  changed_.NotifyAll();
  thread_.join();
}

absl::Status Writer::Run(Work work, Durable durable) {
  std::promise<absl::Status> promise;
  std::future<absl::Status> result = promise.get_future();
  Start(
      std::move(work), [&promise](absl::Status status) { promise.set_value(std::move(status)); }, durable);
  return result.get();
}

void Writer::Start(Work work, Done done, Durable durable) {
  {
    const base::MutexLock lock(mutex_);
    while (waiting_.size() >= kMaxWaiting) changed_.Wait(mutex_);
    waiting_.push_back({std::move(work), std::move(done), durable, absl::OkStatus()});
  }
  changed_.NotifyAll();
}

void Writer::Loop() {
  while (true) {
    std::vector<Task> group = TakeGroup();
    if (group.empty()) return;
    RunGroup(group);
    for (Task& task : group) task.done(std::move(task.result));
    if (between_) between_();
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
  absl::Status whole = RunTasks(group);
  for (int runs = 1; !whole.ok() && connection_->was_undone() && runs < kMostRuns; ++runs) whole = RunTasks(group);
  if (whole.ok()) return;
  for (Task& task : group) {
    if (task.result.ok()) task.result = Separate(whole);
  }
}

// Each task's own failure is in its result; the returned one undid them all.
absl::Status Writer::RunTasks(std::vector<Task>& group) {
  ASSIGN_OR_RETURN(Transaction transaction, Transaction::BeginWrite(*connection_));
  bool changed = false, waits = false;
  for (Task& task : group) {
    ASSIGN_OR_RETURN(Savepoint savepoint, Savepoint::Begin(*connection_));
    task.result = task.work(*connection_);
    if (!connection_->in_transaction()) return Separate(task.result);
    if (connection_->was_undone()) return UndoneOr(task.result);
    if (task.result.ok()) RETURN_IF_ERROR(savepoint.Commit());
    changed = changed || task.result.ok();
    waits = waits || (task.result.ok() && task.durable == Durable::kNow);
  }
  if (!changed) return absl::OkStatus();
  return waits ? transaction.Commit() : transaction.CommitSoon();
}

}  // namespace axiscal::storage
