// Which files of a folder are whole, and which of them are new: by looking again, as folders of other machines (SMB,
// NFS) tell nothing of their changes.
#ifndef AXISCAL_CLIENT_CELL_WATCHER_H_
#define AXISCAL_CLIENT_CELL_WATCHER_H_

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "client/cell/config.h"
#include "core/base/clock.h"

namespace axiscal::cell {

// How a file looked.
struct Look {
  int64_t size_bytes = 0;
  int64_t changed_ns = 0;  // as its file system says; only whether it is the same counts

  bool operator==(const Look&) const = default;
};

// Of files that are in the spool, or were: by path, how they looked then. A text of it survives restarts; without it
// every file is read again, and the spool or the server knows it by its content.
using KnownFiles = std::map<std::string, Look>;
std::string WriteKnown(const KnownFiles& known);
// Nothing where it is none.
KnownFiles ReadKnown(const std::string& text);

// What one look through a folder found.
struct Found {
  std::vector<std::string> whole;  // paths, oldest first
  std::vector<Look> looks;         // of each: how it has looked for `settle`
  int growing = 0;                 // files that are not whole yet
  int without_end = 0;             // of them such as have not changed for long, but lack their last line
  int links = 0;                   // symbolic links, which may lead anywhere: not followed
  absl::Status status;             // of reading the folder
};

// The bytes of a file that still looks as it did when it was found whole, before they are read and after. UNAVAILABLE:
// it has gone, is another one, or is being written again: it was not whole. Other errors are those of reading it.
absl::StatusOr<std::string> ReadAsFound(const std::string& path, const Look& look);

class FolderWatcher {
 public:
  FolderWatcher(const Watch& watch, std::chrono::milliseconds settle) : watch_(watch), settle_(settle) {}

  // Files whose look is another than `known` says, and that have looked the same for `settle`; their names begin with
  // no point and end in no .tmp, .part or ~. Files that are gone are forgotten, in `known` as well.
  Found LookThrough(base::SteadyTime now, KnownFiles& known);
  // How a path looks now; size -1 where there is no file. Links are not followed.
  static Look LookAt(const std::string& path);

  const Watch& watch() const { return watch_; }

 private:
  struct Seen {
    Look look;
    base::SteadyTime since;
  };
  bool IsMeant(const std::string& name) const;
  bool HasEnd(const std::string& path) const;

  const Watch watch_;
  const std::chrono::milliseconds settle_;
  std::map<std::string, Seen> seen_;  // that are not whole yet
};

}  // namespace axiscal::cell

#endif  // AXISCAL_CLIENT_CELL_WATCHER_H_
