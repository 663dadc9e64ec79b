#include "server/rights_watch.h"

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/jobs/job_runner.h"
#include "server/log.h"

namespace axiscal::server {

void RightsWatch::Start() {
  rounds_.Start(Rounds::Begin::kAfterAPause, again_, [this] { AskAgain(); });
}

void RightsWatch::AskAgain() {
  const int count = core_.open.CutOffRefused();
  CancelRefusedJobs();
  WriteDenials(false);
  if (count > 0)
    Log(LogLevel::kWarning, "cut_off",
        {{"calls", absl::StrCat(count)}, {"text", "their callers may no longer make them"}});
}

void RightsWatch::CancelRefusedJobs() {
  for (const records::JobState state : {records::JobState::kRunning, records::JobState::kQueued}) {
    records::PageRequest page{1000, ""};
    do {
      const auto jobs = core_.database.ListJobs({{}, state, ""}, page);
      if (!jobs.ok()) return Log(LogLevel::kWarning, "ask_again", {{"text", std::string(jobs.status().message())}});
      for (const records::JobRecord& job : jobs->rows) CancelIfRefused(job);
      page.token = jobs->next_token;
    } while (!page.token.empty());
  }
}

void RightsWatch::CancelIfRefused(const records::JobRecord& job) {
  if (job.cancel_requested) return;
  std::vector<storage::Resource> named;
  if (job.machine) named.push_back({storage::ResourceKind::kMachine, job.machine->text(), 0});
  const absl::Status may = core_.gate.MayStill(job.created_by, "Jobs.CreateJob", named);
  if (!absl::IsNotFound(may) && !absl::IsPermissionDenied(may) && !absl::IsUnauthenticated(may)) return;
  const absl::Status cancelled = core_.jobs.Cancel(job.id, {"axiscald", ""}).status();
  Log(LogLevel::kWarning, "cut_off",
      {{"job", absl::StrCat(job.id.number())},
       {"text", cancelled.ok() ? "its creator, " + job.created_by + ", may no longer create it"
                               : std::string(cancelled.message())}});
}

void RightsWatch::WriteDenials(bool all) {
  const absl::Status written = denials_.Write(core_.database, all);
  if (!written.ok()) Log(LogLevel::kWarning, "audit", {{"text", std::string(written.message())}});
}

}  // namespace axiscal::server
