// What axiscal-cell does again and again: looks through its folders, spools what is whole and new, sends what waits. A
// thread of its own says how it stands, to the status file and to the service, also while a round takes long.
#ifndef AXISCAL_CLIENT_CELL_CELL_H_
#define AXISCAL_CLIENT_CELL_CELL_H_

#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "client/cell/config.h"
#include "client/cell/status.h"
#include "client/cell/watcher.h"
#include "client/client.h"
#include "client/spool/sender.h"
#include "client/spool/spool.h"
#include "core/base/mutex.h"

namespace axiscal::cell {

// The longest wait of one attempt after so many failures: doubles from the first to the last.
std::chrono::milliseconds LongestWait(const Config& config, int failures);

class Cell {
 public:
  // The spool is made where it is missing; the server need not be there.
  static absl::StatusOr<std::unique_ptr<Cell>> Create(const Config& config);
  ~Cell();
  Cell(const Cell&) = delete;
  Cell& operator=(const Cell&) = delete;

  // One round, at most about as long as the pause between two. `stops` is asked between files. Errors stand in the
  // status file.
  void Step(const std::function<bool()>& stops);
  // Until the next round.
  std::chrono::milliseconds Pause() const;

  const Status& status() const { return status_; }

 private:
  Cell(Config config, spool::Spool spool, client::Client client, client::Client reporter);
  void Look();
  absl::Status TakeIn(const Watch& watch, const std::string& path, const axiscal::cell::Look& look);
  void Send(const std::function<bool()>& stops);
  void Wait(const absl::Status& why, bool is_later);
  // A wait by chance after so many failures.
  std::chrono::milliseconds WaitAfter(int failures);
  // From now on it does this; empty: nothing.
  void Do(const std::string& what);
  // What the status says from now on, and writes it; alarms that are new go into the log.
  void Report();
  void Tell();  // the thread's loop
  void TellService(const Status& status);
  absl::Status WriteFile(const Status& status) const;

  const Config config_;
  spool::Spool spool_;
  client::Client client_;
  client::Client reporter_;  // the thread's, which does not wait long
  spool::Sender sender_;
  std::optional<spool::SenderLock> lock_;
  std::vector<FolderWatcher> watchers_;
  KnownFiles known_;
  std::string known_text_;  // as the file has it
  std::set<std::string> said_;  // alarms that the log has
  std::mt19937_64 random_;
  int failures_ = 0;
  base::SteadyTime next_attempt_;
  // Files of machines that the caller may not bring are passed over until then.
  absl::Status held_;
  int times_held_ = 0;
  base::SteadyTime next_held_;
  Status status_;

  base::Mutex mutex_;
  base::CondVar wakes_;
  Status told_ AXISCAL_GUARDED_BY(mutex_);
  std::string not_told_ AXISCAL_GUARDED_BY(mutex_);
  bool is_over_ AXISCAL_GUARDED_BY(mutex_) = false;
  std::thread teller_;
};

}  // namespace axiscal::cell

#endif  // AXISCAL_CLIENT_CELL_CELL_H_
