// Looks at machines and raises and clears their events: soon after something was stored or approved, by time for what
// is missed or old, and when a server starts for what changed before it stopped. One thread; what it has stored is
// there after a crash, and what it had not is looked at again.
#ifndef AXISCAL_SERVER_WATCH_WATCHER_H_
#define AXISCAL_SERVER_WATCH_WATCHER_H_

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <thread>

#include "core/base/mutex.h"
#include "server/storage/database.h"
#include "server/watch/event_board.h"

namespace axiscal::watch {

struct WatcherOptions {
  // Of axiscal: another version looks at every machine again.
  std::string version;
  // How often it is looked what has become old or missed. > 0.
  std::chrono::milliseconds every = std::chrono::minutes(1);
  // Told of what could not be looked at. May be empty.
  std::function<void(const MachineId& machine, const absl::Status& status)> tell;
  // Where this is false, another process looks at machines (Database::IsCaretaker()). Empty: true.
  std::function<bool()> is_mine;
  base::Clock* clock = &base::SystemClock();
};

// Safe from any thread.
class Watcher {
 public:
  // `database` must outlive it.
  Watcher(storage::Database& database, std::shared_ptr<EventBoard> board, WatcherOptions options);
  // Stops.
  ~Watcher();
  Watcher(const Watcher&) = delete;
  Watcher& operator=(const Watcher&) = delete;

  void Start();
  // Looks at what LookSoon() has named and was not looked at yet, for at most `patience`; then gives up the look that
  // runs. So a command line that approves and ends leaves the events behind that follow. Harmless when repeated, or not
  // started.
  void Stop(std::chrono::milliseconds patience = std::chrono::seconds(2));
  // Looks at the machine soon. Never waits.
  void LookSoon(const MachineId& machine);

  // On this thread, for tests too: at one machine; at all that it is time for.
  absl::Status Look(const MachineId& machine);
  void LookAtAll();

 private:
  void Loop();
  // At the machines that LookSoon() has named.
  void LookAtDue();
  bool IsMine() const { return !options_.is_mine || options_.is_mine(); }

  storage::Database& database_;
  const std::shared_ptr<EventBoard> board_;
  const WatcherOptions options_;
  std::atomic<bool> finishing_ = false;  // begins nothing new but what is due
  std::atomic<bool> stopping_ = false;   // gives up what it does
  base::Mutex mutex_;
  base::CondVar changed_;
  std::set<MachineId> due_ AXISCAL_GUARDED_BY(mutex_);
  bool has_ended_ AXISCAL_GUARDED_BY(mutex_) = true;
  std::thread thread_;
};

}  // namespace axiscal::watch

#endif  // AXISCAL_SERVER_WATCH_WATCHER_H_
