#include "server/storage/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <set>
#include <string_view>

#include "core/base/error_detail.h"
#include "core/base/mutex.h"
#include "server/storage/sqlite_error.h"

namespace axiscal::storage {
namespace {

// SQLite locks bytes from 2^30 on; a database never reaches this one.
constexpr off_t kLockedByte = std::numeric_limits<off_t>::max() - 1;

absl::Status Locked(const std::string& path) {
  // Who holds it stands in the file beside; through another hard link there is none.
  std::string process;
  if (const int descriptor = open((path + ".lock").c_str(), O_RDONLY | O_CLOEXEC); descriptor >= 0) {
    char holder[32] = {};
    if (pread(descriptor, holder, sizeof(holder) - 1, 0) > 0) process = absl::StrCat(" by process ", holder);
    close(descriptor);
  }
  return base::Error(absl::StatusCode::kUnavailable, absl::StrCat(path, ": the database is in use", process),
                     {"STORE_LOCKED", {}});
}

absl::Status CannotOpen(const std::string& path) {
  if (IsNotWritable(errno)) {
    return base::Error(absl::StatusCode::kFailedPrecondition,
                       absl::StrCat(path, ": ", std::strerror(errno), "; a database is written to, also to be read"),
                       {"STORE_READ_ONLY", {}});
  }
  return base::Error(absl::StatusCode::kUnavailable, absl::StrCat(path, ": ", std::strerror(errno)),
                     {"STORE_DOWN", {}});
}

absl::StatusOr<std::string> Resolve(const std::string& path) {
  char* const resolved = realpath(path.c_str(), nullptr);
  if (resolved == nullptr) return CannotOpen(path);
  std::string result = resolved;
  std::free(resolved);
  return result;
}

// False when another process has it.
absl::StatusOr<bool> LockByte(const std::string& path, int descriptor) {
  struct flock byte = {};
  byte.l_type = F_WRLCK;
  byte.l_whence = SEEK_SET;
  byte.l_start = kLockedByte;
  byte.l_len = 1;
  if (fcntl(descriptor, F_OFD_SETLK, &byte) == 0) return true;
  if (errno == EAGAIN || errno == EACCES) return false;
  return CannotOpen(path);
}

// Whether a file that is not empty is certainly no database (SQLite file format, "The Database Header").
bool IsForeign(int descriptor, off_t size) {
  constexpr std::string_view kMagic("SQLite format 3\0", 16);
  char head[kMagic.size()] = {};
  return size > 0 &&
         (pread(descriptor, head, sizeof(head), 0) != sizeof(head) || std::string_view(head, sizeof(head)) != kMagic);
}

}  // namespace

std::string KeptPath(const std::string& path) { return path + ".replaced"; }

bool IsSameFile(const std::string& a, const std::string& b) {
  struct stat of_a, of_b;
  return lstat(a.c_str(), &of_a) == 0 && lstat(b.c_str(), &of_b) == 0 && of_a.st_dev == of_b.st_dev &&
         of_a.st_ino == of_b.st_ino;
}

// The files that this process holds.
class FileLock::Held {
 public:
  // Lives as long as the program.
  static Held& Instance() {
    static auto* const held = new Held;
    return *held;
  }
  bool Add(const File& file) {
    const base::MutexLock lock(mutex_);
    return files_.insert(file).second;
  }
  void Remove(const File& file) {
    const base::MutexLock lock(mutex_);
    files_.erase(file);
  }

 private:
  base::Mutex mutex_;
  std::set<File> files_ AXISCAL_GUARDED_BY(mutex_);
};

absl::StatusOr<FileLock> FileLock::Take(const std::string& path) {
  // One at a time: what is missing here is not made by another thread meanwhile, and then held.
  static auto* const taking = new base::Mutex;
  const base::MutexLock one_at_a_time(*taking);
  struct stat info;
  if (stat(path.c_str(), &info) != 0) {
    // Also through a symbolic link to a file that is not there yet.
    const int made = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (made < 0) return CannotOpen(path);
    close(made);
    if (stat(path.c_str(), &info) != 0) return CannotOpen(path);
  }
  FileLock lock;
  ASSIGN_OR_RETURN(lock.path_, Resolve(path));
  const File file = {info.st_dev, info.st_ino};
  if (!Held::Instance().Add(file)) return Locked(lock.path_);
  lock.file_ = file;
  lock.descriptor_ = open(lock.path_.c_str(), O_RDWR | O_CLOEXEC);
  if (lock.descriptor_ < 0) return CannotOpen(lock.path_);
  ASSIGN_OR_RETURN(const bool is_ours, LockByte(lock.path_, lock.descriptor_));
  if (!is_ours) return Locked(lock.path_);
  if (info.st_nlink > 1 && IsSameFile(lock.path_, KeptPath(lock.path_))) {
    if (unlink(KeptPath(lock.path_).c_str()) != 0 || stat(lock.path_.c_str(), &info) != 0)
      return CannotOpen(lock.path_);
  }
  if (info.st_nlink > 1) {
    return base::Error(absl::StatusCode::kFailedPrecondition,
                       absl::StrCat(lock.path_, ": the file has ", info.st_nlink,
                                    " names (hard links), and its log stands beside one of them only: keep the name "
                                    "under which it was used last (find / -samefile) and remove the others"),
                       {"STORE_LINKED", {}});
  }
  const std::string beside = lock.path_ + ".lock";
  const bool is_foreign = IsForeign(lock.descriptor_, info.st_size);
  lock.beside_descriptor_ = open(beside.c_str(), O_RDWR | O_CLOEXEC | (is_foreign ? 0 : O_CREAT), 0600);
  if (lock.beside_descriptor_ < 0 && is_foreign && errno == ENOENT) return lock;
  if (lock.beside_descriptor_ < 0) return CannotOpen(beside);
  if (flock(lock.beside_descriptor_, LOCK_EX | LOCK_NB) != 0) return Locked(lock.path_);
  // Only informs.
  const std::string process = std::to_string(getpid());
  if (ftruncate(lock.beside_descriptor_, 0) != 0 ||
      pwrite(lock.beside_descriptor_, process.data(), process.size(), 0) < 0) {
    return lock;
  }
  return lock;
}

FileLock::~FileLock() {
  if (beside_descriptor_ >= 0) close(beside_descriptor_);
  if (descriptor_ >= 0) close(descriptor_);
  if (file_ != File{}) Held::Instance().Remove(file_);
}

}  // namespace axiscal::storage
