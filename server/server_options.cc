#include "server/server_options.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace axiscal::server {

absl::Status Validate(const ServerOptions& options) {
  const auto refuse = [](const std::string& text) { return absl::InvalidArgumentError(text); };
  if (options.database_path.empty()) return refuse("database_path is empty, must name a file or a database");
  if (options.workers < 1 || options.workers > kMaxWorkers) {
    return refuse(absl::StrCat("workers = ", options.workers, ", must be 1 to ", kMaxWorkers, ": each uses one core"));
  }
  if (options.max_uploads < 1 || options.max_uploads > kMaxUploads) {
    return refuse(absl::StrCat("max_uploads = ", options.max_uploads, ", must be 1 to ", kMaxUploads));
  }
  if (options.streams_per_principal < 1 || options.streams_per_principal > kMaxUploads) {
    return refuse(
        absl::StrCat("streams_per_principal = ", options.streams_per_principal, ", must be 1 to ", kMaxUploads));
  }
  if (options.calls_per_second < 1 || options.calls_per_second > kMaxCallsPerSecond) {
    return refuse(absl::StrCat("calls_per_second = ", options.calls_per_second, ", must be 1 to ", kMaxCallsPerSecond));
  }
  for (const auto& [name, jobs] :
       {std::pair("jobs_per_principal", options.jobs_per_principal), {"jobs_per_machine", options.jobs_per_machine}}) {
    if (jobs < 1 || jobs > kMaxJobs) return refuse(absl::StrCat(name, " = ", jobs, ", must be 1 to ", kMaxJobs));
  }
  if (options.session_readings < 1 || options.program_bytes < 1)
    return refuse("session_readings and program_bytes must be > 0");
  const std::chrono::milliseconds longest = std::chrono::hours(24);
  for (const auto& [name, time] :
       {std::pair("silence", options.silence), {"connection_idle", options.connection_idle}}) {
    if (time.count() >= 1 && time <= longest) continue;
    return refuse(absl::StrCat(name, " = ", time.count(), " ms, must be 1 to ", longest.count()));
  }
  if (options.window_bytes < kMinWindowBytes || options.window_bytes > kMaxWindowBytes) {
    return refuse(
        absl::StrCat("window_bytes = ", options.window_bytes, ", must be ", kMinWindowBytes, " to ", kMaxWindowBytes));
  }
  if (options.waiting_bytes < kMinWaitingBytes)
    return refuse(absl::StrCat("waiting_bytes = ", options.waiting_bytes, ", must be >= ", kMinWaitingBytes));
  if (options.strangers < 1) return refuse(absl::StrCat("strangers = ", options.strangers, ", must be > 0"));
  // Of one there would be nothing left for the others (handlers::Budget), so that nobody got it.
  if (options.http_bytes < 2 || options.http_requests < 2)
    return refuse(absl::StrCat("http_bytes = ", options.http_bytes, ", http_requests = ", options.http_requests,
                               ", both must be > 1"));
  if (options.session_expiry.count() < 1) return refuse("session_expiry must be > 0");
  if (options.drain.count() < 0) return refuse(absl::StrCat("drain = ", options.drain.count(), " ms, must be >= 0"));
  return absl::OkStatus();
}

}  // namespace axiscal::server
