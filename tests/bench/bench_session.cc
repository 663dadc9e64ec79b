// Reading and writing of session files (a ball-bar log of 200,000 readings, 13 MB) beside memcpy of the same bytes.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstring>
#include <string>

#include "core/session/read_session.h"
#include "core/session/write_session.h"

namespace axiscal::session {
namespace {

const std::string& Log() {
  static const std::string* const log = [] {
    auto* text = new std::string(
        "# machine: mt\n# session: BX\n# instrument: ballbar\n# sigma_um: 0.3\n# tool_tip_mm: 0 0 -356.4\n"
        "# table_ball_mm: 0 0 65.5\n# bar_length_mm: 100\nt_s,X_mm,Y_mm,Z_mm,B_deg,C_deg,temp_C,dL_mm\n");
    for (int i = 0; i < 200'000; ++i) {
      const double t = i * 1e-3;
      absl::StrAppendFormat(text, "%.3f,%.4f,%.4f,%.4f,%.4f,%.4f,%.3f,%.4f\n", t, 100 * std::cos(t), 100 * std::sin(t),
                            421.9 - t, std::fmod(t, 90.0), 0.0, 20.0, 0.0179 * std::sin(3 * t));
    }
    return text;
  }();
  return *log;
}

void CountBytes(benchmark::State& state) {
  state.SetBytesProcessed(static_cast<int64_t>(state.iterations()) * static_cast<int64_t>(Log().size()));
}

void BM_Memcpy(benchmark::State& state) {
  std::string copy(Log().size(), '\0');
  for (auto _ : state) {
    std::memcpy(copy.data(), Log().data(), copy.size());
    benchmark::DoNotOptimize(copy.data());
  }
  CountBytes(state);
}
BENCHMARK(BM_Memcpy);

void BM_ReadSession(benchmark::State& state) {
  for (auto _ : state) {
    const auto session = ReadSessionText(Log(), "log");
    if (!session.ok()) state.SkipWithError(std::string(session.status().message()).c_str());
    benchmark::DoNotOptimize(session);
  }
  CountBytes(state);
}
BENCHMARK(BM_ReadSession)->Unit(benchmark::kMillisecond);

void BM_WriteSession(benchmark::State& state) {
  const auto session = ReadSessionText(Log(), "log");
  for (auto _ : state) {
    const auto text = WriteSession(*session);
    benchmark::DoNotOptimize(text);
  }
  CountBytes(state);
}
BENCHMARK(BM_WriteSession)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace axiscal::session
