// What tests/bench/scale runs: each word does one thing with a store on PostgreSQL and prints one line of numbers.
//   scale_load receive URL ADDRESS                     the bare receiver (bare_upload.h); until stdin ends
//   scale_load upload bare|axiscal STREAMS SECONDS ADDRESS...
//       streams that upload sessions of kReadings one after the other:     "readings seconds CPU_seconds_of_clients"
//   scale_load history MACHINES CALLERS CALLS ADDRESS...
//       a year of all errors of a machine m0000001 ..., at random:         "calls/s p50_ms p99_ms"
//   scale_load claim URL JOBS CLAIMS                   JOBS are queued by kPrincipals, then the store claims some of
//                                                      them, one after the other: "p50_ms p99_ms slowest_ms"
//   scale_load jobs CALLERS SECONDS READINGS ADDRESS...
//       identifications of a session, each asked for when the one before is done: "jobs seconds p50_ms p99_ms"
#include <libpq-fe.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <deque>
#include <functional>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/base/demand.h"
#include "server/storage/postgres_database.h"
#include "tests/bench/bare_upload.h"
#include "tests/end_to_end/testing/fixture.h"

namespace axiscal {
namespace {

using std::chrono::steady_clock;
using Addresses = std::vector<std::string>;

constexpr int kReadings = 40'000;  // of a session: a ball bar's at 1 kHz in 40 s
constexpr int kPrincipals = 20;    // among whom the queue is fair
constexpr size_t kWorkers = 6;     // so many jobs run: of three axiscald
constexpr char kMachine[] = "bench";

double SecondsSince(steady_clock::time_point start) {
  return std::chrono::duration<double>(steady_clock::now() - start).count();
}

// Prints what failed and ends: a number of a run in which something failed would mean nothing.
template <typename Result>
auto Expect(Result result, const char* what) {
  if (result.ok()) return *std::move(result);
  std::fprintf(stderr, "scale_load: %s: %s\n", what, result.status().ToString().c_str());
  std::exit(1);
}

client::Client ConnectTo(const std::string& address) {
  client::Options options;
  options.user = "bench";
  options.connect_deadline = std::chrono::minutes(1);
  options.call_deadline = std::chrono::minutes(2);
  return Expect(client::Client::Connect(address, options), "connect");
}

// One transaction of inserts, as SqliteTable.
class PostgresTable final : public bench::BareTable {
 public:
  explicit PostgresTable(const std::string& url) : connection_(PQconnectdb(url.c_str())) {
    Run("DROP TABLE IF EXISTS bare_chunk; CREATE TABLE bare_chunk (id BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY, "
        "seq BIGINT NOT NULL, cells BYTEA NOT NULL); ALTER TABLE bare_chunk ALTER COLUMN cells SET STORAGE EXTERNAL; "
        "SET synchronous_commit = on");
    PGresult* const prepared =
        PQprepare(connection_, "put", "INSERT INTO bare_chunk (seq, cells) VALUES ($1, $2)", 2, nullptr);
    DEMAND(PQresultStatus(prepared) == PGRES_COMMAND_OK);
    PQclear(prepared);
  }
  ~PostgresTable() override { PQfinish(connection_); }

  void Write(const std::vector<bench::BareChunk>& group) override {
    Run("BEGIN");
    for (const bench::BareChunk& chunk : group) {
      const std::string seq = absl::StrCat(chunk.seq());
      const char* const values[] = {seq.c_str(), chunk.cells().data()};
      const int sizes[] = {0, static_cast<int>(chunk.cells().size())}, formats[] = {0, 1};
      PGresult* const put = PQexecPrepared(connection_, "put", 2, values, sizes, formats, 1);
      DEMAND(PQresultStatus(put) == PGRES_COMMAND_OK);
      PQclear(put);
    }
    Run("COMMIT");
  }

 private:
  void Run(const char* sql) {
    PGresult* const result = PQexec(connection_, sql);
    DEMAND(PQresultStatus(result) == PGRES_COMMAND_OK);
    PQclear(result);
  }

  PGconn* const connection_;
};

int Receive(const std::string& url, const std::string& address) {
  const bench::BareServer server(std::make_unique<PostgresTable>(url), address);
  std::printf("receives\n");
  std::fflush(stdout);
  while (std::getchar() != EOF) continue;
  return 0;
}

// `call(i)` in `callers` threads, i = 0 ..., each with its own number.
void InThreads(int callers, const std::function<void(int)>& call) {
  std::vector<std::thread> threads;
  for (int i = 0; i < callers; ++i) threads.emplace_back([&call, i] { call(i); });
  for (std::thread& thread : threads) thread.join();
}

class Times {
 public:
  void Add(double seconds) {
    const std::lock_guard lock(mutex_);
    ms_.push_back(1e3 * seconds);
  }
  // Of what was added, of which there is some.
  double QuantileMs(double share) {
    std::sort(ms_.begin(), ms_.end());
    return ms_.at(static_cast<size_t>(share * static_cast<double>(ms_.size() - 1)));
  }
  size_t count() const { return ms_.size(); }

 private:
  std::mutex mutex_;
  std::vector<double> ms_;
};

void MakeMachine(const std::string& address) {
  client::Client client = ConnectTo(address);
  if (!client.GetMachine(MachineId(kMachine)).ok())
    Expect(client.CreateMachine(testing::MachineJson(kMachine)), "machine");
}

int Upload(bool is_bare, int streams, double seconds, const Addresses& addresses) {
  if (!is_bare) MakeMachine(addresses[0]);
  const auto start = steady_clock::now();
  const std::clock_t cpu = std::clock();
  const std::string run = absl::StrCat(base::ToUtcUs(base::SystemClock().UtcNow()));
  std::atomic<int64_t> readings = 0;
  InThreads(streams, [&](int i) {
    const std::string& address = addresses[static_cast<size_t>(i) % addresses.size()];
    session::Session session = testing::BallbarSession(kMachine, "", kReadings);
    const auto bare = bench::BareUpload::NewStub(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
    std::optional<client::Client> client;
    if (!is_bare) client = ConnectTo(address);
    for (int n = 0; SecondsSince(start) < seconds; ++n) {
      session.header[1].value = absl::StrCat("S", run, "-", i, "-", n);
      if (is_bare) {
        bench::BareUploadAll(*bare, session, client::Options().chunk_readings);
      } else {
        Expect(client->Upload(MachineId(kMachine), session), "upload");
      }
      readings += kReadings;
    }
  });
  std::printf("%lld %.6f %.6f\n", static_cast<long long>(readings.load()), SecondsSince(start),
              static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC);
  return 0;
}

int AskForHistories(int machines, int callers, int calls, const Addresses& addresses) {
  Times times;
  const base::UtcTime now = base::SystemClock().UtcNow();
  std::vector<client::Client> clients;
  for (int i = 0; i < callers; ++i) clients.push_back(ConnectTo(addresses[static_cast<size_t>(i) % addresses.size()]));
  const auto start = steady_clock::now();
  InThreads(callers, [&](int i) {
    std::mt19937 random(static_cast<uint32_t>(i));
    for (int n = 0; n < calls; ++n) {
      const std::string machine = absl::StrFormat("m%07d", 1 + random() % static_cast<uint32_t>(machines));
      const auto begin = steady_clock::now();
      const auto series = Expect(clients[static_cast<size_t>(i)].QueryDrift(
                                     {MachineId(machine), {}, now - std::chrono::hours(24 * 400), now, 500}),
                                 "history");
      times.Add(SecondsSince(begin));
      // A history that is empty would be fast, too.
      DEMAND(!series.empty() && !series.front().points.empty());
    }
  });
  std::printf("%.1f %.3f %.3f\n", static_cast<double>(times.count()) / SecondsSince(start), times.QuantileMs(0.5),
              times.QuantileMs(0.99));
  return 0;
}

void RunOn(const std::string& url, const std::string& sql) {
  PGconn* const connection = PQconnectdb(url.c_str());
  PGresult* const result = PQexec(connection, sql.c_str());
  if (PQresultStatus(result) != PGRES_COMMAND_OK) {
    std::fprintf(stderr, "scale_load: %s: %s\n", sql.c_str(), PQerrorMessage(connection));
    std::exit(1);
  }
  PQclear(result);
  PQfinish(connection);
}

int Claim(const std::string& url, int jobs, int claims) {
  storage::PostgresOptions options;
  options.url = url;
  const auto database = Expect(storage::OpenPostgres(options), "open");
  // One of each by the store, so that its checksums are right; then copies of them.
  for (int i = 0; i < kPrincipals; ++i) {
    storage::NewJob job;
    job.kind = "identify";
    job.params = "nothing";
    job.caller = {absl::StrCat("principal-", i), ""};
    Expect(database->CreateJob(job, {jobs, 0, 0}), "job");
  }
  const std::string columns =
      "kind, machine_id, params, input_hash, priority, state, attempt, max_attempts, lease_token, cancel_requested, "
      "progress_stage, progress_fraction, progress_detail, created_by, body_sha256, created_at_utc_us, "
      "waits_from_up_us, wait_us, version, trace";
  RunOn(url, absl::StrCat("INSERT INTO job (", columns, ") SELECT ", columns,
                          " FROM job CROSS JOIN generate_series(2, ", jobs / kPrincipals, ") WHERE state = 1"));
  RunOn(url, "ANALYZE job");
  Times times;
  std::deque<storage::JobClaim> running;
  for (int n = 0; n < claims; ++n) {
    const auto begin = steady_clock::now();
    const auto job = Expect(database->ClaimJob(std::chrono::minutes(10)), "claim");
    times.Add(SecondsSince(begin));
    DEMAND(job.has_value());
    running.push_back(storage::ClaimOf(*job));
    if (running.size() < kWorkers) continue;
    Expect(database->EndJob(running.front(), storage::JobEnd::kFailed, {}, std::chrono::seconds(0)), "end");
    running.pop_front();
  }
  std::printf("%.3f %.3f %.3f\n", times.QuantileMs(0.5), times.QuantileMs(0.99), times.QuantileMs(1.0));
  return 0;
}

int RunJobs(int callers, double seconds, int readings, const Addresses& addresses) {
  MakeMachine(addresses[0]);
  client::Client first = ConnectTo(addresses[0]);
  const std::string name = absl::StrCat("J", base::ToUtcUs(base::SystemClock().UtcNow()));
  const SessionId session =
      Expect(first.Upload(MachineId(kMachine), testing::BallbarSession(kMachine, name, readings)), "upload").session.id;
  Times times;
  std::atomic<uint64_t> seed = static_cast<uint64_t>(base::ToUtcUs(base::SystemClock().UtcNow()));
  const auto start = steady_clock::now();
  InThreads(callers, [&](int i) {
    client::Client client = ConnectTo(addresses[static_cast<size_t>(i) % addresses.size()]);
    while (SecondsSince(start) < seconds) {
      records::IdentifyParams params;
      params.machine = MachineId(kMachine);
      params.sessions = {session};
      params.declared = {"EX0C", "EY0C"};
      params.monte_carlo_runs = 2;
      params.monte_carlo_seed = ++seed;  // another job each time
      const auto begin = steady_clock::now();
      client::JobRecord job = Expect(client.CreateJob(params), "job");
      while (job.state == client::JobState::kQueued || job.state == client::JobState::kRunning)
        job = Expect(client.WaitJob(job.id, std::chrono::seconds(20)), "job");
      DEMAND(job.state == client::JobState::kSucceeded);
      times.Add(SecondsSince(begin));
    }
  });
  std::printf("%zu %.6f %.3f %.3f\n", times.count(), SecondsSince(start), times.QuantileMs(0.5),
              times.QuantileMs(0.99));
  return 0;
}

int Run(const std::vector<std::string>& words) {
  const auto rest = [&](size_t from) {
    return Addresses(words.begin() + static_cast<std::ptrdiff_t>(from), words.end());
  };
  const auto number = [&](size_t at) { return std::max(std::atoi(words[at].c_str()), 1); };
  const std::string what = words.empty() ? "" : words[0];
  if (what == "receive" && words.size() == 3) return Receive(words[1], words[2]);
  if (what == "upload" && words.size() >= 5) return Upload(words[1] == "bare", number(2), number(3), rest(4));
  if (what == "history" && words.size() >= 5) return AskForHistories(number(1), number(2), number(3), rest(4));
  if (what == "claim" && words.size() == 4) return Claim(words[1], number(2), number(3));
  if (what == "jobs" && words.size() >= 5) return RunJobs(number(1), number(2), number(3), rest(4));
  std::fprintf(stderr, "scale_load: receive, upload, history, claim or jobs: see the head of scale_load.cc\n");
  return 2;
}

}  // namespace
}  // namespace axiscal

int main(int argc, char** argv) { return axiscal::Run(std::vector<std::string>(argv + 1, argv + argc)); }
