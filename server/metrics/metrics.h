// What a monitoring system asks for: counters of calls and jobs since the start, and gauges of this moment, in
// Prometheus' text format. Names and labels of calls are those in use for gRPC servers elsewhere (grpc_server_...), so
// that dashboards made for others fit; all else is axiscal_..., the process is process_... . No label holds a number of
// a record or a text that a caller wrote; names of machines only where that was switched on, of a few: each series is
// known when the server starts, or soon.
#ifndef AXISCAL_SERVER_METRICS_METRICS_H_
#define AXISCAL_SERVER_METRICS_METRICS_H_

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/clock.h"
#include "core/base/status.h"

namespace axiscal::metrics {

// "Admin.Backup" of the API.
struct Method {
  std::string name;
  bool is_client_stream = false, is_server_stream = false;
};

// What is looked up when it is asked for. What is not known now is left out.
struct Gauges {
  bool is_store_up = false;  // the store answered a question, and took what was written
  std::optional<int64_t> queued_jobs, running_jobs;
  std::chrono::microseconds oldest_queued{0};  // since it was created; 0 where none waits
  std::optional<int64_t> database_bytes, write_ahead_log_bytes, disk_free_bytes;
  struct Held {
    std::string kind;  // "upload", "download", "watch", "rewrite"
    int64_t count = 0, most = 0;
  };
  std::vector<Held> streams;
  struct Certificate {
    std::string file;
    std::chrono::seconds left{0};  // negative: it has ended
  };
  std::vector<Certificate> certificates;
  // Beside machines; a cell that serves several counts once.
  struct Cells {
    int64_t well = 0, silent = 0, with_problem = 0;
    int64_t waiting_files = 0, waiting_bytes = 0, quarantined_files = 0;  // of all spools
  };
  std::optional<Cells> cells;
  struct Webhooks {
    int64_t webhooks = 0, failing = 0, dead_letters = 0;  // failing: the newest try was without success
  };
  std::optional<Webhooks> webhooks;
  // The machines with most open events, and how many: where it is switched on, else empty.
  std::vector<std::pair<std::string, int64_t>> machines;
  bool is_draining = false;
};

// Safe from any thread.
class Metrics {
 public:
  // `methods`: all that may be called, each of which has its counters from the start, so that the first call is a
  // change; `job_kinds` likewise.
  Metrics(const std::string& version, const std::vector<Method>& methods, const std::vector<std::string>& job_kinds);
  ~Metrics();
  Metrics(const Metrics&) = delete;
  Metrics& operator=(const Metrics&) = delete;

  // A method that is not known counts as "unknown".
  void CallStarted(const std::string& method);
  void CallEnded(const std::string& method, absl::StatusCode code, std::chrono::duration<double> took);
  // An attempt of a job, and how long it took where that is known; `outcome` as jobs::JobEvent has it.
  void JobEnded(const std::string& kind, const std::string& outcome, std::optional<std::chrono::duration<double>> took);
  void ReadingsStored(int64_t count);
  // A letter to a webhook: "TAKEN", "FAILED" (it is tried again), "DEAD".
  void LetterSent(const std::string& outcome);

  // Prometheus' text format, version 0.0.4.
  std::string Text(const Gauges& gauges);

 private:
  class Impl;
  const std::unique_ptr<Impl> impl_;
};

// Bytes that are left for others than root on the file system of `path`; nothing where that cannot be asked.
std::optional<int64_t> DiskFreeBytes(const std::string& path);
std::optional<int64_t> FileBytes(const std::string& path);
// Of this process: files and connections.
struct Descriptors {
  std::optional<int64_t> open, most;
};
Descriptors CountDescriptors();

}  // namespace axiscal::metrics

#endif  // AXISCAL_SERVER_METRICS_METRICS_H_
