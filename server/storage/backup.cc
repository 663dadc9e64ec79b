#include "server/storage/backup.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <thread>

#include "absl/strings/str_join.h"
#include "core/base/clock.h"
#include "core/base/error_detail.h"
#include "core/base/files.h"
#include "core/base/sha256.h"
#include "server/storage/check.h"
#include "server/storage/file_lock.h"
#include "server/storage/migrate.h"
#include "server/storage/sqlite_connection.h"
#include "server/storage/sqlite_error.h"
#include "server/storage/transaction.h"

namespace axiscal::storage {
namespace {

// 1 MB: some milliseconds of the disk's time, after which others have their turn.
constexpr int kPagesAStep = 256;
constexpr std::chrono::milliseconds kMaxPause(50);

absl::Status SystemError(const std::string& path) {
  const bool is_full = errno == ENOSPC || errno == EDQUOT || errno == EFBIG;
  const std::string text = absl::StrCat(path, ": ", std::strerror(errno));
  if (errno == EEXIST) return base::Error(absl::StatusCode::kAlreadyExists, text, {"FILE_EXISTS", {}});
  if (is_full) return base::Error(absl::StatusCode::kResourceExhausted, text, {"DISK_FULL", {}});
  if (IsNotWritable(errno) || errno == ENOENT)
    return base::Error(absl::StatusCode::kFailedPrecondition, text, {"FOLDER_NOT_WRITABLE", {}});
  return base::Error(absl::StatusCode::kUnavailable, text, {"STORE_DOWN", {}});
}

absl::Status SyncFolder(const std::string& path) {
  const std::string folder = std::filesystem::absolute(path).parent_path().string();
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return SystemError(folder);
  const bool is_synced = fsync(descriptor) == 0;
  const absl::Status status = is_synced ? absl::OkStatus() : SystemError(folder);
  close(descriptor);
  return status;
}

// With what SQLite leaves beside it.
void Remove(const std::string& path) {
  for (const char* const end : {"", "-journal", "-wal", "-shm"}) unlink((path + end).c_str());
}

bool Exists(const std::string& path) {
  struct stat info;
  return lstat(path.c_str(), &info) == 0;
}

absl::StatusOr<int64_t> SizeOf(const std::string& path) {
  struct stat info;
  if (stat(path.c_str(), &info) != 0) return SystemError(path);
  return static_cast<int64_t>(info.st_size);
}

// A file that is made here, and goes again unless Keep() was called.
class NewFile {
 public:
  static absl::StatusOr<NewFile> Make(const std::string& path) {
    const int descriptor = open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (descriptor < 0) return SystemError(path);
    return NewFile(path, descriptor);
  }
  NewFile(NewFile&& other) noexcept
      : path_(std::exchange(other.path_, "")), descriptor_(std::exchange(other.descriptor_, -1)) {}
  NewFile& operator=(NewFile&&) = delete;
  ~NewFile() {
    if (descriptor_ >= 0) close(descriptor_);
    if (!path_.empty()) Remove(path_);
  }
  absl::Status SyncData() { return fdatasync(descriptor_) == 0 ? absl::OkStatus() : SystemError(path_); }
  absl::Status Sync() {
    if (fsync(descriptor_) != 0) return SystemError(path_);
    return SyncFolder(path_);
  }
  void Keep() { path_.clear(); }

 private:
  NewFile(std::string path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

  std::string path_;
  int descriptor_;
};

// A plain connection: what it writes is synced by who made the file.
class Target {
 public:
  static absl::StatusOr<Target> Open(const std::string& path) {
    sqlite3* db = nullptr;
    const int code = sqlite3_open_v2(path.c_str(), &db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX, nullptr);
    Target target(db);
    if (code != SQLITE_OK) return SqliteError(db, path);
    return target;
  }
  Target(Target&& other) noexcept : db_(std::exchange(other.db_, nullptr)) {}
  Target& operator=(Target&&) = delete;
  ~Target() { sqlite3_close(db_); }
  sqlite3* handle() { return db_; }
  absl::Status Execute(const std::string& sql) {
    if (sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) return SqliteError(db_, sql);
    return absl::OkStatus();
  }

 private:
  explicit Target(sqlite3* db) : db_(db) {}

  sqlite3* db_;
};

// The source's connection is in a transaction: what others write meanwhile does not make the copy begin anew.
absl::Status CopyPages(SqliteConnection& source, Target& target, NewFile& file,
                       const std::function<absl::Status()>& go_on) {
  sqlite3_backup* const copying = sqlite3_backup_init(target.handle(), "main", source.handle(), "main");
  if (copying == nullptr) return SqliteError(target.handle(), "copy");
  int code = SQLITE_OK;
  absl::Status status;
  while (status.ok() && code == SQLITE_OK) {
    const base::SteadyTime start = base::SystemClock().SteadyNow();
    code = sqlite3_backup_step(copying, kPagesAStep);
    // Bit by bit: all at once would hold up the syncs of others.
    if (code == SQLITE_OK) status = file.SyncData();
    if (status.ok() && go_on) status = go_on();
    if (code != SQLITE_OK) break;
    const auto took = base::SystemClock().SteadyNow() - start;
    std::this_thread::sleep_for(std::min<base::SteadyTime::duration>(took, kMaxPause));
  }
  sqlite3_backup_finish(copying);
  RETURN_IF_ERROR(status);
  return code == SQLITE_DONE ? absl::OkStatus() : SqliteError(target.handle(), "copy");
}

absl::Status CopyInto(const std::string& source, const std::string& path, NewFile& file,
                      const std::function<absl::Status()>& go_on) {
  {
    ASSIGN_OR_RETURN(const std::unique_ptr<SqliteConnection> connection,
                     SqliteConnection::Open(source, Access::kReadOnly));
    ASSIGN_OR_RETURN(const Transaction snapshot, Transaction::BeginRead(*connection));
    {
      // The first read is what fixes the state.
      ASSIGN_OR_RETURN(Statement row, connection->Ask("SELECT count(*) FROM sqlite_schema"));
      RETURN_IF_ERROR(row.Step().status());
    }
    ASSIGN_OR_RETURN(Target target, Target::Open(path));
    // A few pages: what the cache holds back is written with the last piece, all at once.
    RETURN_IF_ERROR(target.Execute("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF; PRAGMA cache_size = 16"));
    RETURN_IF_ERROR(CopyPages(*connection, target, file, go_on));
  }
  // Its header says that it has a log, as the source does; a copy is one file.
  ASSIGN_OR_RETURN(Target target, Target::Open(path));
  return target.Execute("PRAGMA journal_mode = DELETE");
}

absl::StatusOr<CheckReport> Look(const std::string& path, const std::function<absl::Status()>& go_on = nullptr) {
  ASSIGN_OR_RETURN(const std::unique_ptr<SqliteConnection> connection, SqliteConnection::Open(path, Access::kReadOnly));
  return CheckStore(*connection, go_on);
}

absl::StatusOr<std::string> HashOfFile(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return SystemError(path);
  base::Sha256 sha;
  std::string piece(size_t{1} << 20, '\0');
  ssize_t count = 0;
  while ((count = read(descriptor, piece.data(), piece.size())) > 0)
    sha.Add(piece.substr(0, static_cast<size_t>(count)));
  const absl::Status status = count < 0 ? SystemError(path) : absl::OkStatus();
  close(descriptor);
  RETURN_IF_ERROR(status);
  return sha.HexDigest();
}

absl::Status DamagedStore(const std::string& path, const CheckReport& report, const std::string& reason) {
  const std::string texts = absl::StrJoin(report.damages, "; ", [](std::string* out, const Damage& damage) {
    absl::StrAppend(out, damage.resource, ": ", damage.text);
  });
  return base::Error(absl::StatusCode::kDataLoss,
                     absl::StrCat(path, " is damaged in ", report.damage_count, " places: ", texts), {reason, {}});
}

// What stands beside a database and is part of it.
constexpr const char* kBeside[] = {"-journal", "-wal"};

// Whether the file is so damaged that nothing can be got out of its log.
bool IsDamaged(const absl::Status& status) {
  return absl::IsDataLoss(status) || base::ErrorReason(status) == "NOT_A_DATABASE";
}

// Merges the log of a file that a crash has left, so that nothing of it stands beside the file.
absl::Status MergeLog(const std::string& path) {
  ASSIGN_OR_RETURN(const std::unique_ptr<SqliteConnection> connection, SqliteConnection::Open(path, Access::kWrite));
  sqlite3* const db = connection->handle();
  const int code = sqlite3_wal_checkpoint_v2(db, nullptr, SQLITE_CHECKPOINT_TRUNCATE, nullptr, nullptr);
  return code == SQLITE_OK ? absl::OkStatus() : SqliteError(db, path);
}

// What stands beside a file that is replaced: left there it would be taken for that of the new one. It stays under the
// names of `aside`, unless PutBack().
class Beside {
 public:
  Beside(std::string path, std::string aside) : path_(std::move(path)), aside_(std::move(aside)) {}
  absl::Status PutAside() {
    for (const char* const end : kBeside) {
      if (Exists(path_ + end) && std::rename((path_ + end).c_str(), (aside_ + end).c_str()) != 0)
        return SystemError(path_ + end);
    }
    unlink((path_ + "-shm").c_str());
    // Names may reach the disk in any order.
    return SyncFolder(path_);
  }
  void PutBack() {
    for (const char* const end : kBeside) {
      if (Exists(aside_ + end)) std::rename((aside_ + end).c_str(), (path_ + end).c_str());
    }
  }

 private:
  const std::string path_, aside_;
};

// A crash leaves the one or the other. What had the name goes.
absl::Status PlaceFile(const std::string& from, const std::string& to) {
  if (std::rename(from.c_str(), to.c_str()) != 0) return SystemError(to);
  return SyncFolder(to);
}

// Likewise, but `aside` is what `to` was. A crash in between leaves a file of two names, of which FileLock::Take()
// takes the second one away. Where the file system knows no second names (FAT), nothing has the name `to` for a moment.
absl::Status PlaceFileAndKeep(const std::string& from, const std::string& to, const std::string& aside) {
  const bool has_both = link(to.c_str(), aside.c_str()) == 0;
  if (!has_both && errno != EPERM && errno != EOPNOTSUPP && errno != ENOSYS) return SystemError(aside);
  if (!has_both && std::rename(to.c_str(), aside.c_str()) != 0) return SystemError(aside);
  const absl::Status placed = PlaceFile(from, to);
  if (Exists(from)) {  // it was not placed
    has_both ? unlink(aside.c_str()) : std::rename(aside.c_str(), to.c_str());
  }
  return placed;
}

// `copy` in the place of the database at `path`, which is kept as `aside`, with what stands beside it.
absl::Status Replace(const std::string& copy, const std::string& path, const std::string& aside) {
  ASSIGN_OR_RETURN(const int64_t size, SizeOf(path));
  // What cannot be merged for another reason than damage may hold what was acknowledged last.
  const absl::Status merged = size == 0 ? absl::OkStatus() : MergeLog(path);
  if (!merged.ok() && !IsDamaged(merged)) {
    return base::Within(path + " and its log cannot be kept as one file; to restore all the same, move both away",
                        merged);
  }
  Beside beside(path, aside);
  absl::Status placed = beside.PutAside();
  if (placed.ok()) placed = PlaceFileAndKeep(copy, path, aside);
  if (Exists(copy)) beside.PutBack();  // it was not placed
  return placed;
}

void RemoveEmpty(const std::string& path) {
  const absl::StatusOr<int64_t> size = SizeOf(path);
  if (size.ok() && *size == 0) unlink(path.c_str());
}

}  // namespace

absl::StatusOr<BackupResult> CopyStore(const std::string& source, const std::string& path,
                                       const std::function<absl::Status()>& go_on,
                                       const std::function<void()>& copied) {
  if (Exists(path)) return base::Error(absl::StatusCode::kAlreadyExists, path + " is there", {"FILE_EXISTS", {}});
  const std::string part = path + ".part";
  Remove(part);
  ASSIGN_OR_RETURN(NewFile file, NewFile::Make(part));
  RETURN_IF_ERROR(CopyInto(source, part, file, go_on));
  if (copied) copied();
  RETURN_IF_ERROR(file.Sync());
  BackupResult result;
  ASSIGN_OR_RETURN(result.report, Look(part, go_on));
  ASSIGN_OR_RETURN(result.bytes, SizeOf(part));
  ASSIGN_OR_RETURN(result.sha256, HashOfFile(part));
  RETURN_IF_ERROR(PlaceFile(part, path));
  file.Keep();
  return result;
}

absl::Status MergeBeside(const std::string& path) {
  ASSIGN_OR_RETURN(const std::unique_ptr<SqliteConnection> connection, SqliteConnection::Open(path, Access::kWrite));
  sqlite3* const db = connection->handle();
  const int code = sqlite3_wal_checkpoint_v2(db, nullptr, SQLITE_CHECKPOINT_PASSIVE, nullptr, nullptr);
  return code == SQLITE_OK ? absl::OkStatus() : SqliteError(db, path);
}

absl::StatusOr<CheckReport> RestoreStore(const std::string& backup, const std::string& path, bool take_damaged) {
  RETURN_IF_ERROR(base::RequireFile(backup));
  RETURN_IF_ERROR(CheckFile(backup, EmbeddedMigrations()));
  const bool was_there = Exists(path);
  ASSIGN_OR_RETURN(const FileLock lock, FileLock::Take(path));
  const std::string aside = KeptPath(lock.path()), copy = lock.path() + ".restoring";
  const auto restore = [&]() -> absl::StatusOr<CheckReport> {
    // A log alone as well: it would be taken for that of what is put beside it now.
    for (const char* const end : {"", kBeside[0], kBeside[1]}) {
      if (!Exists(aside + end)) continue;
      return base::Error(absl::StatusCode::kFailedPrecondition,
                         aside + end + " is what an earlier restore has put aside: move it away first",
                         {"RESTORE_KEPT", {}});
    }
    Remove(copy);
    ASSIGN_OR_RETURN(const BackupResult copied, CopyStore(backup, copy, nullptr));
    if (copied.report.damage_count > 0 && !take_damaged) {
      Remove(copy);
      return DamagedStore(backup, copied.report, "BACKUP_DAMAGED");
    }
    const absl::Status placed = Replace(copy, lock.path(), aside);
    Remove(copy);
    RETURN_IF_ERROR(placed);
    return copied.report;
  };
  absl::StatusOr<CheckReport> report = restore();
  // The lock has made an empty file where there was none.
  if (!was_there) RemoveEmpty(lock.path());
  if (!was_there) RemoveEmpty(aside);
  return report;
}

absl::StatusOr<CompactResult> CompactStore(const std::string& path) {
  RETURN_IF_ERROR(base::RequireFile(path));
  ASSIGN_OR_RETURN(const FileLock lock, LockStoreFile(path, EmbeddedMigrations()));
  const std::string copy = lock.path() + ".compacting";
  Remove(copy);
  CompactResult result;
  ASSIGN_OR_RETURN(NewFile file, NewFile::Make(copy));
  {
    ASSIGN_OR_RETURN(const std::unique_ptr<SqliteConnection> connection,
                     SqliteConnection::Open(lock.path(), Access::kWrite));
    ASSIGN_OR_RETURN(const CheckReport before, CheckStore(*connection));
    if (before.damage_count > 0) return DamagedStore(lock.path(), before, "STORE_DAMAGED");
    RETURN_IF_ERROR(connection->Run("VACUUM INTO ?1", copy));
  }
  ASSIGN_OR_RETURN(result.before_bytes, SizeOf(lock.path()));
  RETURN_IF_ERROR(file.Sync());
  ASSIGN_OR_RETURN(const CheckReport after, Look(copy));
  if (after.damage_count > 0) return DamagedStore(copy, after, "STORE_DAMAGED");
  ASSIGN_OR_RETURN(result.after_bytes, SizeOf(copy));
  if (Exists(lock.path() + "-wal"))
    return base::Error(absl::StatusCode::kUnavailable, lock.path() + ": its log could not be merged",
                       {"STORE_BUSY", {}});
  RETURN_IF_ERROR(PlaceFile(copy, lock.path()));
  file.Keep();
  return result;
}

}  // namespace axiscal::storage
