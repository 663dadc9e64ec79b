// A session through the client library into the service's store, over a local socket, beside the bare program
// (bare_upload.h) with the same readings, turn by turn in the same run. `ratio` is that of `readings/s` to the bare
// one's: what checks, checksums, compression and resumable sessions cost. `cpu_ns` is what client and server compute,
// per reading.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <ctime>
#include <optional>
#include <random>

#include "core/base/demand.h"
#include "server/server.h"
#include "tests/bench/bare_upload.h"
#include "tests/end_to_end/testing/fixture.h"

namespace axiscal {
namespace {

constexpr int kReadings = 400'000;
constexpr char kMachine[] = "mt";

// Where a position or a length comes from: a controller's display (0.1 um, 0.0001 deg), or a simulation's full doubles.
enum class Digits { kShown, kFull };

// A ball bar at 1 kHz, circle after circle at 1 m/min while the table turns with it.
session::Session CircularTest(const std::string& name, Digits digits) {
  session::Session session = testing::BallbarSession(kMachine, name, 0);
  session.columns.push_back({"temp_C", {}, {}});
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise_mm(0.0, 3e-4);
  const auto shown = [&](double value, double steps) {
    return digits == Digits::kShown ? std::round(value * steps) / steps : value;
  };
  for (int i = 0; i < kReadings; ++i) {
    const double t_s = std::round(i) / 1000.0, angle = t_s / 6.0;
    const double row[] = {t_s,
                          shown(100.0 * std::cos(angle), 1e4),
                          shown(100.0 * std::sin(angle), 1e4),
                          421.9,
                          0.0,
                          shown(angle * 180.0 / M_PI, 1e4),
                          shown(-0.012 * std::cos(angle) + noise_mm(random), 1e4),
                          shown(20.0 + 1e-3 * t_s, 1e2)};
    for (size_t k = 0; k < session.columns.size(); ++k) session.columns[k].values.push_back(row[k]);
  }
  return session;
}

// Time spent so far: by the clock, and by all threads of this process, which are client and server. s
struct Spent {
  double wall_s = 0, cpu_s = 0;

  static Spent Now() {
    return {std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(),
            static_cast<double>(std::clock()) / CLOCKS_PER_SEC};
  }
  void AddSince(const Spent& start) {
    const Spent now = Now();
    wall_s += now.wall_s - start.wall_s;
    cpu_s += now.cpu_s - start.cpu_s;
  }
};

void Upload(benchmark::State& state, Digits digits) {
  session::Session session = CircularTest("BX", digits);
  testing::TempDir folder;
  server::ServerOptions options;
  options.database_path = folder.File("axiscal.db");
  options.listen_address = "unix:" + folder.File("socket");
  const std::unique_ptr<server::Server> server = server::Server::Start(options).value();
  client::Client client = client::Client::Connect(options.listen_address, {.user = "bench"}).value();
  DEMAND(client.CreateMachine(testing::MachineJson(kMachine)).ok());

  const std::string bare_address = "unix:" + folder.File("bare");
  const bench::BareServer bare_server(bench::NewSqliteTable(folder.File("bare.db")), bare_address);
  const auto stub = bench::BareUpload::NewStub(grpc::CreateChannel(bare_address, grpc::InsecureChannelCredentials()));

  Spent ours, bare;
  int round = 0;
  for (auto _ : state) {
    // Another name: the same session again would be there already.
    for (session::HeaderEntry& entry : session.header)
      if (entry.key == "session") entry.value = "BX" + std::to_string(round);
    ++round;
    const Spent start = Spent::Now();
    const auto uploaded = client.Upload(MachineId(kMachine), session, nullptr);
    ours.AddSince(start);
    if (!uploaded.ok()) return state.SkipWithError(uploaded.status().ToString().c_str());
    DEMAND(uploaded->session.reading_count == kReadings && !uploaded->was_there);
    state.PauseTiming();
    const Spent bare_start = Spent::Now();
    bench::BareUploadAll(*stub, session, client::Options().chunk_readings);
    bare.AddSince(bare_start);
    state.ResumeTiming();
  }
  const double readings = static_cast<double>(state.iterations()) * kReadings;
  state.counters["bare_readings/s"] = readings / bare.wall_s;
  state.counters["readings/s"] = readings / ours.wall_s;
  state.counters["bare_cpu_ns"] = 1e9 * bare.cpu_s / readings;
  state.counters["cpu_ns"] = 1e9 * ours.cpu_s / readings;
  state.counters["ratio"] = bare.wall_s / ours.wall_s;
}
BENCHMARK_CAPTURE(Upload, shown_digits, Digits::kShown)->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(10);
BENCHMARK_CAPTURE(Upload, full_doubles, Digits::kFull)->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(10);

}  // namespace
}  // namespace axiscal
