// Whole files in and out.
#ifndef AXISCAL_CORE_BASE_FILES_H_
#define AXISCAL_CORE_BASE_FILES_H_

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/status.h"

namespace axiscal::base {

// NOT_FOUND when there is none, INVALID_ARGUMENT when it is a folder, a device or a pipe (which would be waited for, or
// can be read once only).
absl::Status RequireFile(const std::string& path);

// The file's bytes. NOT_FOUND when there is none; INVALID_ARGUMENT when it is no file or has more than `max_bytes`
// (refused before reading).
absl::StatusOr<std::string> ReadFile(const std::string& path, size_t max_bytes);

// A file that takes its place only when it is whole: written beside `path`, synced and renamed over it by Commit().
// Until then, after an error and after a crash `path` is what it was, and nothing is left beside it: what is written
// has no name before Commit() where the file system can do that (O_TMPFILE), else the destructor removes it. Errors:
// NOT_FOUND (no such folder), RESOURCE_EXHAUSTED (full disk), INVALID_ARGUMENT (any other, with the reason; also a path
// that is a folder, device or pipe).
class AtomicFile {
 public:
  AtomicFile() = default;
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  absl::Status Open(const std::string& path);
  absl::Status Write(std::string_view bytes);
  absl::Status Commit();

 private:
  absl::Status Fail(int error);

  std::string path_, beside_;  // beside_: empty when there is nothing to remove, or no name yet
  int file_ = -1;
  int64_t written_ = 0, started_ = 0;  // bytes written, and of them on their way to the disk
};

absl::Status WriteFileAtomically(const std::string& path, const std::string& bytes);

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_FILES_H_
