#include "server/handlers/backup.h"

#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>

#include "absl/time/time.h"
#include "core/base/clock.h"
#include "core/base/error_detail.h"

namespace axiscal::handlers {
namespace {

constexpr size_t kPieceBytes = 256 << 10;

absl::Status Gone() { return base::Error(absl::StatusCode::kCancelled, "the caller has left", {"CALLER_GONE", {}}); }

// The one backup that is made at a time.
class Turn {
 public:
  explicit Turn(Core& core) : core_(core), is_ours_(!core.is_backing_up.exchange(true)) {}
  ~Turn() {
    if (is_ours_) core_.is_backing_up = false;
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
  bool is_ours() const { return is_ours_; }

 private:
  Core& core_;
  const bool is_ours_;
};

// A file that goes when this does; empty: none.
class Scratch {
 public:
  explicit Scratch(std::string path) : path_(std::move(path)) {}
  ~Scratch() {
    if (!path_.empty()) unlink(path_.c_str());
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

 private:
  const std::string path_;
};

absl::Status SendFile(const std::string& path, const std::function<bool(const v1::BackupResponse&)>& send) {
  std::ifstream file(path, std::ios::binary);
  std::string piece(kPieceBytes, '\0');
  v1::BackupResponse message;
  while (file.read(piece.data(), static_cast<std::streamsize>(piece.size())) || file.gcount() > 0) {
    message.set_data(piece.substr(0, static_cast<size_t>(file.gcount())));
    if (!send(message)) return Gone();
  }
  if (!file.bad() && file.eof()) return absl::OkStatus();
  return base::Error(absl::StatusCode::kUnavailable, path + ": cannot be read", {"STORE_DOWN", {}});
}

// "axiscal-20260531T140307Z.db": the first free name of this second.
std::filesystem::path NewName(const std::filesystem::path& folder, base::UtcTime now) {
  const std::string time =
      absl::FormatTime("%Y%m%dT%H%M%SZ", absl::FromUnixMicros(base::ToUtcUs(now)), absl::UTCTimeZone());
  for (int count = 1;; ++count) {
    std::filesystem::path path =
        folder / absl::StrCat("axiscal-", time, count == 1 ? "" : absl::StrCat("-", count), ".db");
    std::error_code error;
    if (!std::filesystem::exists(path, error)) return path;
  }
}

// Takes away what servers have left that were killed in the midst of a backup, before it fills the disk. What another
// server is writing now is younger.
void RemoveLeft(const std::filesystem::path& folder) {
  constexpr std::chrono::hours kLeftAfter(24);
  std::error_code error;
  // Without exceptions: a folder that cannot be read to its end is no reason against a backup.
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with("axiscal-") || !name.ends_with(".db.part")) continue;
    std::error_code of_entry;
    const auto written = entry->last_write_time(of_entry);
    if (!of_entry && std::filesystem::file_time_type::clock::now() - written > kLeftAfter)
      std::filesystem::remove(entry->path(), of_entry);
  }
}

v1::BackupResponse Summary(const storage::BackupResult& result, const std::string& file) {
  v1::BackupResponse message;
  v1::BackupSummary& summary = *message.mutable_summary();
  summary.set_file(file);
  summary.set_size_bytes(result.bytes);
  summary.set_sha256(result.sha256);
  summary.set_damage_count(result.report.damage_count);
  for (const storage::Damage& damage : result.report.damages) {
    v1::StoreDamage& named = *summary.add_damages();
    named.set_resource(damage.resource);
    named.set_text(damage.text);
  }
  return message;
}

}  // namespace

absl::Status Backup(Core& core, const Call& call, const v1::BackupRequest& request,
                    const std::function<bool(const v1::BackupResponse&)>& send) {
  RETURN_IF_ERROR(RequireAccepting(core));
  // A server's database refuses, and says who makes its backups.
  if (core.limits.database_file.empty()) return core.database.Backup("", [] { return absl::OkStatus(); }).status();
  const std::filesystem::path folder(core.limits.backup_folder);
  if (folder.empty() && !request.download()) {
    return base::Error(absl::StatusCode::kFailedPrecondition,
                       "this server has no folder for backups: set backup.folder, or let the copy be sent",
                       {"BACKUP_FOLDER_MISSING", {}});
  }
  const Turn turn(core);
  if (!turn.is_ours())
    return base::Error(absl::StatusCode::kResourceExhausted, "a backup is being made", {"BACKUP_RUNNING", {}});
  // What is sent is made beside the database where there is no folder.
  const std::filesystem::path path = request.download()
                                         ? folder.empty() ? std::filesystem::path(core.limits.database_file + ".backup")
                                                          : folder / "axiscal-download.db"
                                         : NewName(folder, base::SystemClock().UtcNow());
  if (request.download()) unlink(path.c_str());
  if (!folder.empty()) RemoveLeft(folder);
  const auto go_on = [&]() -> absl::Status {
    RETURN_IF_ERROR(RequireAccepting(core));
    return call.is_cancelled() ? Gone() : absl::OkStatus();
  };
  ASSIGN_OR_RETURN(const storage::BackupResult result, core.database.Backup(path.string(), go_on));
  const Scratch copy(request.download() ? path.string() : "");
  if (request.download()) RETURN_IF_ERROR(SendFile(path.string(), send));
  const std::string file = request.download() ? "" : path.filename().string();
  storage::AuditEntry entry;
  entry.at = base::SystemClock().UtcNow();
  entry.principal = call.user;
  entry.peer = call.peer;
  entry.action = request.download() ? "store.download" : "store.backup";
  entry.resource = "store";
  entry.outcome = "OK";
  entry.became = file.empty() ? "sha256 " + result.sha256 : absl::StrCat(file, ", sha256 ", result.sha256);
  RETURN_IF_ERROR(core.database.AppendAudit(entry));
  return send(Summary(result, file)) ? absl::OkStatus() : Gone();
}

}  // namespace axiscal::handlers
