// In the place of the system's own, for this program and the libraries that it loads: an operation of the disk that a
// test lets go wrong. Without a fault they do what they say, but for the syncs.
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <climits>
#include <cstdarg>
#include <cstdio>
#include <string>
#include <string_view>

#include "tests/faults/testing/fault_vfs.h"

namespace {

using axiscal::testing::Asks;
using axiscal::testing::SystemCall;
using axiscal::testing::Unsynced;

constexpr unsigned kExchange = 1u << 1;  // RENAME_EXCHANGE

bool Exists(const char* path) {
  struct stat info;
  return lstat(path, &info) == 0;
}

int Rename(const char* from, const char* to, unsigned flags) {
  const auto call = [&] { return static_cast<int>(syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, flags)); };
  if (flags == kExchange)
    return SystemCall(Asks::kRoom, call, nullptr, [&](Unsynced& unsynced) { unsynced.Exchanged(from, to); });
  return SystemCall(
      Asks::kRoom, call, [&](Unsynced& unsynced) { unsynced.WillRename(from, to); }, nullptr);
}

int Sync(int file) {
  return SystemCall(
      Asks::kRoom, [] { return 0; }, nullptr,
      [&](Unsynced& unsynced) {
        char path[PATH_MAX];
        const ssize_t size = readlink(("/proc/self/fd/" + std::to_string(file)).c_str(), path, sizeof(path));
        struct stat info;
        if (size <= 0 || fstat(file, &info) != 0) return;
        const std::string synced(path, static_cast<size_t>(size));
        S_ISDIR(info.st_mode) ? unsynced.SyncedFolder(synced) : unsynced.SyncedFile(synced);
      });
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list words;
  va_start(words, flags);
  const bool makes = (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE;
  const mode_t mode = makes ? va_arg(words, mode_t) : 0;
  va_end(words);
  const auto call = [&] { return static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, flags, mode)); };
  if ((flags & O_CREAT) == 0 || Exists(path)) return call();
  return SystemCall(Asks::kRoom, call, nullptr, [&](Unsynced& unsynced) { unsynced.Made(path); });
}
int rename(const char* from, const char* to) noexcept { return Rename(from, to, 0); }
int renameat2(int, const char* from, int, const char* to, unsigned flags) noexcept { return Rename(from, to, flags); }
int link(const char* from, const char* to) noexcept {
  return SystemCall(
      Asks::kRoom, [&] { return static_cast<int>(syscall(SYS_linkat, AT_FDCWD, from, AT_FDCWD, to, 0)); }, nullptr,
      [&](Unsynced& unsynced) { unsynced.Made(to); });
}
// SQLite's own are operations of the file system that it is given, or of the memory that processes have in common.
int unlink(const char* path) noexcept {
  const auto call = [&] { return static_cast<int>(syscall(SYS_unlinkat, AT_FDCWD, path, 0)); };
  if (axiscal::testing::IsInFileSystem() || std::string_view(path).ends_with("-shm") || !Exists(path)) return call();
  return SystemCall(
      Asks::kNoRoom, call, [&](Unsynced& unsynced) { unsynced.WillRemove(path); }, nullptr);
}
int fsync(int file) { return Sync(file); }
int fdatasync(int file) { return Sync(file); }

}  // extern "C"
