#include "server/log_job.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/log.h"

namespace axiscal::server {
namespace {

LogLevel LevelOf(const std::string& outcome) {
  if (outcome == "DEAD") return LogLevel::kError;
  return outcome.empty() || outcome == "SUCCEEDED" || outcome == "CANCELLED" || outcome == "PARKED"
             ? LogLevel::kInfo
             : LogLevel::kWarning;
}

}  // namespace

void LogJob(const jobs::JobEvent& event) {
  const records::JobRecord& job = event.job;
  LogFields fields = {{"job", absl::StrCat(job.id.number())},
                      {"kind", job.kind},
                      {"machine", job.machine ? job.machine->text() : ""},
                      {"attempt", absl::StrCat(job.attempt)}};
  if (!job.request_id.empty()) fields.push_back({"request", job.request_id});
  if (!job.trace.empty()) fields.push_back({"trace", job.trace});
  const bool is_over = event.what != jobs::JobEvent::What::kStarted;
  if (is_over) fields.push_back({"outcome", event.outcome});
  if (event.took) fields.push_back({"ms", absl::StrFormat("%.3f", static_cast<double>(event.took->count()) / 1e3)});
  if (is_over && job.error && job.state != records::JobState::kSucceeded) {
    fields.push_back({"reason", job.error->reason});
    fields.push_back({"text", job.error->message});
  }
  const bool is_lost = event.what == jobs::JobEvent::What::kLost;
  Log(LevelOf(event.outcome), !is_over ? "job_start" : is_lost ? "job_lost" : "job_end", fields);
}

}  // namespace axiscal::server
