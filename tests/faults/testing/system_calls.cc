// In the place of the system's own, for this program and the libraries that it loads: an operation of the disk that a
// test lets go wrong. Without a fault they do what they say, but for the syncs.
#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "tests/faults/testing/fault_vfs.h"

namespace {

bool Fails() {
  const int error = axiscal::testing::NextSystemCall();
  if (error != 0) errno = error;
  return error != 0;
}

}  // namespace

extern "C" {

int rename(const char* from, const char* to) noexcept {
  return Fails() ? -1 : static_cast<int>(syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}
int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) noexcept {
  return Fails() ? -1 : static_cast<int>(syscall(SYS_renameat2, from_folder, from, to_folder, to, flags));
}
int fsync(int) { return Fails() ? -1 : 0; }
int fdatasync(int) { return Fails() ? -1 : 0; }

}  // extern "C"
