#include "server/metrics/metrics.h"

#include <dirent.h>
#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <map>

#include "core/base/mutex.h"

namespace axiscal::metrics {
namespace {

using Labels = prometheus::Labels;

// gRPC's names as Prometheus' gRPC libraries write them.
const char* CodeName(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kOk:
      return "OK";
    case absl::StatusCode::kCancelled:
      return "Canceled";
    case absl::StatusCode::kInvalidArgument:
      return "InvalidArgument";
    case absl::StatusCode::kDeadlineExceeded:
      return "DeadlineExceeded";
    case absl::StatusCode::kNotFound:
      return "NotFound";
    case absl::StatusCode::kAlreadyExists:
      return "AlreadyExists";
    case absl::StatusCode::kPermissionDenied:
      return "PermissionDenied";
    case absl::StatusCode::kResourceExhausted:
      return "ResourceExhausted";
    case absl::StatusCode::kFailedPrecondition:
      return "FailedPrecondition";
    case absl::StatusCode::kAborted:
      return "Aborted";
    case absl::StatusCode::kOutOfRange:
      return "OutOfRange";
    case absl::StatusCode::kUnimplemented:
      return "Unimplemented";
    case absl::StatusCode::kInternal:
      return "Internal";
    case absl::StatusCode::kUnavailable:
      return "Unavailable";
    case absl::StatusCode::kDataLoss:
      return "DataLoss";
    case absl::StatusCode::kUnauthenticated:
      return "Unauthenticated";
    default:
      return "Unknown";
  }
}

// Seconds. From a lookup in memory to the longest call that is no stream; a loop on a large machine takes an hour.
const prometheus::Histogram::BucketBoundaries kCallSeconds = {0.001, 0.005, 0.02, 0.1, 0.5, 2, 10, 60};
const prometheus::Histogram::BucketBoundaries kJobSeconds = {0.05, 0.2, 1, 5, 20, 60, 300, 1200, 3600};

constexpr char kUnknown[] = "unknown";

}  // namespace

class Metrics::Impl {
 public:
  Impl(const std::string& version, const std::vector<Method>& methods, const std::vector<std::string>& job_kinds) {
    Gauge("axiscal_build_info", "1; the version is in the label", {{"version", version}}).Set(1);
    Gauge("process_start_time_seconds", "Seconds since 1970-01-01 UTC at which the server started")
        .Set(static_cast<double>(base::ToUtcUs(base::SystemClock().UtcNow())) / 1e6);
    Calls& unknown = calls_[kUnknown];
    unknown.labels = {{"grpc_type", "unary"}, {"grpc_service", kUnknown}, {"grpc_method", kUnknown}};
    for (const Method& method : methods) {
      const size_t dot = method.name.find('.');
      const std::string type = method.is_client_stream ? (method.is_server_stream ? "bidi_stream" : "client_stream")
                                                       : (method.is_server_stream ? "server_stream" : "unary");
      Calls& calls = calls_[method.name];
      calls.labels = {{"grpc_type", type},
                      {"grpc_service", "axiscal.v1." + method.name.substr(0, dot)},
                      {"grpc_method", method.name.substr(dot + 1)}};
      if (type == "unary") calls.seconds = &call_seconds_.Add(calls.labels, kCallSeconds);
    }
    for (auto& [name, calls] : calls_) {
      calls.started = &calls_started_.Add(calls.labels);
      // All of them: a series that begins with its first error has no rate until the second.
      for (int code = 0; code <= static_cast<int>(absl::StatusCode::kUnauthenticated); ++code)
        Handled(calls, static_cast<absl::StatusCode>(code));
    }
    for (const std::string& kind : job_kinds) {
      job_seconds_.Add({{"kind", kind}}, kJobSeconds);
      for (const char* outcome : {"SUCCEEDED", "FAILED", "DEAD"})
        job_attempts_.Add({{"kind", kind}, {"outcome", outcome}});
    }
    for (const char* outcome : {"TAKEN", "FAILED", "DEAD"}) letters_.Add({{"outcome", outcome}});
  }

  void CallStarted(const std::string& method) { CallsOf(method).started->Increment(); }
  void CallEnded(const std::string& method, absl::StatusCode code, double seconds) {
    Calls& calls = CallsOf(method);
    Handled(calls, code).Increment();
    // How long a stream lasts is up to its caller.
    if (calls.seconds != nullptr) calls.seconds->Observe(seconds);
  }
  void JobEnded(const std::string& kind, const std::string& outcome,
                std::optional<std::chrono::duration<double>> took) {
    job_attempts_.Add({{"kind", kind}, {"outcome", outcome}}).Increment();
    if (took) job_seconds_.Add({{"kind", kind}}, kJobSeconds).Observe(took->count());
  }
  void LetterSent(const std::string& outcome) { letters_.Add({{"outcome", outcome}}).Increment(); }
  void ReadingsStored(int64_t count) { readings_.Increment(static_cast<double>(count)); }

  std::string Text(const Gauges& now) {
    const base::MutexLock lock(text_mutex_);
    Gauge("axiscal_store_up", "1: the store answered a question and took what was written").Set(now.is_store_up);
    Gauge("axiscal_draining", "1: the server is stopping").Set(now.is_draining);
    constexpr char kJobs[] = "axiscal_jobs", kJobsHelp[] = "Jobs that wait or run now";
    SetIf(kJobs, kJobsHelp, {{"state", "queued"}}, now.queued_jobs);
    SetIf(kJobs, kJobsHelp, {{"state", "running"}}, now.running_jobs);
    SetIf("axiscal_oldest_queued_job_age_seconds", "Since the oldest waiting job was created; 0 where none waits", {},
          now.queued_jobs ? std::optional(std::chrono::duration<double>(now.oldest_queued).count()) : std::nullopt);
    SetIf("axiscal_database_bytes", "Size of the database file", {}, now.database_bytes);
    SetIf("axiscal_write_ahead_log_bytes", "Size of the database's write-ahead log", {}, now.write_ahead_log_bytes);
    SetIf("axiscal_disk_free_bytes", "Left on the database's file system", {}, now.disk_free_bytes);
    for (const Gauges::Held& held : now.streams) {
      Gauge("axiscal_streams", "Streams that are open now", {{"kind", held.kind}}).Set(static_cast<double>(held.count));
      Gauge("axiscal_streams_most", "Streams that may be open at a time", {{"kind", held.kind}})
          .Set(static_cast<double>(held.most));
    }
    for (const Gauges::Certificate& certificate : now.certificates) {
      Gauge("axiscal_certificate_remaining_seconds", "Until the certificate ends; negative: it has ended",
            {{"file", certificate.file}})
          .Set(static_cast<double>(certificate.left.count()));
    }
    SetCells(now.cells);
    SetWebhooks(now.webhooks);
    SetMachines(now.machines);
    SetProcess();
    return prometheus::TextSerializer().Serialize(registry_.Collect());
  }

 private:
  struct Calls {
    Labels labels;
    prometheus::Counter* started = nullptr;
    prometheus::Histogram* seconds = nullptr;  // null: a stream
  };

  Calls& CallsOf(const std::string& method) {
    const auto found = calls_.find(method);
    return found == calls_.end() ? calls_.at(kUnknown) : found->second;
  }
  prometheus::Counter& Handled(const Calls& calls, absl::StatusCode code) {
    Labels labels = calls.labels;
    labels["grpc_code"] = CodeName(code);
    return calls_handled_.Add(labels);
  }
  // The library gives the same object for the same name and labels.
  prometheus::Gauge& Gauge(const std::string& name, const std::string& help, const Labels& labels = {}) {
    return prometheus::BuildGauge().Name(name).Help(help).Register(registry_).Add(labels);
  }
  // What is not known now does not stay what it was.
  template <typename Value>
  void SetIf(const std::string& name, const std::string& help, const Labels& labels, std::optional<Value> value) {
    auto& family = prometheus::BuildGauge().Name(name).Help(help).Register(registry_);
    prometheus::Gauge& gauge = family.Add(labels);
    if (value) {
      gauge.Set(static_cast<double>(*value));
    } else {
      family.Remove(&gauge);
    }
  }
  void SetCells(const std::optional<Gauges::Cells>& cells) {
    const auto of = [&](int64_t Gauges::Cells::*field) {
      return cells ? std::optional((*cells).*field) : std::nullopt;
    };
    constexpr char kCells[] = "axiscal_cells", kCellsHelp[] = "PCs beside machines that report how they stand";
    SetIf(kCells, kCellsHelp, {{"state", "well"}}, of(&Gauges::Cells::well));
    SetIf(kCells, kCellsHelp, {{"state", "problem"}}, of(&Gauges::Cells::with_problem));
    SetIf(kCells, kCellsHelp, {{"state", "silent"}}, of(&Gauges::Cells::silent));
    SetIf("axiscal_cells_waiting_files", "Files that wait in the spools of all cells", {},
          of(&Gauges::Cells::waiting_files));
    SetIf("axiscal_cells_waiting_bytes", "Their size", {}, of(&Gauges::Cells::waiting_bytes));
    SetIf("axiscal_cells_quarantined_files", "Files of cells that were refused and wait for a person", {},
          of(&Gauges::Cells::quarantined_files));
  }
  void SetWebhooks(const std::optional<Gauges::Webhooks>& webhooks) {
    const auto of = [&](int64_t Gauges::Webhooks::*field) {
      return webhooks ? std::optional((*webhooks).*field) : std::nullopt;
    };
    SetIf("axiscal_webhooks", "Addresses that are told of events", {}, of(&Gauges::Webhooks::webhooks));
    SetIf("axiscal_webhooks_failing", "Of them such as did not take the newest letter", {},
          of(&Gauges::Webhooks::failing));
    SetIf("axiscal_webhook_dead_letters", "Letters that are not tried any more", {},
          of(&Gauges::Webhooks::dead_letters));
  }
  // A machine that is no longer among the worst has no series.
  void SetMachines(const std::vector<std::pair<std::string, int64_t>>& machines) {
    auto& family = prometheus::BuildGauge()
                       .Name("axiscal_machine_open_events")
                       .Help("Events that stand, neither acknowledged nor shelved: of the machines with most of them")
                       .Register(registry_);
    std::map<std::string, prometheus::Gauge*> kept;
    for (const auto& [machine, count] : machines) {
      prometheus::Gauge& gauge = family.Add({{"machine", machine}});
      gauge.Set(static_cast<double>(count));
      kept[machine] = &gauge;
      machines_.erase(machine);
    }
    for (const auto& [machine, gauge] : machines_) family.Remove(gauge);
    machines_ = std::move(kept);
  }
  void SetProcess() {
    rusage used{};
    if (getrusage(RUSAGE_SELF, &used) == 0) {
      const auto seconds = [](const timeval& time) {
        return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
      };
      // Counters of the library can be added to, not set.
      cpu_seconds_.Increment(seconds(used.ru_utime) + seconds(used.ru_stime) - cpu_seconds_.Value());
    }
    int64_t pages = 0, resident = 0;
    if (std::ifstream("/proc/self/statm") >> pages >> resident) {
      Gauge("process_resident_memory_bytes", "Memory in use")
          .Set(static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)));
    }
    const Descriptors descriptors = CountDescriptors();
    SetIf("process_open_fds", "Open descriptors: files and connections", {}, descriptors.open);
    SetIf("process_max_fds", "Descriptors that may be open", {}, descriptors.most);
  }

  prometheus::Registry registry_;
  prometheus::Family<prometheus::Counter>& calls_started_ =
      prometheus::BuildCounter().Name("grpc_server_started_total").Help("Calls that began").Register(registry_);
  prometheus::Family<prometheus::Counter>& calls_handled_ =
      prometheus::BuildCounter().Name("grpc_server_handled_total").Help("Calls that ended").Register(registry_);
  prometheus::Family<prometheus::Histogram>& call_seconds_ = prometheus::BuildHistogram()
                                                                 .Name("grpc_server_handling_seconds")
                                                                 .Help("Duration of calls that are no streams")
                                                                 .Register(registry_);
  prometheus::Family<prometheus::Counter>& job_attempts_ = prometheus::BuildCounter()
                                                               .Name("axiscal_job_attempts_total")
                                                               .Help("Attempts of jobs that ended")
                                                               .Register(registry_);
  prometheus::Family<prometheus::Histogram>& job_seconds_ =
      prometheus::BuildHistogram().Name("axiscal_job_seconds").Help("Duration of attempts of jobs").Register(registry_);
  prometheus::Family<prometheus::Counter>& letters_ = prometheus::BuildCounter()
                                                          .Name("axiscal_webhook_letters_total")
                                                          .Help("Tries to bring letters to webhooks")
                                                          .Register(registry_);
  prometheus::Counter& readings_ = prometheus::BuildCounter()
                                       .Name("axiscal_readings_stored_total")
                                       .Help("Readings that were uploaded and stored")
                                       .Register(registry_)
                                       .Add({});
  prometheus::Counter& cpu_seconds_ = prometheus::BuildCounter()
                                          .Name("process_cpu_seconds_total")
                                          .Help("Time of processor used")
                                          .Register(registry_)
                                          .Add({});
  std::map<std::string, Calls> calls_;                  // not changed after the constructor
  base::Mutex text_mutex_;                              // gauges are set and collected together
  std::map<std::string, prometheus::Gauge*> machines_;  // that have a series now
};

Metrics::Metrics(const std::string& version, const std::vector<Method>& methods,
                 const std::vector<std::string>& job_kinds)
    : impl_(std::make_unique<Impl>(version, methods, job_kinds)) {}
Metrics::~Metrics() = default;

void Metrics::CallStarted(const std::string& method) { impl_->CallStarted(method); }
void Metrics::CallEnded(const std::string& method, absl::StatusCode code, std::chrono::duration<double> took) {
  impl_->CallEnded(method, code, took.count());
}
void Metrics::JobEnded(const std::string& kind, const std::string& outcome,
                       std::optional<std::chrono::duration<double>> took) {
  impl_->JobEnded(kind, outcome, took);
}
void Metrics::LetterSent(const std::string& outcome) { impl_->LetterSent(outcome); }
void Metrics::ReadingsStored(int64_t count) { impl_->ReadingsStored(count); }
std::string Metrics::Text(const Gauges& gauges) { return impl_->Text(gauges); }

Descriptors CountDescriptors() {
  Descriptors count;
  if (DIR* const folder = opendir("/proc/self/fd")) {
    count.open = -3;  // ".", "..", and the folder itself
    while (readdir(folder) != nullptr) ++*count.open;
    closedir(folder);
  }
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) == 0) count.most = static_cast<int64_t>(limit.rlim_cur);
  return count;
}

std::optional<int64_t> DiskFreeBytes(const std::string& path) {
  struct statvfs disk {};
  if (statvfs(path.c_str(), &disk) != 0) return std::nullopt;
  return static_cast<int64_t>(disk.f_bavail) * static_cast<int64_t>(disk.f_frsize);
}

std::optional<int64_t> FileBytes(const std::string& path) {
  struct stat file {};
  if (stat(path.c_str(), &file) != 0) return std::nullopt;
  return static_cast<int64_t>(file.st_size);
}

}  // namespace axiscal::metrics
