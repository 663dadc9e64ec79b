// An NC program through the service and back, beside the engine alone on the same bytes in the same run: 500,000
// five-axis blocks (30 MB) are put (PutProgram, client stream), compensated (COMPENSATE job) and fetched (GetProgram,
// server stream), with the client library over a local socket. `blocks/s` of each way; `ratio` is that of the whole
// way to the engine alone, `up_s`, `job_s`, `down_s` where the time goes.
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
  std::string text;
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
                     Run(convert::IdentifyParams{MachineId(kMachine), {upload.session.id}, {}}));
    ASSIGN_OR_RETURN(calibration, client->GetCalibration(job.calibration.value_or(CalibrationId())));
    return client->ApproveCalibration(calibration.id, calibration.etag, "bench").status();
  }

  absl::StatusOr<client::JobRecord> Run(const convert::JobParams& params) {
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

void ThroughTheService(benchmark::State& state) {
  const std::string program = Program();
  Service service;
  const auto fail = [&](const absl::Status& status) {
    if (!status.ok()) state.SkipWithError(status.ToString().c_str());
    return !status.ok();
  };
  if (fail(service.Start())) return;
  double up_s = 0, job_s = 0, down_s = 0, alone_s = 0;
  for (auto _ : state) {
    auto since = std::chrono::steady_clock::now();
    const auto put = service.client->PutProgram("part.nc", program);
    if (fail(put.status())) break;
    up_s += Seconds(since);
    since = std::chrono::steady_clock::now();
    convert::CompensateParams params;
    params.machine = MachineId(kMachine);
    params.program = put->id;
    params.tool_tip_mm = {0, 0, -356.4};
    const auto job = service.Run(params);
    if (fail(job.status())) break;
    job_s += Seconds(since);
    since = std::chrono::steady_clock::now();
    const auto back = service.client->GetProgram(job->programs.at(0));
    if (fail(back.status())) break;
    down_s += Seconds(since);
    state.PauseTiming();
    const auto alone = EngineAlone(program, service.calibration);
    if (fail(alone.status())) break;
    alone_s += *alone;
    state.ResumeTiming();
  }
  const auto per_round = [&](double seconds) { return seconds / static_cast<double>(state.iterations()); };
  state.counters["up_s"] = per_round(up_s);
  state.counters["job_s"] = per_round(job_s);
  state.counters["down_s"] = per_round(down_s);
  state.counters["alone_blocks/s"] = kBlocks / per_round(alone_s);
  state.counters["blocks/s"] = kBlocks / per_round(up_s + job_s + down_s);
  state.counters["ratio"] = alone_s / (up_s + job_s + down_s);
}
BENCHMARK(ThroughTheService)->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(3);

}  // namespace
}  // namespace axiscal
