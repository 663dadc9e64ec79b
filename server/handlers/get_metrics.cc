#include "server/handlers/get_metrics.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>

#include "server/access/methods.h"

namespace axiscal::handlers {

absl::StatusOr<v1::GetMetricsResponse> GetMetrics(Core& core, const Call& call, const v1::GetMetricsRequest& request) {
  metrics::Gauges gauges;
  const base::UtcTime now = base::SystemClock().UtcNow();
  if (const absl::StatusOr<storage::JobQueue> jobs = core.database.CountJobs(); jobs.ok()) {
    gauges.is_store_up = core.database.TryWrite().ok();
    gauges.queued_jobs = jobs->queued;
    gauges.running_jobs = jobs->running;
    // A clock that was set back makes nothing younger than now.
    if (jobs->oldest_queued)
      gauges.oldest_queued =
          std::max(std::chrono::microseconds(0), std::chrono::microseconds(now - *jobs->oldest_queued));
  }
  if (const std::string& path = core.limits.database_file; !path.empty()) {
    gauges.database_bytes = metrics::FileBytes(path);
    gauges.write_ahead_log_bytes = metrics::FileBytes(path + "-wal");
    gauges.disk_free_bytes = metrics::DiskFreeBytes(path);
  }
  const HeldLimits& held = core.limits.held;
  gauges.streams = {{"upload", core.held.count(HeldKind::kUpload), held.max_uploads},
                    {"download", core.held.count(HeldKind::kDownload), held.max_downloads},
                    {"watch", core.held.count(HeldKind::kWatch), held.max_watches},
                    {"rewrite", core.held.count(HeldKind::kRewrite), held.max_rewrites}};
  for (const auto& [file, ends] : core.certificates())
    gauges.certificates.push_back({file, std::chrono::duration_cast<std::chrono::seconds>(ends - now)});
  if (const absl::StatusOr<storage::CellSums> cells = core.database.SumCells(); cells.ok()) {
    gauges.cells = {.well = cells->well,
                    .silent = cells->silent,
                    .with_problem = cells->with_problem,
                    .waiting_files = cells->waiting_files,
                    .waiting_bytes = cells->waiting_bytes,
                    .quarantined_files = cells->quarantined_files};
  }
  if (const auto webhooks = core.database.ListWebhooks(); webhooks.ok()) {
    metrics::Gauges::Webhooks sums;
    for (const records::WebhookRecord& webhook : *webhooks) {
      ++sums.webhooks;
      sums.failing += webhook.tries > 0 ? 1 : 0;
      sums.dead_letters += webhook.dead_letters;
    }
    gauges.webhooks = sums;
  }
  if (core.limits.measured_machines > 0) {
    const auto machines = core.database.MachinesWithEvents(core.limits.measured_machines);
    if (machines.ok())
      for (const auto& [machine, count] : *machines) gauges.machines.emplace_back(machine.text(), count);
  }
  gauges.is_draining = core.draining;
  v1::GetMetricsResponse response;
  response.set_text(core.metrics->Text(gauges));
  return response;
}

std::vector<metrics::Method> CountedMethods() {
  std::vector<metrics::Method> methods;
  const google::protobuf::DescriptorPool& pool = *google::protobuf::DescriptorPool::generated_pool();
  for (const access::MethodRule& rule : access::Methods()) {
    const google::protobuf::MethodDescriptor* const method = pool.FindMethodByName("axiscal.v1." + rule.method);
    if (method == nullptr) continue;  // a service that is not linked
    methods.push_back({rule.method, method->client_streaming(), method->server_streaming()});
  }
  return methods;
}

}  // namespace axiscal::handlers
