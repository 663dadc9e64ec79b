#include "tests/faults/testing/fault_vfs.h"

#include <signal.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <random>
#include <string>
#include <utility>

#include "core/base/demand.h"
#include "core/base/mutex.h"

namespace axiscal::testing {
namespace {

// One for the process; all under the mutex.
struct Disk {
  base::Mutex mutex;
  Fault fault = Fault::kNone;
  int64_t count = 0, fails_at = 0;
  bool has_failed = false;
  uint32_t seed = 0;
  Unsynced unsynced;  // looked after where a power loss is to come
};
Disk& TheDisk() {
  static auto* const disk = new Disk;
  return *disk;
}

sqlite3_vfs* base_vfs = nullptr;
thread_local bool is_in_file_system = false;

struct File {
  sqlite3_file base;
  sqlite3_file* real;
  std::string* path;
  bool syncs_folder;  // with its first sync, as SQLite does for logs and journals that it makes
};
File& Of(sqlite3_file* file) { return *reinterpret_cast<File*>(file); }

bool Stays(Fault fault) {
  return fault == Fault::kDead || fault == Fault::kPowerLoss || fault == Fault::kStaysFull || fault == Fault::kQuota ||
         fault == Fault::kReadOnly;
}

// The errno of what fails now.
int SystemErrorOf(Fault fault) {
  switch (fault) {
    case Fault::kFullOnce:
    case Fault::kStaysFull:
      return ENOSPC;
    case Fault::kQuota:
      return EDQUOT;
    case Fault::kReadOnly:
      return EROFS;
    default:
      return EIO;
  }
}

// What the next operation is to return; SQLITE_OK: go on. `is_torn`: do the first half of it before.
int NextOperation(int error, Asks asks, bool* is_torn) AXISCAL_REQUIRES(TheDisk().mutex) {
  Disk& disk = TheDisk();
  ++disk.count;
  *is_torn = false;
  const bool was_before = disk.has_failed;
  if (!was_before && (disk.fault == Fault::kNone || disk.count != disk.fails_at)) return SQLITE_OK;
  if (was_before && !Stays(disk.fault)) return SQLITE_OK;
  disk.has_failed = true;
  if (disk.fault == Fault::kKill) kill(getpid(), SIGKILL);
  const bool needs_room = disk.fault == Fault::kStaysFull || disk.fault == Fault::kQuota;
  if (needs_room && asks == Asks::kNoRoom) return SQLITE_OK;
  *is_torn = !was_before && (disk.fault == Fault::kTornOnce || disk.fault == Fault::kPowerLoss);
  errno = SystemErrorOf(disk.fault);
  return errno == ENOSPC ? SQLITE_FULL : error;
}

bool LosesPower() AXISCAL_REQUIRES(TheDisk().mutex) { return TheDisk().fault == Fault::kPowerLoss; }

// Notes what a write over [offset, offset + count) of a file replaces.
void Note(File& file, int64_t offset, int64_t count) AXISCAL_REQUIRES(TheDisk().mutex) {
  if (!LosesPower() || file.path->empty()) return;
  Replaced replaced{offset, offset + count, 0, ""};
  sqlite3_int64 size = 0;
  file.real->pMethods->xFileSize(file.real, &size);
  replaced.old_size = size;
  const int64_t old_count = std::clamp<int64_t>(size - offset, 0, count);
  replaced.old_bytes.resize(static_cast<size_t>(old_count));
  if (old_count > 0)
    file.real->pMethods->xRead(file.real, replaced.old_bytes.data(), static_cast<int>(old_count), offset);
  TheDisk().unsynced.Wrote(*file.path, std::move(replaced));
}

int Close(sqlite3_file* file) {
  const int code = Of(file).real->pMethods->xClose(Of(file).real);
  sqlite3_free(Of(file).real);
  delete Of(file).path;
  return code;
}
int Read(sqlite3_file* file, void* bytes, int count, sqlite3_int64 offset) {
  return Of(file).real->pMethods->xRead(Of(file).real, bytes, count, offset);
}
int Write(sqlite3_file* file, const void* bytes, int count, sqlite3_int64 offset) {
  const base::MutexLock lock(TheDisk().mutex);
  bool is_torn = false;
  const int error = NextOperation(SQLITE_IOERR_WRITE, Asks::kRoom, &is_torn);
  if (error != SQLITE_OK && !is_torn) return error;
  const int written = error == SQLITE_OK ? count : count / 2;
  Note(Of(file), offset, written);
  const int code = Of(file).real->pMethods->xWrite(Of(file).real, bytes, written, offset);
  return error != SQLITE_OK ? error : code;
}
int Truncate(sqlite3_file* file, sqlite3_int64 size) {
  const base::MutexLock lock(TheDisk().mutex);
  bool is_torn = false;
  const int error = NextOperation(SQLITE_IOERR_TRUNCATE, Asks::kNoRoom, &is_torn);
  if (error != SQLITE_OK) return error;
  sqlite3_int64 old_size = 0;
  Of(file).real->pMethods->xFileSize(Of(file).real, &old_size);
  if (old_size > size) Note(Of(file), size, old_size - size);
  return Of(file).real->pMethods->xTruncate(Of(file).real, size);
}
int Sync(sqlite3_file* file, int) {
  const base::MutexLock lock(TheDisk().mutex);
  bool is_torn = false;
  const int error = NextOperation(SQLITE_IOERR_FSYNC, Asks::kRoom, &is_torn);
  if (error != SQLITE_OK) return error;
  TheDisk().unsynced.SyncedFile(*Of(file).path);
  if (std::exchange(Of(file).syncs_folder, false)) TheDisk().unsynced.SyncedFolderOf(*Of(file).path);
  return SQLITE_OK;
}
int FileSize(sqlite3_file* file, sqlite3_int64* size) {
  return Of(file).real->pMethods->xFileSize(Of(file).real, size);
}
int Lock(sqlite3_file* file, int level) { return Of(file).real->pMethods->xLock(Of(file).real, level); }
int Unlock(sqlite3_file* file, int level) { return Of(file).real->pMethods->xUnlock(Of(file).real, level); }
int CheckLock(sqlite3_file* file, int* result) {
  return Of(file).real->pMethods->xCheckReservedLock(Of(file).real, result);
}
int Control(sqlite3_file* file, int operation, void* argument) {
  return Of(file).real->pMethods->xFileControl(Of(file).real, operation, argument);
}
int SectorSize(sqlite3_file* file) { return Of(file).real->pMethods->xSectorSize(Of(file).real); }
// Nothing that would spare SQLite a write or a sync.
int Characteristics(sqlite3_file*) { return 0; }
int ShmMap(sqlite3_file* file, int page, int size, int extend, void volatile** memory) {
  return Of(file).real->pMethods->xShmMap(Of(file).real, page, size, extend, memory);
}
int ShmLock(sqlite3_file* file, int offset, int count, int flags) {
  return Of(file).real->pMethods->xShmLock(Of(file).real, offset, count, flags);
}
void ShmBarrier(sqlite3_file* file) { Of(file).real->pMethods->xShmBarrier(Of(file).real); }
int ShmUnmap(sqlite3_file* file, int remove) { return Of(file).real->pMethods->xShmUnmap(Of(file).real, remove); }

const sqlite3_io_methods kMethods = {
    2,          Close,           Read,   Write,   Truncate,   Sync,     FileSize, Lock,   Unlock, CheckLock, Control,
    SectorSize, Characteristics, ShmMap, ShmLock, ShmBarrier, ShmUnmap, nullptr,  nullptr};

int Open(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  File& opened = Of(file);
  opened.base.pMethods = nullptr;
  const base::MutexLock lock(TheDisk().mutex);
  const bool makes = (flags & SQLITE_OPEN_CREATE) != 0 && name != nullptr && access(name, F_OK) != 0;
  bool is_torn = false;
  if (makes && NextOperation(SQLITE_CANTOPEN, Asks::kRoom, &is_torn) != SQLITE_OK) return SQLITE_CANTOPEN;
  opened.real = static_cast<sqlite3_file*>(sqlite3_malloc(base_vfs->szOsFile));
  is_in_file_system = true;
  const int code = base_vfs->xOpen(base_vfs, name, opened.real, flags, out_flags);
  is_in_file_system = false;
  if (code != SQLITE_OK) {
    if (opened.real->pMethods != nullptr) opened.real->pMethods->xClose(opened.real);
    sqlite3_free(opened.real);
    return code;
  }
  opened.path = new std::string(name == nullptr ? "" : name);
  opened.syncs_folder = makes && (flags & (SQLITE_OPEN_WAL | SQLITE_OPEN_MAIN_JOURNAL)) != 0;
  if (makes && LosesPower()) TheDisk().unsynced.Made(*opened.path);
  opened.base.pMethods = &kMethods;
  return SQLITE_OK;
}
int Delete(sqlite3_vfs*, const char* name, int syncs_folder) {
  const base::MutexLock lock(TheDisk().mutex);
  bool is_torn = false;
  const int error = NextOperation(SQLITE_IOERR_DELETE, Asks::kNoRoom, &is_torn);
  if (error != SQLITE_OK) return error;
  if (LosesPower()) TheDisk().unsynced.WillRemove(name);
  is_in_file_system = true;
  const int code = base_vfs->xDelete(base_vfs, name, 0);
  is_in_file_system = false;
  if (syncs_folder != 0) TheDisk().unsynced.SyncedFolderOf(name);
  return code;
}
int Access(sqlite3_vfs*, const char* name, int flags, int* result) {
  return base_vfs->xAccess(base_vfs, name, flags, result);
}
int FullPath(sqlite3_vfs*, const char* name, int size, char* path) {
  return base_vfs->xFullPathname(base_vfs, name, size, path);
}
int Randomness(sqlite3_vfs*, int count, char* bytes) { return base_vfs->xRandomness(base_vfs, count, bytes); }
int Sleep(sqlite3_vfs*, int microseconds) { return base_vfs->xSleep(base_vfs, microseconds); }
int CurrentTime(sqlite3_vfs*, double* time) { return base_vfs->xCurrentTime(base_vfs, time); }
int LastError(sqlite3_vfs*, int size, char* text) { return base_vfs->xGetLastError(base_vfs, size, text); }
int CurrentTime64(sqlite3_vfs*, sqlite3_int64* time) { return base_vfs->xCurrentTimeInt64(base_vfs, time); }

}  // namespace

void InstallFaultVfs() {
  if (base_vfs != nullptr) return;
  base_vfs = sqlite3_vfs_find(nullptr);
  DEMAND(base_vfs != nullptr);
  static sqlite3_vfs vfs = {};
  vfs.iVersion = 2;
  vfs.szOsFile = sizeof(File);
  vfs.mxPathname = base_vfs->mxPathname;
  vfs.zName = "axiscal-faults";
  vfs.xOpen = Open;
  vfs.xDelete = Delete;
  vfs.xAccess = Access;
  vfs.xFullPathname = FullPath;
  vfs.xRandomness = Randomness;
  vfs.xSleep = Sleep;
  vfs.xCurrentTime = CurrentTime;
  vfs.xGetLastError = LastError;
  vfs.xCurrentTimeInt64 = CurrentTime64;
  DEMAND(sqlite3_vfs_register(&vfs, 1) == SQLITE_OK);
}

void ArmFault(Fault fault, int64_t n, uint32_t seed) {
  Disk& disk = TheDisk();
  const base::MutexLock lock(disk.mutex);
  disk.fault = fault;
  disk.count = 0;
  disk.fails_at = n;
  disk.has_failed = false;
  disk.seed = seed;
  disk.unsynced.Clear();
}

bool DisarmFault() {
  Disk& disk = TheDisk();
  const base::MutexLock lock(disk.mutex);
  if (disk.fault == Fault::kPowerLoss && disk.has_failed) {
    std::mt19937 random(disk.seed);
    disk.unsynced.TakeBack(random);
  }
  disk.fault = Fault::kNone;
  disk.unsynced.Clear();
  return disk.has_failed;
}

int SystemCall(Asks asks, const std::function<int()>& call, const std::function<void(Unsynced&)>& before,
               const std::function<void(Unsynced&)>& after) {
  Disk& disk = TheDisk();
  const base::MutexLock lock(disk.mutex);
  bool is_torn = false;
  if (NextOperation(SQLITE_IOERR, asks, &is_torn) != SQLITE_OK) {
    errno = SystemErrorOf(disk.fault);
    return -1;
  }
  if (LosesPower() && before) before(disk.unsynced);
  const int result = call();
  const int error = errno;
  if (LosesPower() && result < 0 && before) disk.unsynced.UndoLast();
  if (LosesPower() && result >= 0 && after) after(disk.unsynced);
  errno = error;
  return result;
}

bool IsInFileSystem() { return is_in_file_system; }

int64_t OperationCount() {
  const base::MutexLock lock(TheDisk().mutex);
  return TheDisk().count;
}

}  // namespace axiscal::testing
