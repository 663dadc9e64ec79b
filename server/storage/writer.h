// The one writing connection and its thread. Writes that wait together share one transaction and one fsync (group
// commit); each is a savepoint of its own, so one that fails leaves the others alone.
#ifndef AXISCAL_SERVER_STORAGE_WRITER_H_
#define AXISCAL_SERVER_STORAGE_WRITER_H_

#include <deque>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "core/base/mutex.h"
#include "server/storage/connection.h"

namespace axiscal::storage {

// A copy that shares nothing with the original: statuses go to different threads, and thread sanitizers cannot see into
// the library that counts their references.
absl::Status Separate(const absl::Status& status);

// Safe from any thread.
class Writer {
 public:
  // Changes rows; anything but OK undoes them. Runs on the writer's thread, and again where the engine undid a group
  // for another's sake (Connection::was_undone()).
  using Work = std::function<absl::Status(Connection&)>;
  // Told once, on the writer's thread, in order of submission, after COMMIT or failure.
  using Done = std::function<void(absl::Status)>;

  // `between`, which may be empty, is called on the writer's thread after each group was answered.
  explicit Writer(std::unique_ptr<Connection> connection, std::function<void()> between = {});
  // Does what waits, joins, closes the connection.
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  // How often a group is run that is undone for another's sake: more than once in a row is rare.
  static constexpr int kMostRuns = 4;

  // kNow: durable when it is told as done. kSoon: shortly after (Connection::CommitSoon()), for what nobody is
  // promised.
  enum class Durable { kNow, kSoon };
  absl::Status Run(Work work, Durable durable = Durable::kNow);
  // Blocks only while kMaxWaiting writes wait.
  void Start(Work work, Done done, Durable durable = Durable::kNow);

 private:
  struct Task {
    Work work;
    Done done;
    Durable durable = Durable::kNow;
    absl::Status result;
  };
  static constexpr size_t kMaxWaiting = 256;
  static constexpr size_t kMaxGroup = 32;

  void Loop();
  std::vector<Task> TakeGroup();
  void RunGroup(std::vector<Task>& group);
  absl::Status RunTasks(std::vector<Task>& group);

  const std::unique_ptr<Connection> connection_;  // used by thread_ alone
  const std::function<void()> between_;
  base::Mutex mutex_;
  base::CondVar changed_;
  std::deque<Task> waiting_ AXISCAL_GUARDED_BY(mutex_);
  bool closing_ AXISCAL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_WRITER_H_
