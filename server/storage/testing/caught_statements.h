// What SQLite was asked while this lives, by all connections that are opened meanwhile.
#ifndef AXISCAL_SERVER_STORAGE_TESTING_CAUGHT_STATEMENTS_H_
#define AXISCAL_SERVER_STORAGE_TESTING_CAUGHT_STATEMENTS_H_

#include <sqlite3.h>

#include <algorithm>
#include <map>
#include <string>

#include "core/base/mutex.h"

namespace axiscal::storage {

// One at a time.
class CaughtStatements {
 public:
  CaughtStatements() {
    present = this;
    sqlite3_auto_extension(reinterpret_cast<void (*)()>(&Watch));
  }
  ~CaughtStatements() { sqlite3_cancel_auto_extension(reinterpret_cast<void (*)()>(&Watch)); }
  CaughtStatements(const CaughtStatements&) = delete;

  // By statement: the most steps of SQLite's virtual machine that one run of it took.
  std::map<std::string, int> most_steps() {
    const base::MutexLock lock(mutex_);
    return most_steps_;
  }
  // Of all statements that have ended.
  int64_t steps() {
    const base::MutexLock lock(mutex_);
    return steps_;
  }

 private:
  static int Watch(sqlite3* db, char**, const sqlite3_api_routines*) {
    return sqlite3_trace_v2(db, SQLITE_TRACE_PROFILE, &Ended, nullptr);
  }
  static int Ended(unsigned, void*, void* statement, void*) {
    auto* const ended = static_cast<sqlite3_stmt*>(statement);
    const int steps = sqlite3_stmt_status(ended, SQLITE_STMTSTATUS_VM_STEP, 1);
    const base::MutexLock lock(present->mutex_);
    int& most = present->most_steps_[sqlite3_sql(ended)];
    most = std::max(most, steps);
    present->steps_ += steps;
    return 0;
  }

  static inline CaughtStatements* present = nullptr;
  base::Mutex mutex_;
  std::map<std::string, int> most_steps_ AXISCAL_GUARDED_BY(mutex_);
  int64_t steps_ AXISCAL_GUARDED_BY(mutex_) = 0;
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_TESTING_CAUGHT_STATEMENTS_H_
