// Durable ingest (FULL: acknowledged means fsynced) and history over ten years. AXISCAL_BENCH_MACHINES sets the size of
// the fleet (default 100; 1000 takes some minutes to build and 6 GB); the files stand in the temporary directory while
// it runs.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <thread>

#include "server/storage/chunk_codec.h"
#include "server/storage/estimates.h"
#include "server/storage/sqlite_connection.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

using session::Column;

// What a 1 kHz ball-bar run looks like: time, two commanded axes as full doubles, measured axes and length on their
// scales' grid.
std::vector<Column> BallbarColumns(int64_t first, int count) {
  std::mt19937 random(static_cast<uint32_t>(first));
  std::normal_distribution<double> noise_um(0.0, 0.3);
  std::vector<Column> columns(9);
  const char* const names[] = {"t_s", "X_mm", "Y_mm", "Z_mm", "X2_mm", "Y2_mm", "B_deg", "dL_mm", "temp_C"};
  for (int i = 0; i < 9; ++i) columns[i].name = names[i];
  const auto on_grid = [](double value, double steps) { return std::round(value * steps) / steps; };
  for (int i = 0; i < count; ++i) {
    const double t_s = static_cast<double>(first + i) / 1000.0, angle = 0.5 * t_s;
    const double values[] = {t_s,
                             150.0 * std::cos(angle),
                             150.0 * std::sin(angle),
                             -100.0,
                             on_grid(150.0 * std::cos(angle) + 1e-3 * noise_um(random), 1e4),
                             on_grid(150.0 * std::sin(angle) + 1e-3 * noise_um(random), 1e4),
                             on_grid(angle * 10.0, 1e4),
                             on_grid(1e-3 * noise_um(random), 1e4),
                             on_grid(20.0 + 0.001 * t_s, 1e2)};
    for (int c = 0; c < 9; ++c) columns[c].values.push_back(values[c]);
  }
  return columns;
}

NewSession BallbarSession() {
  NewSession session = TestSession("");
  session.columns.clear();
  for (const Column& column : BallbarColumns(0, 1)) session.columns.push_back({column.name, false});
  return session;
}

// Streams append chunks of `range(1)` readings, at most 8 each under way; one iteration is one chunk on each of
// `range(0)` streams' behalf.
void BM_DurableIngest(benchmark::State& state) {
  const int streams = static_cast<int>(state.range(0)), readings = static_cast<int>(state.range(1));
  constexpr int kChunks = 64, kWindow = 8;
  const std::vector<Column> columns = BallbarColumns(0, readings);
  std::vector<records::Chunk> chunks;
  for (int seq = 0; seq < kChunks; ++seq) chunks.push_back(records::Chunk::Seal(seq, columns));
  TempDirectory directory;
  SqliteOptions options;
  options.path = directory.File("ingest.db");
  const std::unique_ptr<Database> database = *OpenSqlite(options);
  DEMAND(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
  for (auto _ : state) {
    std::vector<std::thread> threads;
    for (int stream = 0; stream < streams; ++stream) {
      threads.emplace_back([&] {
        const SessionId id = database->CreateSession(BallbarSession())->id;
        std::atomic<int> under_way = 0;
        for (int seq = 0; seq < kChunks; ++seq) {
          for (int now = under_way.load(); now >= kWindow; now = under_way.load()) under_way.wait(now);
          ++under_way;
          database->AppendChunkAsync(id, chunks[seq], [&under_way](absl::StatusOr<AppendResult> result) {
            DEMAND(result.ok());
            --under_way;
            under_way.notify_one();
          });
        }
        for (int now = under_way.load(); now > 0; now = under_way.load()) under_way.wait(now);
      });
    }
    for (std::thread& thread : threads) thread.join();
  }
  state.SetItemsProcessed(state.iterations() * streams * kChunks * readings);
  state.counters["B/reading"] = static_cast<double>(EncodeChunk(columns).size()) / readings;
}
BENCHMARK(BM_DurableIngest)
    ->Args({1, 1000})
    ->Args({4, 1000})
    ->Args({16, 1000})
    ->Args({1, 100})
    ->Args({1, 4096})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// How long a chunk waits for its acknowledgement at most while a backup of 256 MB is made, and while none is: one
// stream that sends a chunk of 1000 readings when the one before is on the disk.
void BM_AppendDuringBackup(benchmark::State& state) {
  const bool with_backup = state.range(0) != 0;
  constexpr int64_t kBytes = 256 << 20;
  TempDirectory directory;
  SqliteOptions options;
  options.path = directory.File("store.db");
  const std::unique_ptr<Database> database = *OpenSqlite(options);
  DEMAND(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
  {
    std::mt19937_64 random(1);
    const SessionId id = database->CreateSession(BallbarSession())->id;
    std::vector<Column> columns = BallbarColumns(0, 4096);
    for (int64_t seq = 0, bytes = 0; bytes < kBytes; ++seq) {
      for (Column& column : columns) {
        for (double& value : column.values) value = static_cast<double>(random() >> 12);
      }
      const records::Chunk chunk = records::Chunk::Seal(seq, columns);
      bytes += static_cast<int64_t>(EncodeChunk(chunk.columns()).size());
      DEMAND(database->AppendChunk(id, chunk).ok());
    }
  }
  std::vector<double> waits_ms;
  const SessionId id = database->CreateSession(BallbarSession())->id;
  const std::vector<Column> columns = BallbarColumns(0, 1000);
  int64_t seq = 0;
  for (auto _ : state) {
    std::atomic<bool> is_over = false;
    std::thread other([&] {
      if (with_backup) {
        DEMAND(database->Backup(directory.File("copy.db"), nullptr).ok());
        std::filesystem::remove(directory.File("copy.db"));
      } else {
        std::this_thread::sleep_for(std::chrono::seconds(5));
      }
      is_over = true;
    });
    while (!is_over) {
      const records::Chunk chunk = records::Chunk::Seal(seq++, columns);
      const auto start = std::chrono::steady_clock::now();
      DEMAND(database->AppendChunk(id, chunk).ok());
      waits_ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
    other.join();
  }
  std::sort(waits_ms.begin(), waits_ms.end());
  const auto quantile = [&](double share) {
    return waits_ms[static_cast<size_t>(share * static_cast<double>(waits_ms.size() - 1))];
  };
  state.counters["chunks"] = static_cast<double>(waits_ms.size());
  state.counters["p50_ms"] = quantile(0.5);
  state.counters["p99_ms"] = quantile(0.99);
  state.counters["max_ms"] = quantile(1.0);
}
BENCHMARK(BM_AppendDuringBackup)
    ->ArgName("backup")
    ->Arg(0)
    ->Arg(1)
    ->Iterations(1)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void BM_EncodeChunk(benchmark::State& state) {
  const std::vector<Column> columns = BallbarColumns(0, 1000);
  for (auto _ : state) benchmark::DoNotOptimize(EncodeChunk(columns));
  state.SetItemsProcessed(state.iterations() * 1000);
}
BENCHMARK(BM_EncodeChunk);

void BM_DecodeChunk(benchmark::State& state) {
  const std::string bytes = EncodeChunk(BallbarColumns(0, 1000));
  const std::vector<ColumnSpec> specs = BallbarSession().columns;
  for (auto _ : state) benchmark::DoNotOptimize(DecodeChunk(bytes, specs));
  state.SetItemsProcessed(state.iterations() * 1000);
}
BENCHMARK(BM_DecodeChunk);

constexpr int kSymbols = 13;
constexpr int kDays = 3650;
constexpr int64_t kDayUs = kWeekUs / 7;
constexpr int64_t kFirstUs = 1'400'000'000'000'000;

// Ten years of daily calibrations; machine after machine, each in the order of time, so that pages split as they would
// have.
class Fleet {
 public:
  Fleet() {
    const char* const wanted = std::getenv("AXISCAL_BENCH_MACHINES");
    machines = wanted != nullptr ? std::max(std::atoi(wanted), 1) : 100;
    SqliteOptions options;
    options.path = directory_.File("fleet.db");
    database = *OpenSqlite(options);
    for (int m = 0; m < machines; ++m) DEMAND(database->CreateMachine(Name(m), "{}", Cell("")).ok());
    database.reset();
    Fill(options.path);
    database = *OpenSqlite(options);
  }
  static MachineId Name(int machine) { return MachineId(absl::StrFormat("m%04d", machine)); }

  int machines = 0;
  std::unique_ptr<Database> database;

 private:
  // Rows as CreateCalibration makes them, many in one transaction.
  void Fill(const std::string& path) {
    const std::unique_ptr<SqliteConnection> connection = *SqliteConnection::Open(path, Access::kWrite);
    std::mt19937 random(1);
    std::normal_distribution<double> step(0.0, 0.2);
    int64_t id = 0;
    for (int m = 0; m < machines; ++m) {
      DEMAND(connection->Execute("BEGIN").ok());
      for (int day = 0; day < kDays; ++day) {
        const UtcTime at = base::FromUtcUs(kFirstUs + day * kDayUs + static_cast<int64_t>(random() % 3600) * 1'000'000);
        std::vector<Estimate> estimates;
        for (int s = 0; s < kSymbols; ++s)
          estimates.push_back({absl::StrFormat("E%02d", s), EstimateUnit::kUm, true, step(random), 0.5});
        id = *connection->Insert(
            "INSERT INTO calibration (machine_id, version, machine_revision, state, etag, "
            "measured_at_utc_us, model_json, "
            "options_json, report_json, engine_version, rank, created_by, created_at_utc_us) "
            "VALUES (?1, ?2, 1, 1, 1, ?3, '{}', '{}', '{}', 'bench', 13, 'bench', ?3)",
            m + 1, day + 1, at);
        DEMAND(InsertEstimates(*connection, m + 1, at, CalibrationId(id), estimates).ok());
      }
      DEMAND(connection->Execute("COMMIT").ok());
      if (m % 4 == 0) DEMAND(connection->Execute("PRAGMA wal_checkpoint(TRUNCATE)").ok());
    }
  }

  TempDirectory directory_;
};

Fleet& TheFleet() {
  static Fleet fleet;
  return fleet;
}

double Percentile(std::vector<double>& sorted_ms, double fraction) {
  std::sort(sorted_ms.begin(), sorted_ms.end());
  return sorted_ms[static_cast<size_t>(fraction * static_cast<double>(sorted_ms.size() - 1))];
}

template <typename Query>
void Measure(benchmark::State& state, const Query& query) {
  std::mt19937 random(2);
  std::vector<double> times_ms;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    query(static_cast<int>(random() % TheFleet().machines));
    times_ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  state.counters["p50_ms"] = Percentile(times_ms, 0.50);
  state.counters["p99_ms"] = Percentile(times_ms, 0.99);
}

// Ten years of `range(0)` symbols of one machine, at most `range(1)` points each.
void BM_QueryDrift(benchmark::State& state) {
  Measure(state, [&](int machine) {
    DriftQuery query = {Fleet::Name(machine),
                        {},
                        base::FromUtcUs(kFirstUs),
                        base::FromUtcUs(kFirstUs + kDays * kDayUs),
                        static_cast<int>(state.range(1))};
    for (int s = 0; s < state.range(0); ++s) query.symbols.push_back(absl::StrFormat("E%02d", s));
    const auto drift = TheFleet().database->QueryDrift(query);
    DEMAND(drift.ok() && static_cast<int>(drift->size()) == state.range(0));
  });
}
BENCHMARK(BM_QueryDrift)
    ->Args({1, 200})
    ->Args({1, 1000})
    ->Args({1, 5000})
    ->Args({13, 200})
    ->Args({13, 500})
    ->Iterations(1000)
    ->Unit(benchmark::kMillisecond);

// A page of 100 machines, the newest estimate of `range(0)` symbols each.
void BM_LatestFleet(benchmark::State& state) {
  Measure(state, [&](int machine) {
    std::vector<std::string> symbols;
    for (int s = 0; s < state.range(0); ++s) symbols.push_back(absl::StrFormat("E%02d", s));
    DEMAND(TheFleet().database->LatestFleet(symbols, {100, ""}).ok());
  });
}
BENCHMARK(BM_LatestFleet)->Arg(1)->Arg(13)->Iterations(1000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace axiscal::storage
