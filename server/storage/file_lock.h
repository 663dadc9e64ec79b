// Keeps a second process, or a second Database of this one, off the same file.
#ifndef AXISCAL_SERVER_STORAGE_FILE_LOCK_H_
#define AXISCAL_SERVER_STORAGE_FILE_LOCK_H_

#include <string>
#include <utility>

#include "core/base/status.h"

namespace axiscal::storage {

// flock on a file beside the database: closing any descriptor of the database itself would drop SQLite's own locks.
class FileLock {
 public:
  // UNAVAILABLE STORE_LOCKED names the process that holds it; FAILED_PRECONDITION STORE_READ_ONLY.
  static absl::StatusOr<FileLock> Take(const std::string& path);
  FileLock(FileLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FileLock& operator=(FileLock&&) = delete;
  ~FileLock();

 private:
  explicit FileLock(int descriptor) : descriptor_(descriptor) {}

  int descriptor_;
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_FILE_LOCK_H_
