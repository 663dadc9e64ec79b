#include "server/offline.h"

#include <chrono>
#include <cstdio>
#include <filesystem>

#include "absl/time/time.h"
#include "core/base/clock.h"
#include "core/base/utf8.h"
#include "server/storage/backup.h"
#include "server/storage/check.h"
#include "server/storage/copy_store.h"
#include "server/storage/file_lock.h"
#include "server/storage/migrate.h"
#include "server/storage/postgres_url.h"
#include "server/storage/undone.h"

namespace axiscal::server {
namespace {

void Print(const std::string& text) { std::printf("%s\n", text.c_str()); }

int Fail(const absl::Status& status) {
  // SQLite's words quote what is damaged.
  std::fprintf(stderr, "axiscald: %s\n", base::ToUtf8(std::string(status.message())).c_str());
  return absl::IsDataLoss(status) ? kDamaged : 1;
}

int Tell(const std::string& path, const storage::CheckReport& report) {
  Print(absl::StrCat(path, ": schema version ", report.schema_version, "; structure and references"));
  if (report.schema_version == static_cast<int>(storage::EmbeddedMigrations().size())) {
    Print(absl::StrCat("compared with their checksums: ", report.descriptions, " descriptions of machines, ",
                       report.sessions, " sessions with ", report.chunks, " chunks, ", report.jobs, " jobs, ",
                       report.calibrations, " calibrations, ", report.programs, " programs, the audit up to entry ",
                       report.audit.id, report.audit.id == 0 ? "" : " with the hash " + report.audit.sha256));
  } else {
    Print("of an older version: checksums are compared once axiscald has opened it");
  }
  for (const storage::Damage& damage : report.damages) Print("DAMAGED " + damage.resource + ": " + damage.text);
  const auto more = report.damage_count - static_cast<int64_t>(report.damages.size());
  if (more > 0) Print(absl::StrCat("DAMAGED: ", more, " more"));
  Print(report.damage_count == 0 ? "whole" : absl::StrCat("damaged in ", report.damage_count, " places"));
  return report.damage_count == 0 ? 0 : kDamaged;
}

// What somebody counts on that the backup does not know.
void TellUndone(const std::string& kept, const std::string& path) {
  const absl::StatusOr<std::vector<storage::AuditEntry>> undone = storage::UndoneByRestore(kept, path);
  if (!undone.ok()) {
    Print("what this has undone cannot be told (" + base::ToUtf8(std::string(undone.status().message())) + ")");
    return;
  }
  for (const storage::AuditEntry& entry : *undone) {
    Print(absl::StrCat(
        "UNDONE ",
        absl::FormatTime("%Y-%m-%d %H:%M:%SZ", absl::FromUnixMicros(base::ToUtcUs(entry.at)), absl::UTCTimeZone()), " ",
        entry.principal, " ", entry.action, " ", entry.resource));
  }
  if (!undone->empty()) {
    Print("what was revoked or taken away is good again until that is done anew (axiscal --db " + path +
          " admin ..., before a server has it)");
  }
}

}  // namespace

int CheckOffline(const std::string& path) {
  const absl::StatusOr<storage::CheckReport> report =
      storage::IsPostgresUrl(path) ? storage::CheckStoreOnServer(path) : storage::CheckStoreFile(path);
  return report.ok() ? Tell(storage::WithoutPassword(path), *report) : Fail(report.status());
}

int RestoreOffline(const std::string& backup, const std::string& path, bool take_damaged) {
  const absl::StatusOr<storage::CheckReport> report = storage::RestoreStore(backup, path, take_damaged);
  if (!report.ok()) return Fail(report.status());
  const int code = Tell(path, *report);
  std::error_code error;
  const std::filesystem::path resolved = std::filesystem::canonical(path, error);
  const std::string aside = storage::KeptPath(error ? path : resolved.string());
  const bool was_there = std::filesystem::exists(aside, error);
  Print("restored from " + backup + (was_there ? "; what was there before is " + aside : ""));
  if (was_there) TellUndone(aside, path);
  return code;
}

int CompactOffline(const std::string& path) {
  const absl::StatusOr<storage::CompactResult> result = storage::CompactStore(path);
  if (!result.ok()) return Fail(result.status());
  Print(absl::StrCat(path, ": ", result->before_bytes, " bytes before, ", result->after_bytes, " now"));
  return 0;
}

int CopyOffline(const std::string& from, const std::string& to) {
  base::SteadyTime next_word = base::SystemClock().SteadyNow();
  const absl::StatusOr<storage::CopyResult> result = storage::CopyStoreTo(
      from, to, base::SystemClock().UtcNow(), [&](const storage::CopyProgress& progress) -> absl::Status {
        const base::SteadyTime now = base::SystemClock().SteadyNow();
        if (now < next_word) return absl::OkStatus();
        next_word = now + std::chrono::seconds(2);
        Print(
            absl::StrCat(progress.doing, " ", progress.table, ": ", progress.rows, " of ", progress.all_rows, " rows"));
        std::fflush(stdout);
        return absl::OkStatus();
      });
  if (!result.ok()) return Fail(result.status());
  if (result->rows_before > 0)
    Print(absl::StrCat(result->rows_before, " rows were there from a copy that was broken off"));
  Print(absl::StrCat(storage::WithoutPassword(to), ": ", result->rows, " rows of ", result->tables,
                     " tables, the same as in ", storage::WithoutPassword(from), " (SHA-256 ", result->sha256,
                     "), whole by their own checksums"));
  return 0;
}

}  // namespace axiscal::server
