// An NC program through the service and back, beside the engine alone on the same bytes in the same run: 500,000
// five-axis blocks (30 MB) with the client library over a local socket. Streamed: RewriteProgram, both streams at once.
// Stored: put (PutProgram), compensated (COMPENSATE job), fetched (GetProgram); `up_s`, `job_s`, `down_s` say where the
// time goes. `ratio` is that of `blocks/s` to the engine alone.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>

#include "core/compensate/compensator.h"
#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"
#include "core/nc/rewrite.h"
#include "server/server.h"
#include "tests/end_to_end/testing/fixture.h"

namespace axiscal {
namespace {

constexpr int kBlocks = 500'000;
constexpr char kMachine[] = "mt";

std::string Program() {
  std::string text = "G21\n";
  char line[128];
  for (int i = 0; i < kBlocks; ++i) {
    const double t = i * 1e-3;
    const int size = std::snprintf(line, sizeof(line), "G01 X%.4f Y%.4f Z%.4f B%.4f C%.4f F2000\n",
                                   -390 + 90 * std::sin(t), 80 * std::cos(0.7 * t), -112 + 60 * std::sin(1.3 * t),
                                   45 + 44 * std::sin(0.31 * t), 180 * std::sin(0.11 * t));
    text.append(line, static_cast<size_t>(size));
  }
  return text;
}

double Seconds(std::chrono::steady_clock::time_point since) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - since).count();
}

// A server on a socket, a client of it, and an approved calibration of a machine.
struct Service {
  testing::TempDir folder;
  std::unique_ptr<server::Server> server;
  std::optional<client::Client> client;
  client::CalibrationRecord calibration;

  absl::Status Start() {
    server::ServerOptions options;
    options.database_path = folder.File("axiscal.db");
    options.listen_address = "unix:" + folder.File("socket");
    ASSIGN_OR_RETURN(server, server::Server::Start(options));
    ASSIGN_OR_RETURN(client::Client connected, client::Client::Connect(options.listen_address, {.user = "bench"}));
    client.emplace(std::move(connected));
    RETURN_IF_ERROR(client->CreateMachine(testing::MachineJson(kMachine)).status());
    ASSIGN_OR_RETURN(const auto upload,
                     client->Upload(MachineId(kMachine), testing::BallbarSession(kMachine, "BX", 360), nullptr));
    ASSIGN_OR_RETURN(const client::JobRecord job,
                     Run(records::IdentifyParams{MachineId(kMachine), {upload.session.id}, {}}));
    ASSIGN_OR_RETURN(calibration, client->GetCalibration(job.calibration.value_or(CalibrationId())));
    return client->ApproveCalibration(calibration.id, calibration.etag).status();
  }

  absl::StatusOr<client::JobRecord> Run(const records::JobParams& params) {
    ASSIGN_OR_RETURN(const client::JobRecord created, client->CreateJob(params));
    ASSIGN_OR_RETURN(client::JobRecord ended, client->WatchJob(created.id, nullptr));
    if (ended.error) return absl::InternalError(ended.error->message);
    return ended;
  }
};

absl::StatusOr<double> EngineAlone(const std::string& program, const client::CalibrationRecord& calibration) {
  ASSIGN_OR_RETURN(const machine::Machine machine, machine::MachineFromJson(testing::MachineJson(kMachine)));
  ASSIGN_OR_RETURN(const machine::ErrorModel errors, machine::ReadErrors(calibration.content.model_json, machine));
  ASSIGN_OR_RETURN(const compensate::Compensator compensator,
                   compensate::Compensator::Create(machine, errors, {{0, 0, -356.4}, {}, {}}));
  const auto start = std::chrono::steady_clock::now();
  nc::RewriteReport report;
  RETURN_IF_ERROR(nc::RewriteText(program, compensator, {}, &report).status());
  return Seconds(start);
}

void Fail(const absl::Status& status, benchmark::State& state) {
  if (!status.ok()) state.SkipWithError(status.ToString().c_str());
}

records::CompensateParams Params() {
  records::CompensateParams params;
  params.machine = MachineId(kMachine);
  params.tool_tip_mm = {0, 0, -356.4};
  return params;
}

// Times of one round, s.
struct Round {
  double alone = 0, up = 0, job = 0, down = 0, whole = 0;
};

absl::Status StoredRound(Service& service, const std::string& program, Round& round) {
  const auto start = std::chrono::steady_clock::now();
  records::CompensateParams params = Params();
  ASSIGN_OR_RETURN(const client::ProgramRecord put, service.client->PutProgram("part.nc", program));
  params.program = put.id;
  round.up += Seconds(start);
  const auto since_put = std::chrono::steady_clock::now();
  ASSIGN_OR_RETURN(const client::JobRecord job, service.Run(params));
  round.job += Seconds(since_put);
  const auto since_job = std::chrono::steady_clock::now();
  RETURN_IF_ERROR(service.client->GetProgram(job.programs.at(0)).status());
  round.down += Seconds(since_job);
  round.whole += Seconds(start);
  return absl::OkStatus();
}

absl::Status StreamedRound(Service& service, const std::string& program, Round& round) {
  const auto start = std::chrono::steady_clock::now();
  std::string back;
  RETURN_IF_ERROR(service.client
                      ->RewriteProgram(Params(), program,
                                       [&](const std::string& bytes) {
                                         back += bytes;
                                         return absl::OkStatus();
                                       })
                      .status());
  round.whole += Seconds(start);
  return absl::OkStatus();
}

using OneRound = absl::Status (*)(Service& service, const std::string& program, Round& round);

void ThroughTheService(benchmark::State& state, OneRound one_round) {
  const std::string program = Program();
  Service service;
  if (const absl::Status started = service.Start(); !started.ok()) return Fail(started, state);
  Round sum;
  for (auto _ : state) {
    if (const absl::Status done = one_round(service, program, sum); !done.ok()) return Fail(done, state);
    state.PauseTiming();
    const auto alone = EngineAlone(program, service.calibration);
    if (!alone.ok()) return Fail(alone.status(), state);
    sum.alone += *alone;
    state.ResumeTiming();
  }
  const auto rounds = static_cast<double>(state.iterations());
  state.counters["up_s"] = sum.up / rounds;
  state.counters["job_s"] = sum.job / rounds;
  state.counters["down_s"] = sum.down / rounds;
  state.counters["alone_blocks/s"] = kBlocks * rounds / sum.alone;
  state.counters["blocks/s"] = kBlocks * rounds / sum.whole;
  state.counters["ratio"] = sum.alone / sum.whole;
}
BENCHMARK_CAPTURE(ThroughTheService, streamed, StreamedRound)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Iterations(5);
BENCHMARK_CAPTURE(ThroughTheService, stored, StoredRound)->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(3);

}  // namespace
}  // namespace axiscal
