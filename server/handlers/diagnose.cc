#include "server/handlers/diagnose.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "core/base/error_detail.h"
#include "server/storage/file_mode.h"
#include "server/storage/sqlite_database.h"

namespace axiscal::handlers {
namespace {

using records::Finding;
using records::FindingState;

// The limits of deploy/prometheus/axiscal-alerts.yml, so that both say the same.
constexpr int64_t kLowDiskBytes = 5'000'000'000;
constexpr std::chrono::days kCertificateAhead(14);
// From three quarters of all descriptors on connections are refused (server/listener.h); this is four fifths of that.
constexpr double kManyDescriptors = 0.6;
constexpr std::chrono::minutes kLongQueued(30);
// Backups are made daily (docs/operations.md); one may have failed.
constexpr std::chrono::days kOldBackup(2);

int64_t DaysOf(std::chrono::microseconds time) { return std::chrono::duration_cast<std::chrono::days>(time).count(); }

// Where something could not be asked for.
constexpr char kLookIntoLog[] = "journalctl -u axiscald -n 50 on the server says why";

std::string Gigabytes(int64_t bytes) { return absl::StrFormat("%.1f GB", static_cast<double>(bytes) / 1e9); }

Finding OfStore(const ServerFacts& facts) {
  if (!facts.read.ok()) {
    return {"database", FindingState::kFailed, "does not answer: " + std::string(facts.read.message()),
            facts.has_file
                ? "df and dmesg on the server: is its disk full, unmounted or broken? Then systemctl restart axiscald"
                : "is the server of PostgreSQL up, and does it let axiscald in? Once it does, axiscald goes on by "
                  "itself"};
  }
  if (!facts.write.ok()) {
    return {"database", FindingState::kFailed, "takes nothing: " + std::string(facts.write.message()),
            facts.has_file ? "make room on its disk, or give the user of the service the right to write there"
                           : "is it a standby, or its disk full? Its own log says so"};
  }
  return {"database", FindingState::kOk, "answers and takes what is written", ""};
}

Finding OfDisk(const ServerFacts& facts) {
  if (!facts.has_file)
    return {"disk", FindingState::kOk, "the database is PostgreSQL's, and so is its disk: look there", ""};
  if (!facts.disk_free_bytes)
    return {"disk", FindingState::kUnknown, "the free space could not be asked for", kLookIntoLog};
  const std::string text = absl::StrCat(Gigabytes(*facts.disk_free_bytes), " are free, the database has ",
                                        Gigabytes(facts.database_bytes.value_or(0)));
  if (*facts.disk_free_bytes >= kLowDiskBytes) return {"disk", FindingState::kOk, text, ""};
  const std::string advice = "retention.readings_days, axiscald compact while the server is stopped, or a larger disk";
  if (*facts.disk_free_bytes < storage::kMinFreeBytes)
    return {"disk", FindingState::kFailed, text + ": what comes is refused (DISK_LOW)", advice};
  return {"disk", FindingState::kWarning, text, advice};
}

// The certificate that ends first.
Finding OfCertificates(const ServerFacts& facts) {
  if (facts.certificates.empty()) {
    return {"server's certificates", FindingState::kOk, "none: without TLS only this machine reaches the server", ""};
  }
  const auto& [file, ends] = *std::min_element(facts.certificates.begin(), facts.certificates.end(),
                                               [](const auto& a, const auto& b) { return a.second < b.second; });
  const std::chrono::microseconds left = ends - facts.now;
  if (left <= std::chrono::microseconds(0)) {
    return {"server's certificates", FindingState::kFailed, file + " has ended",
            "make-certs ... --renew; the server takes the new files without a restart"};
  }
  const std::string text = absl::StrCat(file, " ends in ", DaysOf(left), " days, before all others");
  if (left >= kCertificateAhead) return {"server's certificates", FindingState::kOk, text, ""};
  return {"server's certificates", FindingState::kWarning, text,
          "make-certs ... --renew; the server takes the new files without a restart"};
}

Finding OfFiles(const ServerFacts& facts) {
  if (facts.open_files.empty())
    return {"permissions", FindingState::kOk,
            facts.has_file ? "database and keys are their owner's alone" : "keys are their owner's alone", ""};
  return {"permissions", FindingState::kWarning,
          "everybody on the server may read " + absl::StrJoin(facts.open_files, ", "), "chmod 600 on each"};
}

Finding OfDescriptors(const ServerFacts& facts) {
  if (!facts.descriptors || !facts.most_descriptors)
    return {"descriptors", FindingState::kUnknown, "could not be counted", kLookIntoLog};
  const std::string text = absl::StrCat(*facts.descriptors, " of ", *facts.most_descriptors, " are open");
  if (static_cast<double>(*facts.descriptors) <= kManyDescriptors * static_cast<double>(*facts.most_descriptors))
    return {"descriptors", FindingState::kOk, text, ""};
  return {"descriptors", FindingState::kWarning, text,
          "from three quarters on connections are refused: end clients that are idle, or raise LimitNOFILE= by "
          "systemctl edit axiscald"};
}

Finding OfBackup(const ServerFacts& facts) {
  const std::string advice = "axiscal backup every day, and a copy on another machine; restore one twice a year";
  if (!facts.has_file) {
    return {"last backup", FindingState::kUnknown, "the database is PostgreSQL's: its server knows of its backups",
            "pg_dump every day, and a copy on another machine (docs/scale.md); restore one twice a year"};
  }
  if (facts.backup_folder.empty()) {
    return {"last backup", FindingState::kWarning, "the server has no folder for backups and knows of none",
            "set backup.folder; " + advice};
  }
  if (!facts.backup_problem.empty()) {
    return {"last backup", FindingState::kFailed, facts.backup_folder + ": " + facts.backup_problem,
            "the server's user must be able to write there: owner and rights of the folder, and ReadWritePaths= by "
            "systemctl edit axiscald (docs/operations.md)"};
  }
  if (!facts.last_backup) return {"last backup", FindingState::kWarning, facts.backup_folder + " holds none", advice};
  const std::chrono::microseconds age = facts.now - *facts.last_backup;
  const std::string text = absl::StrCat("the newest in ", facts.backup_folder, " is ",
                                        std::chrono::duration_cast<std::chrono::hours>(age).count(), " hours old");
  if (age <= kOldBackup) return {"last backup", FindingState::kOk, text, ""};
  return {"last backup", FindingState::kWarning, text, advice};
}

void AddCells(const ServerFacts& facts, std::vector<Finding>& findings) {
  if (!facts.cells) {
    findings.push_back({"cells", FindingState::kUnknown, "could not be asked for", kLookIntoLog});
    return;
  }
  std::vector<std::string> silent, with_problem;
  for (const records::CellRecord& cell : *facts.cells) {
    const std::string name = cell.report.name + " of " + cell.report.machine.text();
    if (cell.is_silent())
      silent.push_back(
          absl::StrCat(name, " (", std::chrono::duration_cast<std::chrono::minutes>(cell.silence).count(), " min)"));
    if (!cell.report.problem.empty()) with_problem.push_back(name + ": " + cell.report.problem);
  }
  findings.push_back(silent.empty()
                         ? Finding{"cells", FindingState::kOk,
                                   facts.cells->empty() ? "none has ever reported"
                                                        : absl::StrCat("all ", facts.cells->size(), " are heard"),
                                   ""}
                         : Finding{"cells", FindingState::kWarning, "silent: " + absl::StrJoin(silent, ", "),
                                   "look at those PCs: power, network, systemctl status axiscal-cell; axiscal cells "
                                   "forget where one is gone"});
  if (!with_problem.empty()) {
    findings.push_back({"files of cells", FindingState::kWarning, absl::StrJoin(with_problem, "; "),
                        "its status file says all; axiscal spool list on that PC (docs/cell.md)"});
  }
}

Finding OfJobs(const ServerFacts& facts) {
  if (!facts.queued_jobs) return {"jobs", FindingState::kUnknown, "could not be counted", kLookIntoLog};
  const std::string text = absl::StrCat(
      *facts.queued_jobs, " wait",
      *facts.queued_jobs > 0
          ? absl::StrCat(", the oldest for ",
                         std::chrono::duration_cast<std::chrono::minutes>(facts.oldest_queued).count(), " min")
          : "");
  if (facts.oldest_queued <= kLongQueued) return {"jobs", FindingState::kOk, text, ""};
  return {"jobs", FindingState::kWarning, text,
          "axiscal jobs: many of one principal? Raise jobs.workers up to the number of cores"};
}

void AddWebhooks(const ServerFacts& facts, std::vector<Finding>& findings) {
  if (facts.dead_letters.empty()) return;
  std::vector<std::string> names;
  for (const auto& [name, count] : facts.dead_letters) names.push_back(absl::StrCat(name, " (", count, ")"));
  findings.push_back({"webhooks", FindingState::kWarning, "not taken: " + absl::StrJoin(names, ", "),
                      "axiscal admin webhook dead NAME says why; then resend"});
}

// "axiscal-20260531T140307Z.db", by its time on the disk.
std::optional<base::UtcTime> NewestBackup(const std::string& folder) {
  std::optional<base::UtcTime> newest;
  std::error_code error;
  for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    struct stat info {};
    if (!name.starts_with("axiscal-") || !name.ends_with("Z.db") || stat(it->path().c_str(), &info) != 0) continue;
    const base::UtcTime at = base::FromUtcUs(int64_t{info.st_mtim.tv_sec} * 1'000'000);
    if (!newest || at > *newest) newest = at;
  }
  return newest;
}

absl::StatusOr<std::vector<records::CellRecord>> AllCells(storage::Database& database) {
  std::vector<records::CellRecord> all;
  records::PageRequest page{1000, ""};
  do {
    ASSIGN_OR_RETURN(records::Page<records::CellRecord> cells, database.ListCells(std::nullopt, page, {}));
    std::move(cells.rows.begin(), cells.rows.end(), std::back_inserter(all));
    page.token = cells.next_token;
  } while (!page.token.empty());
  return all;
}

ServerFacts FactsOf(Core& core) {
  ServerFacts facts;
  facts.now = base::SystemClock().UtcNow();
  facts.version = AXISCAL_VERSION;
  facts.schema_version = core.database.schema_version();
  const absl::StatusOr<storage::JobQueue> jobs = core.database.CountJobs();
  facts.read = jobs.status();
  facts.write = core.database.TryWrite();
  if (jobs.ok()) {
    facts.queued_jobs = jobs->queued;
    if (jobs->oldest_queued) facts.oldest_queued = std::chrono::microseconds(facts.now - *jobs->oldest_queued);
  }
  facts.certificates = core.certificates();
  const std::string& path = core.limits.database_file;
  facts.has_file = !path.empty();
  if (facts.has_file) {
    facts.disk_free_bytes = metrics::DiskFreeBytes(path);
    facts.database_bytes = metrics::FileBytes(path);
    facts.open_files = storage::OpenToOthers(path);
  }
  for (const std::string& file : core.private_files) {
    struct stat info {};
    if (stat(file.c_str(), &info) == 0 && (info.st_mode & 0007) != 0)
      facts.open_files.push_back(absl::StrFormat("%s (%04o)", file, info.st_mode & 07777));
  }
  const metrics::Descriptors descriptors = metrics::CountDescriptors();
  facts.descriptors = descriptors.open;
  facts.most_descriptors = descriptors.most;
  facts.backup_folder = core.limits.backup_folder;
  if (!facts.backup_folder.empty()) {
    if (::access(facts.backup_folder.c_str(), W_OK | X_OK) != 0) facts.backup_problem = std::strerror(errno);
    facts.last_backup = NewestBackup(facts.backup_folder);
  }
  if (absl::StatusOr<std::vector<records::CellRecord>> cells = AllCells(core.database); cells.ok())
    facts.cells = *std::move(cells);
  const auto webhooks = core.database.ListWebhooks();
  if (webhooks.ok()) {
    for (const records::WebhookRecord& webhook : *webhooks) {
      if (webhook.dead_letters > 0) facts.dead_letters.emplace_back(webhook.content.name, webhook.dead_letters);
    }
  }
  facts.is_draining = core.draining;
  return facts;
}

}  // namespace

std::vector<Finding> FindingsOf(const ServerFacts& facts) {
  std::vector<Finding> findings;
  findings.push_back(facts.is_draining
                         ? Finding{"server", FindingState::kWarning, "is stopping", "wait, or start it"}
                         : Finding{"server", FindingState::kOk,
                                   absl::StrCat("axiscald ", facts.version, ", schema ", facts.schema_version), ""});
  findings.push_back(OfStore(facts));
  findings.push_back(OfDisk(facts));
  findings.push_back(OfCertificates(facts));
  findings.push_back(OfFiles(facts));
  findings.push_back(OfDescriptors(facts));
  findings.push_back(OfBackup(facts));
  findings.push_back(OfJobs(facts));
  AddCells(facts, findings);
  AddWebhooks(facts, findings);
  return findings;
}

absl::StatusOr<v1::DiagnoseResponse> Diagnose(Core& core, const Call& call, const v1::DiagnoseRequest& request) {
  const ServerFacts facts = FactsOf(core);
  v1::DiagnoseResponse response;
  for (const Finding& finding : FindingsOf(facts)) {
    v1::Finding& message = *response.add_findings();
    message.set_what(finding.what);
    message.set_state(static_cast<v1::FindingState>(finding.state));
    message.set_text(finding.text);
    message.set_advice(finding.advice);
  }
  response.set_now_utc_us(base::ToUtcUs(base::SystemClock().UtcNow()));
  return response;
}

absl::StatusOr<v1::SetLogLevelResponse> SetLogLevel(Core& core, const Call& call,
                                                    const v1::SetLogLevelRequest& request) {
  v1::SetLogLevelResponse response;
  response.set_former_level(static_cast<v1::LogLevel>(core.log_level(std::nullopt)));
  response.set_level(response.former_level());
  if (request.level() == v1::LOG_LEVEL_UNSPECIFIED || request.level() == response.former_level()) return response;
  if (request.level() < v1::LOG_LEVEL_DEBUG || request.level() > v1::LOG_LEVEL_ERROR) {
    return base::Error(absl::StatusCode::kInvalidArgument, "level must be DEBUG, INFO, WARNING or ERROR",
                       {"FIELD_INVALID", {{"field", "level"}}});
  }
  storage::AuditEntry entry;
  entry.at = base::SystemClock().UtcNow();
  entry.principal = call.user;
  entry.peer = call.peer;
  entry.action = "server.log_level";
  entry.resource = "server";
  entry.was = v1::LogLevel_Name(response.former_level());
  entry.became = v1::LogLevel_Name(request.level());
  entry.outcome = "OK";
  RETURN_IF_ERROR(core.database.AppendAudit(entry));
  response.set_level(static_cast<v1::LogLevel>(core.log_level(static_cast<records::LogLevel>(request.level()))));
  return response;
}

}  // namespace axiscal::handlers
