// What axiscal-cell does again and again: looks through its folders, spools what is whole and new, sends what waits,
// and says how it stands.
#ifndef AXISCAL_CLIENT_CELL_CELL_H_
#define AXISCAL_CLIENT_CELL_CELL_H_

#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "client/cell/config.h"
#include "client/cell/status.h"
#include "client/cell/watcher.h"
#include "client/client.h"
#include "client/spool/sender.h"
#include "client/spool/spool.h"

namespace axiscal::cell {

// The longest wait of one attempt after so many failures: doubles from the first to the last.
std::chrono::milliseconds LongestWait(const Config& config, int failures);

class Cell {
 public:
  // The spool is made where it is missing; the server need not be there.
  static absl::StatusOr<std::unique_ptr<Cell>> Create(const Config& config);

  // One round, at most about as long as the pause between two. `stops` is asked between files. Errors stand in the
  // status file.
  void Step(const std::function<bool()>& stops);
  // Until the next round.
  std::chrono::milliseconds Pause() const;

  const Status& status() const { return status_; }

 private:
  Cell(Config config, spool::Spool spool, client::Client client);
  void Look();
  absl::Status TakeIn(const Watch& watch, const std::string& path);
  void Send(const std::function<bool()>& stops);
  void Wait(const absl::Status& why);
  void Report();

  const Config config_;
  spool::Spool spool_;
  client::Client client_;
  spool::Sender sender_;
  std::optional<spool::SenderLock> lock_;
  std::vector<FolderWatcher> watchers_;
  KnownFiles known_;
  std::string known_text_;  // as the file has it
  std::mt19937_64 random_;
  int failures_ = 0;
  base::SteadyTime next_attempt_;
  Status status_;
};

}  // namespace axiscal::cell

#endif  // AXISCAL_CLIENT_CELL_CELL_H_
