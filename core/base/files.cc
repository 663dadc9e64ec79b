#include "core/base/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>

#include "core/base/demand.h"

namespace axiscal::base {
namespace {

absl::Status Failure(const std::string& path, int error) {
  const std::string what = absl::StrCat(path, ": ", std::strerror(error));
  if (error == ENOENT) return absl::NotFoundError(what);
  if (error == ENOSPC || error == EDQUOT || error == EFBIG) return absl::ResourceExhaustedError(what);
  return absl::InvalidArgumentError(what);
}

std::string FolderOf(const std::string& path) {
  const size_t slash = path.rfind('/');
  return slash == std::string::npos ? "." : path.substr(0, slash + 1);
}

// The rename itself must reach the disk too.
void SyncFolderOf(const std::string& path) {
  const int handle = open(FolderOf(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (handle < 0) return;
  fsync(handle);
  close(handle);
}

// So many new bytes are sent to the disk while the next ones are made: Commit() waits for the last ones only. Fewer at
// a time would leave the file in many parts on the disk.
constexpr int64_t kWriteBackBytes = int64_t{8} << 20;

std::string LinkTo(int file) { return absl::StrCat("/proc/self/fd/", file); }

// A file in the folder of `path` that has no name until it is linked: a process that is killed leaves nothing. -1 where
// the file system cannot do that, or there is no way to link it.
int OpenNameless(const std::string& path) {
  const int file = open(FolderOf(path).c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
  if (file < 0) return -1;
  if (access(LinkTo(file).c_str(), F_OK) == 0) return file;
  close(file);
  return -1;
}

}  // namespace

absl::Status RequireFile(const std::string& path) {
  struct stat info;
  if (stat(path.c_str(), &info) != 0) return Failure(path, errno);
  return S_ISREG(info.st_mode) ? absl::OkStatus() : absl::InvalidArgumentError(path + ": is not a file");
}

absl::StatusOr<std::string> ReadFile(const std::string& path, size_t max_bytes) {
  RETURN_IF_ERROR(RequireFile(path));
  struct stat info;
  if (stat(path.c_str(), &info) != 0) return Failure(path, errno);
  if (static_cast<size_t>(info.st_size) > max_bytes) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": ", info.st_size, " bytes, at most ", max_bytes, " are read"));
  }
  std::ifstream in(path, std::ios::binary);
  if (!in) return Failure(path, errno);
  std::string bytes(static_cast<size_t>(info.st_size), '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (static_cast<size_t>(in.gcount()) != bytes.size()) {
    return absl::DataLossError(absl::StrCat(path, ": ", in.gcount(), " of ", bytes.size(), " bytes could be read"));
  }
  return bytes;
}

AtomicFile::~AtomicFile() {
  if (file_ >= 0) close(file_);
  if (!beside_.empty()) unlink(beside_.c_str());
}

absl::Status AtomicFile::Fail(int error) { return Failure(path_, error); }

absl::Status AtomicFile::Open(const std::string& path) {
  DEMAND(file_ < 0);
  path_ = path;
  // Of a symbolic link, what it names is replaced: /dev/stdout stays one.
  struct stat info;
  if (lstat(path.c_str(), &info) == 0 && S_ISLNK(info.st_mode)) {
    const std::unique_ptr<char, decltype(&free)> target(realpath(path.c_str(), nullptr), &free);
    if (target == nullptr) return Fail(errno);
    path_ = target.get();
  }
  // A rename over a device or a pipe would take it away from the whole computer.
  if (stat(path_.c_str(), &info) == 0 && !S_ISREG(info.st_mode))
    return absl::InvalidArgumentError(path + ": is not a file, expected one that may be replaced, or a new name");
  file_ = OpenNameless(path_);
  if (file_ >= 0) return absl::OkStatus();
  std::string beside = path_ + ".XXXXXX";
  file_ = mkostemp(beside.data(), O_CLOEXEC);
  if (file_ < 0) return Fail(errno);
  beside_ = beside;
  // mkostemp makes 0600; the file shall have the rights of any new file of this user.
  const mode_t mask = umask(0);
  umask(mask);
  return fchmod(file_, 0666 & ~mask) == 0 ? absl::OkStatus() : Fail(errno);
}

absl::Status AtomicFile::Write(std::string_view bytes) {
  DEMAND(file_ >= 0);
  for (size_t done = 0; done < bytes.size();) {
    const ssize_t wrote = write(file_, bytes.data() + done, bytes.size() - done);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) return Fail(errno);
    done += static_cast<size_t>(wrote);
  }
  written_ += static_cast<int64_t>(bytes.size());
  // Starts the disk and waits for nothing; what goes wrong with it is what fsync returns.
  if (written_ - started_ >= kWriteBackBytes) {
    sync_file_range(file_, started_, written_ - started_, SYNC_FILE_RANGE_WRITE);
    started_ = written_;
  }
  return absl::OkStatus();
}

absl::Status AtomicFile::Commit() {
  DEMAND(file_ >= 0);
  if (fsync(file_) != 0) return Fail(errno);
  // A link replaces nothing: the file gets a name beside `path_` first.
  for (int i = 0; beside_.empty(); ++i) {
    const std::string beside = absl::StrCat(path_, ".", getpid(), "-", i);
    if (linkat(AT_FDCWD, LinkTo(file_).c_str(), AT_FDCWD, beside.c_str(), AT_SYMLINK_FOLLOW) == 0) {
      beside_ = beside;
    } else if (errno != EEXIST) {
      return Fail(errno);
    }
  }
  const int file = file_;
  file_ = -1;
  if (close(file) != 0) return Fail(errno);
  if (rename(beside_.c_str(), path_.c_str()) != 0) return Fail(errno);
  beside_.clear();
  SyncFolderOf(path_);
  return absl::OkStatus();
}

absl::Status WriteFileAtomically(const std::string& path, const std::string& bytes) {
  AtomicFile file;
  RETURN_IF_ERROR(file.Open(path));
  RETURN_IF_ERROR(file.Write(bytes));
  return file.Commit();
}

}  // namespace axiscal::base
