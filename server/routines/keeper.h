// Runs routines: looks which of them have a new complete set of sessions, queues their jobs, and says what came out.
// One thread; every step is on the disk before the next, so that a server that is killed goes on where it was.
#ifndef AXISCAL_SERVER_ROUTINES_KEEPER_H_
#define AXISCAL_SERVER_ROUTINES_KEEPER_H_

#include <atomic>
#include <chrono>
#include <functional>
#include <set>
#include <string>
#include <thread>

#include "core/base/mutex.h"
#include "server/access/gate.h"
#include "server/jobs/job_runner.h"
#include "server/routines/judge.h"
#include "server/storage/database.h"

namespace axiscal::routines {

struct KeeperOptions {
  // How often all machines are looked at, for what time makes due and for what is tried again. > 0.
  std::chrono::milliseconds every = std::chrono::minutes(1);
  // Told of what could not be looked at; it is tried again. May be empty.
  std::function<void(const MachineId& machine, const std::string& routine, const absl::Status& status)> tell;
  // Told of each run that has ended. May be empty.
  std::function<void(const records::RoutineRun& run)> ended;
  // Where this is false, another process runs routines (Database::IsCaretaker()). Empty: true.
  std::function<bool()> is_mine;
  // Other than Judge() in tests alone.
  std::function<absl::StatusOr<Judgement>(storage::Database&, const records::CalibrationRecord&)> judge = Judge;
  base::Clock* clock = &base::SystemClock();
};

// Safe from any thread.
class Keeper {
 public:
  // All must outlive it.
  Keeper(storage::Database& database, jobs::JobRunner& jobs, const access::Gate& gate, KeeperOptions options);
  // Stops.
  ~Keeper();
  Keeper(const Keeper&) = delete;
  Keeper& operator=(const Keeper&) = delete;

  void Start();
  // Ends after what it does at this moment. Harmless when repeated, or not started.
  void Stop();
  // Looks at the machine soon: a session is complete, a job has ended, a routine was changed. Never waits.
  void LookSoon(const MachineId& machine);
  // At all of them.
  void LookAtAllSoon();

  // On this thread, for tests too. A routine that fails stops no other.
  void Look(const MachineId& machine);
  void LookAtAll();

 private:
  void Loop();
  bool GoesOn() const { return !stopping_ && (!options_.is_mine || options_.is_mine()); }
  // OK when there is nothing more to do now.
  absl::Status Follow(const records::RoutineRun& run, const records::RoutineRecord* routine);
  absl::Status Begin(const records::RoutineRecord& routine, const MachineId& machine);
  absl::Status Queue(const records::RoutineRun& run, const records::Routine& routine);
  absl::Status Conclude(const records::RoutineRun& run, const records::Routine& routine,
                        const records::CalibrationRecord& candidate);
  absl::Status End(const records::RoutineRun& run, records::RunState state, const std::string& text,
                   const std::optional<CalibrationId>& calibration = std::nullopt);
  // Why this run may not approve this calibration; empty: it may.
  absl::StatusOr<std::string> WhyNotApprove(const records::RoutineRun& run,
                                            const records::CalibrationRecord& candidate);

  storage::Database& database_;
  jobs::JobRunner& jobs_;
  const access::Gate& gate_;
  const KeeperOptions options_;
  std::atomic<bool> stopping_ = false;
  base::Mutex mutex_;
  base::CondVar changed_;
  std::set<MachineId> due_ AXISCAL_GUARDED_BY(mutex_);
  bool all_due_ AXISCAL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace axiscal::routines

#endif  // AXISCAL_SERVER_ROUTINES_KEEPER_H_
