// Whole copies of a database: made while it is written to, put in the place of another, or written anew without the
// space that what was removed has left.
#ifndef AXISCAL_SERVER_STORAGE_BACKUP_H_
#define AXISCAL_SERVER_STORAGE_BACKUP_H_

#include <functional>
#include <string>

#include "core/base/status.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// Copies what the database at `source` is at this moment into a new file `path` (for its owner alone, 0600), synced and
// looked through (CheckStore()). Others go on writing; about half of the time the disk is left to them. `go_on` is
// asked between pieces: an error ends the copying. Until it is whole the copy is called "PATH.part"; on failure there
// is none. ALREADY_EXISTS where there is a file. `copied`, which may be empty, is called once the source is no longer
// read.
absl::StatusOr<BackupResult> CopyStore(const std::string& source, const std::string& path,
                                       const std::function<absl::Status()>& go_on,
                                       const std::function<void()>& copied = nullptr);

// Merges the log of a database into it as far as readers allow, beside whoever writes, who does not wait for it.
absl::Status MergeBeside(const std::string& path);

// Puts the backup in the place of the database at `path`, which no server may have. The backup is looked through first:
// DATA_LOSS BACKUP_DAMAGED names what is damaged, unless `take_damaged`. What was there is kept as "PATH.replaced", or,
// where there is such a file already, FAILED_PRECONDITION RESTORE_KEPT says so before anything is changed. Where a
// crash has left a log beside the database, it is merged first; what cannot be is an error, unless
// the database is damaged: then its log is kept beside "PATH.replaced". Killed at any moment, and after an error,
// `path` is either what it was or the backup, whole.
absl::StatusOr<CheckReport> RestoreStore(const std::string& backup, const std::string& path, bool take_damaged);

struct CompactResult {
  int64_t before_bytes = 0, after_bytes = 0;
};
// Writes the file anew, without free pages. Takes as much disk again meanwhile. A damaged file is refused (DATA_LOSS
// STORE_DAMAGED) and left as it was.
absl::StatusOr<CompactResult> CompactStore(const std::string& path);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_BACKUP_H_
