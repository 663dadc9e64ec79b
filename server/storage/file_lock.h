// Keeps a second process, or a second Database of this one, off the same file, by whichever name it is opened.
#ifndef AXISCAL_SERVER_STORAGE_FILE_LOCK_H_
#define AXISCAL_SERVER_STORAGE_FILE_LOCK_H_

#include <sys/types.h>

#include <string>
#include <utility>

#include "core/base/status.h"

namespace axiscal::storage {

// Where a restore keeps what was at `path` before: "PATH.replaced".
std::string KeptPath(const std::string& path);

// Whether both are names of one file.
bool IsSameFile(const std::string& a, const std::string& b);

// Two locks: an OFD lock on the last possible byte of the database file itself, which no other name of the file gets
// round and which is far from the bytes that SQLite locks; and an flock on "FILE.lock" beside it, which tells the
// process that holds it and which versions before this one know.
//
// Closing any descriptor of the database drops the POSIX locks that SQLite has in this process. So the file is not
// opened when this process holds it already, and the lock is to be released after the last connection.
class FileLock {
 public:
  // Of the database at `path`, which is made, empty, when it is missing. What is no database gets no "FILE.lock".
  //   UNAVAILABLE STORE_LOCKED names the process that holds it, if it can; FAILED_PRECONDITION STORE_READ_ONLY;
  //   FAILED_PRECONDITION STORE_LINKED for a file with hard links: SQLite's log stands beside one of its names, and
  //   opened by another the file lacks what was written last. A second name that a restore was killed over (KeptPath())
  //   is taken away.
  static absl::StatusOr<FileLock> Take(const std::string& path);
  FileLock(FileLock&& other) noexcept
      : path_(std::move(other.path_)),
        file_(std::exchange(other.file_, {})),
        descriptor_(std::exchange(other.descriptor_, -1)),
        beside_descriptor_(std::exchange(other.beside_descriptor_, -1)) {}
  FileLock& operator=(FileLock&&) = delete;
  ~FileLock();

  // Where the file is, symbolic links resolved: by this name SQLite is to open it.
  const std::string& path() const { return path_; }

 private:
  // What a file is under every name.
  struct File {
    dev_t device = 0;
    ino_t number = 0;

    auto operator<=>(const File&) const = default;
  };
  class Held;

  FileLock() = default;

  std::string path_;
  File file_;
  int descriptor_ = -1;         // of the database
  int beside_descriptor_ = -1;  // of "FILE.lock"
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_FILE_LOCK_H_
