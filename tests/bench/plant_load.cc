// A plant at its busiest, over TLS: 64 cells that upload without a pause, 8 dashboards that ask for histories, and in
// the second half 4 technicians whose jobs follow each other.
//   plant_load [SECONDS]      of both halves together; 600 without it
// Prints a table, and fails where a limit is not held: no error but RESOURCE_EXHAUSTED, at most 512 MB of memory, the
// slowest hundredth of the histories at most 3 times as slow with jobs as without.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <mutex>
#include <thread>

#include "core/base/demand.h"
#include "core/base/error_detail.h"
#include "core/base/testing/source_path.h"
#include "server/access/gate.h"
#include "server/storage/sqlite_database.h"
#include "server/storage/testing/temp_database.h"
#include "tests/end_to_end/testing/fixture.h"
#include "tests/end_to_end/testing/process.h"

namespace axiscal {
namespace {

using records::Role;
using std::chrono::steady_clock;

constexpr int kCells = 64, kDashboards = 8, kTechnicians = 4;
constexpr int kReadings = 5000;
constexpr int kCalibrations = 520;  // one a week for ten years
constexpr int64_t kMostMemory = int64_t{512} << 20;
constexpr double kMostSlower = 3.0;
constexpr char kMachine[] = "mt";

bool IsUnderWay(client::JobState state) {
  return state == client::JobState::kQueued || state == client::JobState::kRunning;
}

// What all callers of a half have seen.
class Seen {
 public:
  void Add(const std::string& what, const absl::Status& status, steady_clock::time_point start) {
    const double took_ms = std::chrono::duration<double, std::milli>(steady_clock::now() - start).count();
    const std::lock_guard<std::mutex> lock(mutex_);
    if (status.ok()) {
      took_ms_[what].push_back(took_ms);
    } else if (absl::IsResourceExhausted(status)) {
      ++refused_;
    } else {
      ++errors_;
      std::fprintf(stderr, "%s: %s\n", what.c_str(), status.ToString().c_str());
    }
  }
  // After all callers have ended.
  double QuantileMs(const std::string& what, double share) {
    std::vector<double>& all = took_ms_[what];
    if (all.empty()) return 0;
    std::sort(all.begin(), all.end());
    return all[static_cast<size_t>(share * static_cast<double>(all.size() - 1))];
  }
  size_t CountOf(const std::string& what) { return took_ms_[what].size(); }
  int64_t errors() const { return errors_; }
  int64_t refused() const { return refused_; }

 private:
  std::mutex mutex_;
  std::map<std::string, std::vector<double>> took_ms_;
  int64_t errors_ = 0, refused_ = 0;
};

class Plant {
 public:
  explicit Plant(const std::string& folder) : folder_(folder) {
    for (const std::string words : {"ca", "server localhost 127.0.0.1"}) {
      const std::string command =
          base::SourcePath("/deploy/make-certs") + " " + folder_ + "/pki " + words + " >/dev/null";
      DEMAND(std::system(command.c_str()) == 0);
    }
    storage::SqliteOptions options;
    options.path = folder_ + "/axiscal.db";
    const std::unique_ptr<storage::Database> database = *storage::OpenSqlite(options);
    DEMAND(database->CreateMachine(MachineId(kMachine), testing::MachineJson(kMachine), kSetup).ok());
    const base::UtcTime first = base::SystemClock().UtcNow() - std::chrono::hours(24 * 7 * kCalibrations);
    for (int week = 0; week < kCalibrations; ++week)
      DEMAND(
          database->CreateCalibration(storage::TestCalibration(first + std::chrono::hours(24 * 7 * week), 0.1 * week))
              .ok());
    for (int i = 0; i < kCells; ++i) Add(*database, absl::StrCat("cell-", i), Role::kCell);
    for (int i = 0; i < kDashboards; ++i) Add(*database, absl::StrCat("dashboard-", i), Role::kViewer);
    for (int i = 0; i < kTechnicians; ++i) Add(*database, absl::StrCat("technician-", i), Role::kTechnician);
  }
  absl::Status Start() {
    ASSIGN_OR_RETURN(testing::ServerProcess started,
                     testing::ServerProcess::Start(folder_ + "/axiscal.db", "127.0.0.1:0", folder_ + "/log",
                                                   {"--tls-certificate", folder_ + "/pki/server/localhost.crt",
                                                    "--tls-key", folder_ + "/pki/server/localhost.key"}));
    server_.emplace(std::move(started));
    return absl::OkStatus();
  }
  client::Client ClientOf(const std::string& name) const {
    client::Options options;
    options.identity.ca = folder_ + "/pki/ca.crt";
    options.identity.token_file = folder_ + "/" + name;
    // What else this machine does is no error of the server.
    options.connect_deadline = std::chrono::minutes(1);
    options.call_deadline = std::chrono::minutes(2);
    auto client = client::Client::Connect(server_->address(), options);
    DEMAND(client.ok());
    return *std::move(client);
  }
  int64_t PeakMemoryBytes() const { return server_->PeakMemoryBytes(); }
  double CpuSeconds() const { return server_->CpuSeconds(); }

  // Everybody works until `end`.
  void Work(bool with_jobs, steady_clock::time_point end, Seen& seen) {
    ++half_;
    std::vector<std::thread> threads;
    for (int i = 0; i < kCells; ++i) threads.emplace_back([&, i] { Upload(i, end, seen); });
    for (int i = 0; i < kDashboards; ++i) threads.emplace_back([&, i] { AskForHistories(i, end, seen); });
    for (int i = 0; with_jobs && i < kTechnicians; ++i) threads.emplace_back([&, i] { RunJobs(i, end, seen); });
    for (std::thread& thread : threads) thread.join();
  }

 private:
  static inline const storage::Caller kSetup = {"setup", ""};

  void Add(storage::Database& database, const std::string& name, Role role) {
    const std::string token = access::NewToken();
    DEMAND(database.CreatePrincipal(name, "", kSetup).ok());
    DEMAND(database.ChangeRole(name, {role, {}}, true, kSetup).ok());
    DEMAND(database.CreateToken({name, access::HashOfToken(token), "", {}}, kSetup).ok());
    std::ofstream(folder_ + "/" + name) << token << "\n";
  }
  void Upload(int cell, steady_clock::time_point end, Seen& seen) {
    client::Client client = ClientOf(absl::StrCat("cell-", cell));
    for (int n = 0; steady_clock::now() < end; ++n) {
      const session::Session session =
          testing::BallbarSession(kMachine, absl::StrCat("S", half_, "-", cell, "-", n), kReadings);
      const auto start = steady_clock::now();
      seen.Add("upload", client.Upload(MachineId(kMachine), session).status(), start);
    }
  }
  void AskForHistories(int dashboard, steady_clock::time_point end, Seen& seen) {
    client::Client client = ClientOf(absl::StrCat("dashboard-", dashboard));
    while (steady_clock::now() < end) {
      const base::UtcTime now = base::SystemClock().UtcNow();
      const auto start = steady_clock::now();
      seen.Add("history",
               client.QueryDrift({MachineId(kMachine), {}, now - std::chrono::hours(24 * 3660), now, 1000}).status(),
               start);
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }
  void RunJobs(int technician, steady_clock::time_point end, Seen& seen) {
    client::Client client = ClientOf(absl::StrCat("technician-", technician));
    const client::SessionFilter of_machine = {.machine = MachineId(kMachine),
                                              .state = records::SessionState::kComplete};
    for (uint64_t n = 1; steady_clock::now() < end; ++n) {
      const auto sessions = client.ListSessions(of_machine);
      if (!sessions.ok() || sessions->rows.empty()) continue;
      records::IdentifyParams params;
      params.machine = MachineId(kMachine);
      params.sessions = {sessions->rows.back().id};
      params.declared = {"EX0C", "EY0C"};
      params.monte_carlo_runs = 200;
      params.monte_carlo_seed = static_cast<uint64_t>(technician) << 32 | n;  // another job each time
      const auto start = steady_clock::now();
      auto job = client.CreateJob(params);
      while (job.ok() && IsUnderWay(job->state)) job = client.WaitJob(job->id, std::chrono::seconds(20));
      absl::Status status = job.status();
      if (job.ok() && job->state != client::JobState::kSucceeded)
        status = absl::InternalError(job->error ? job->error->message : "the job did not succeed");
      seen.Add("job", status, start);
    }
  }

  const std::string folder_;
  std::optional<testing::ServerProcess> server_;
  int half_ = 0;
};

int Run(int seconds) {
  const testing::TempDir folder;
  Plant plant(folder.File(""));
  const absl::Status started = plant.Start();
  if (!started.ok()) {
    std::fprintf(stderr, "%s\n", started.ToString().c_str());
    return 1;
  }
  std::printf("LOAD %-13s %9s %9s %9s %9s %9s %12s %12s %8s %8s %13s\n", "half", "uploads", "readings", "histories",
              "jobs", "refused", "history p50", "history p99", "errors", "MB", "uploads/CPU s");
  double p99_ms[2] = {};
  int64_t errors = 0;
  bool has_worked = true;
  for (const bool with_jobs : {false, true}) {
    Seen seen;
    const double cpu_before_s = plant.CpuSeconds();
    plant.Work(with_jobs, steady_clock::now() + std::chrono::seconds(seconds) / 2, seen);
    p99_ms[with_jobs] = seen.QuantileMs("history", 0.99);
    errors += seen.errors();
    has_worked &= seen.CountOf("upload") > 0 && seen.CountOf("history") > 0 && (!with_jobs || seen.CountOf("job") > 0);
    // Of all that the server did, jobs and histories too.
    const double cpu_s = plant.CpuSeconds() - cpu_before_s;
    std::printf("LOAD %-13s %9zu %9zu %9zu %9zu %9lld %9.1f ms %9.1f ms %8lld %8lld %13.1f\n",
                with_jobs ? "with jobs" : "without jobs", seen.CountOf("upload"), seen.CountOf("upload") * kReadings,
                seen.CountOf("history"), seen.CountOf("job"), static_cast<long long>(seen.refused()),
                seen.QuantileMs("history", 0.5), p99_ms[with_jobs], static_cast<long long>(seen.errors()),
                static_cast<long long>(plant.PeakMemoryBytes() >> 20),
                static_cast<double>(seen.CountOf("upload")) / cpu_s);
    std::fflush(stdout);
  }
  const bool is_small = plant.PeakMemoryBytes() <= kMostMemory;
  const bool is_fair = p99_ms[1] <= kMostSlower * p99_ms[0];
  std::printf(
      "LOAD errors %lld; peak memory %lld MB, at most 512: %s; histories %.2f times as slow with jobs, at most 3: "
      "%s\n",
      static_cast<long long>(errors), static_cast<long long>(plant.PeakMemoryBytes() >> 20),
      is_small ? "held" : "NOT HELD", p99_ms[1] / p99_ms[0], is_fair ? "held" : "NOT HELD");
  return has_worked && errors == 0 && is_small && is_fair ? 0 : 1;
}

}  // namespace
}  // namespace axiscal

int main(int argc, char** argv) { return axiscal::Run(argc > 1 ? std::max(2, std::atoi(argv[1])) : 600); }
