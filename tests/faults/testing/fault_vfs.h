// A disk that goes wrong at a moment of the test's choice: SQLite's file system (VFS) with the real one below it.
#ifndef AXISCAL_TESTS_FAULTS_TESTING_FAULT_VFS_H_
#define AXISCAL_TESTS_FAULTS_TESTING_FAULT_VFS_H_

#include <cstdint>
#include <functional>

#include "tests/faults/testing/unsynced.h"

namespace axiscal::testing {

// What happens at the chosen operation.
enum class Fault {
  kNone,
  kErrorOnce,  // it fails (input/output error), the next ones work
  kFullOnce,   // it fails as on a full disk, the next ones work
  kTornOnce,   // a write leaves its first half, then as kErrorOnce
  kDead,       // it and all that follow fail
  kStaysFull,  // as kDead, as on a full disk; removals and truncations work
  kQuota,      // likewise, as where a quota is used up (EDQUOT)
  kReadOnly,   // as kDead, as on a disk that was mounted anew for reading alone (EROFS)
  kPowerLoss,  // as kDead; and of what was not synced some sectors, and the last names of files, are as before, by
               // chance
  kKill,       // this process is killed (SIGKILL) before it
};

// From now on the default of every connection of this process. Operations are writes, syncs, truncations and removals
// of all its files and openings that make one, and what the store asks the system for itself: open() of a new file,
// rename(), renameat2(), link(), unlink(), fsync() and fdatasync(), which this library takes the place of in its
// process (system_calls.cc). Syncs do not reach the real disk: what is tested is what was asked for.
void InstallFaultVfs();

// The `n`-th operation from now on, from 1, goes wrong. `seed`: of what a power loss takes.
void ArmFault(Fault fault, int64_t n, uint32_t seed);
// Nothing goes wrong any more. All connections must be closed; a power loss takes what it takes now. Whether the fault
// had come.
bool DisarmFault();
// Since ArmFault().
int64_t OperationCount();
// Whether SQLite's file system below this one works on this thread.
bool IsInFileSystem();
// What an operation asks of the disk: removals and truncations work on a full one.
enum class Asks { kRoom, kNoRoom };
// A call of the system that is the next operation: what `call` returns, or -1 with errno. `before` and `after` tell
// what a loss of power takes: before the call (taken back where it fails), and after one that did not fail.
int SystemCall(Asks asks, const std::function<int()>& call, const std::function<void(Unsynced&)>& before,
               const std::function<void(Unsynced&)>& after);

}  // namespace axiscal::testing

#endif  // AXISCAL_TESTS_FAULTS_TESTING_FAULT_VFS_H_
