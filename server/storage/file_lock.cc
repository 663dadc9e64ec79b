#include "server/storage/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/base/error_detail.h"
#include "server/storage/sqlite_error.h"

namespace axiscal::storage {
namespace {

absl::Status Locked(const std::string& path, int descriptor) {
  char holder[32] = {};
  const ssize_t size = pread(descriptor, holder, sizeof(holder) - 1, 0);
  const std::string process = size > 0 ? absl::StrCat(" by process ", holder) : "";
  return base::Error(absl::StatusCode::kUnavailable, absl::StrCat(path, ": the database is in use", process),
                     {"STORE_LOCKED", {}});
}

}  // namespace

absl::StatusOr<FileLock> FileLock::Take(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor < 0 && IsNotWritable(errno)) {
    return base::Error(absl::StatusCode::kFailedPrecondition,
                       absl::StrCat(path, ": ", std::strerror(errno), "; a database is written to, also to be read"),
                       {"STORE_READ_ONLY", {}});
  }
  if (descriptor < 0) {
    return base::Error(absl::StatusCode::kUnavailable, absl::StrCat(path, ": ", std::strerror(errno)),
                       {"STORE_DOWN", {}});
  }
  FileLock lock(descriptor);
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) return Locked(path, descriptor);
  // Only informs; the lock is the flock.
  const std::string process = std::to_string(getpid());
  if (ftruncate(descriptor, 0) != 0 || pwrite(descriptor, process.data(), process.size(), 0) < 0) return lock;
  return lock;
}

FileLock::~FileLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace axiscal::storage
