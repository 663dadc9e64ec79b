// Rewriting of 1,000,000 five-axis blocks (60 MB, one thread) beside the limits of one core in the same run: memcpy,
// and a bare loop that parses every number with from_chars and writes X, Y and Z with to_chars, without modal state,
// model or report. `blocks/s` and `bytes_per_second` per benchmark; the ratio to the bare loop is what counts
// (at most 1 / 0.65).
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>

#include "core/base/units.h"
#include "core/compensate/compensator.h"
#include "core/machine/testing/machines.h"
#include "core/nc/rewrite.h"
#include "core/nc/verify.h"

namespace axiscal {
namespace {

constexpr int kBlocks = 1'000'000;

// Tool paths of the form of Yao's Fig 4.30, over the machine's whole travel.
const std::string& Program() {
  static const std::string* const program = [] {
    auto* text = new std::string();
    text->reserve(kBlocks * 64);
    char line[128];
    for (int i = 0; i < kBlocks; ++i) {
      const double t = i * 1e-3;
      const int size = std::snprintf(line, sizeof(line), "G01 X%.4f Y%.4f Z%.4f B%.4f C%.4f F2000\n",
                                     -390 + 90 * std::sin(t), 80 * std::cos(0.7 * t), -112 + 60 * std::sin(1.3 * t),
                                     45 + 44 * std::sin(0.31 * t), 180 * std::sin(0.11 * t));
      text->append(line, static_cast<size_t>(size));
    }
    return text;
  }();
  return *program;
}

const machine::Machine& Machine() {
  static const machine::Machine* const machine = [] {
    auto* counting_on = new machine::Machine(machine::testing::MultiTasking());
    for (machine::Axis& axis : counting_on->axes) {
      if (axis.kind == machine::AxisKind::kRotary) axis.roll_over = machine::RollOver::kNone;
    }
    return counting_on;
  }();
  return *machine;
}

// The declared errors of the machine: angles of 100 urad, offsets of 20 um.
machine::ErrorModel Errors(bool with_scale) {
  machine::ErrorModel errors = machine::DeclaredModel(Machine());
  for (auto& term : errors.terms) term.amplitude[0] = machine::IsAngle(term.component) ? 1e-4 : 0.02;
  if (with_scale) {
    machine::ErrorTerm scale = machine::ConstantTerm(Machine(), *machine::ParseErrorSymbol("EX0X"), 0.01);
    scale.shape = shapes::Linear{machine::FindAxis(Machine(), "X"), shapes::Linear::kReferenceMm};
    errors.terms.push_back(scale);
  }
  return errors;
}

compensate::Compensator MakeCompensator(bool with_scale) {
  compensate::Options options;
  options.tool_tip_mm = {0, 0, -356.3945};
  return *compensate::Compensator::Create(Machine(), Errors(with_scale), options);
}

void Count(benchmark::State& state) {
  state.SetBytesProcessed(static_cast<int64_t>(state.iterations()) * static_cast<int64_t>(Program().size()));
  state.counters["blocks/s"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * kBlocks, benchmark::Counter::kIsRate);
}

void Memcpy(benchmark::State& state) {
  std::string copy(Program().size(), 0);
  for (auto _ : state) {
    std::memcpy(copy.data(), Program().data(), copy.size());
    benchmark::ClobberMemory();
  }
  Count(state);
}
BENCHMARK(Memcpy)->Unit(benchmark::kMillisecond);

void FromCharsToChars(benchmark::State& state) {
  std::string out(Program().size() + Program().size() / 4, 0);
  for (auto _ : state) {
    const char* at = Program().data();
    const char* const end = at + Program().size();
    char* to = out.data();
    while (at != end) {
      const char letter = *at;
      *to++ = *at++;
      if (letter != 'X' && letter != 'Y' && letter != 'Z' && letter != 'B' && letter != 'C') continue;
      double value = 0;
      const char* const after = std::from_chars(at, end, value).ptr;
      if (letter == 'B' || letter == 'C') {
        std::memcpy(to, at, static_cast<size_t>(after - at));
        to += after - at;
      } else {
        to = std::to_chars(to, to + 32, value + 0.0417, std::chars_format::fixed, 4).ptr;
      }
      at = after;
    }
    benchmark::DoNotOptimize(to);
  }
  Count(state);
}
BENCHMARK(FromCharsToChars)->Unit(benchmark::kMillisecond);

nc::RewriteOptions InMillimetres() {
  nc::RewriteOptions options;
  options.unit = nc::ProgramUnit::kMillimetre;
  return options;
}

void Rewrite(benchmark::State& state, bool with_scale, double tolerance_mm, bool orientation = false) {
  const compensate::Compensator compensator = MakeCompensator(with_scale);
  nc::RewriteOptions options = InMillimetres();
  options.tolerance_mm = tolerance_mm;
  options.orientation = orientation;
  options.max_correction_mm = 5.0;
  std::string out(Program().size() + Program().size() / 4, 0);
  for (auto _ : state) {
    size_t written = 0;
    nc::RewriteReport report;
    const auto source = [](const nc::ByteSink& take) {
      constexpr size_t kPiece = 1u << 18;
      for (size_t at = 0; at < Program().size(); at += kPiece) {
        RETURN_IF_ERROR(take(Program().data() + at, std::min(kPiece, Program().size() - at)));
      }
      return absl::OkStatus();
    };
    const auto sink = [&](const char* bytes, size_t size) {
      std::memcpy(out.data() + written, bytes, size);
      written += size;
      return absl::OkStatus();
    };
    const absl::Status status = nc::RewriteProgram(source, sink, compensator, options, &report);
    if (!status.ok()) state.SkipWithError(std::string(status.message()).c_str());
    state.counters["split"] = static_cast<double>(report.blocks_split);
    state.counters["after_um"] = report.error_after.max_mm * base::kUmPerMm;
  }
  Count(state);
}
BENCHMARK_CAPTURE(Rewrite, constant_errors, false, 0.001)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Rewrite, constant_errors_never_split, false, std::numeric_limits<double>::infinity())
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Rewrite, position_dependent_errors, true, 0.001)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Rewrite, orientation_constant_errors, false, 0.001, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Rewrite, orientation_position_dependent_errors, true, 0.001, true)->Unit(benchmark::kMillisecond);

// The same words under tool centre point control: X, Y and Z stand in the workpiece's frame, near its origin.
const std::string& ToolPointProgram() {
  static const std::string* const program = [] {
    auto* text = new std::string("G90 G21 G0 X-390. Y80. Z-112. B45. C0.\nG43.4 H1\n");
    text->reserve(kBlocks * 64);
    char line[128];
    for (int i = 0; i < kBlocks; ++i) {
      const double t = i * 1e-3;
      const int size = std::snprintf(line, sizeof(line), "G01 X%.4f Y%.4f Z%.4f B%.4f C%.4f F2000\n", 90 * std::sin(t),
                                     80 * std::cos(0.7 * t), -112 + 60 * std::sin(1.3 * t),
                                     45 + 44 * std::sin(0.31 * t), 180 * std::sin(0.11 * t));
      text->append(line, static_cast<size_t>(size));
    }
    return text;
  }();
  return *program;
}

void RewriteToolPoint(benchmark::State& state, bool with_scale) {
  const compensate::Compensator compensator = MakeCompensator(with_scale);
  nc::RewriteOptions options = InMillimetres();
  options.max_correction_mm = 5.0;
  options.tool_lengths = {{1, 0.0}};
  const std::string& program = ToolPointProgram();  // made before the clock runs
  for (auto _ : state) {
    nc::RewriteReport report;
    const auto text = nc::RewriteText(program, compensator, options, &report);
    if (!text.ok()) {
      state.SkipWithError(std::string(text.status().message()).c_str());
      break;
    }
    state.counters["split"] = static_cast<double>(report.blocks_split);
    state.counters["after_um"] = report.error_after.max_mm * base::kUmPerMm;
  }
  Count(state);
}
BENCHMARK_CAPTURE(RewriteToolPoint, constant_errors, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(RewriteToolPoint, position_dependent_errors, true)->Unit(benchmark::kMillisecond);

// File to file, on the disk of the folder for temporary files (TMPDIR): the first number says how many million blocks,
// the second one is 1 where the output replaces a file of its size, whose room the disk gets back meanwhile. grown_MB
// is what the process' peak grew by: nothing, at any size.
void RewriteFileToFile(benchmark::State& state) {
  const compensate::Compensator compensator = MakeCompensator(false);
  const std::string folder = std::filesystem::temp_directory_path().string();
  const std::string input = folder + "/axiscal_bench_nc_in.nc", output = folder + "/axiscal_bench_nc_out.nc";
  std::FILE* file = std::fopen(input.c_str(), "wb");
  const size_t size = static_cast<size_t>(state.range(0)) * Program().size();
  for (size_t at = 0; at < size; at += Program().size()) std::fwrite(Program().data(), 1, Program().size(), file);
  std::fclose(file);
  rusage before{}, after{};
  getrusage(RUSAGE_SELF, &before);
  for (auto _ : state) {
    if (state.range(1) == 0) {
      state.PauseTiming();
      std::filesystem::remove(output);
      state.ResumeTiming();
    }
    nc::RewriteReport report;
    const absl::Status status = nc::RewriteFile(input, output, compensator, InMillimetres(), &report);
    if (!status.ok()) state.SkipWithError(std::string(status.message()).c_str());
  }
  getrusage(RUSAGE_SELF, &after);
  state.counters["grown_MB"] = static_cast<double>(after.ru_maxrss - before.ru_maxrss) / 1024;
  state.SetBytesProcessed(static_cast<int64_t>(state.iterations()) * static_cast<int64_t>(size));
  std::filesystem::remove(input);
  std::filesystem::remove(output);
}
BENCHMARK(RewriteFileToFile)->Args({1, 0})->Args({1, 1})->Args({3, 1})->Unit(benchmark::kMillisecond)->UseRealTime();

// What a technician runs: the program and its correction. Of the ratio to the bare loop docs/nc.md speaks.
void Verify(benchmark::State& state, bool with_scale) {
  const compensate::Compensator compensator = MakeCompensator(with_scale);
  nc::RewriteReport rewritten;
  const auto corrected = nc::RewriteText(Program(), compensator, InMillimetres(), &rewritten);
  if (!corrected.ok()) return state.SkipWithError(std::string(corrected.status().message()).c_str());
  nc::VerifyOptions options;
  options.reading.unit = nc::ProgramUnit::kMillimetre;
  options.tool_tip_mm = {0, 0, -356.3945};
  for (auto _ : state) {
    const auto report = nc::VerifyText(Program(), *corrected, Machine(), Errors(with_scale), options);
    if (!report.ok()) {
      state.SkipWithError(std::string(report.status().message()).c_str());
      break;
    }
    state.counters["after_um"] = report->end_after.max_mm * base::kUmPerMm;
    state.counters["blocks/s"] =
        benchmark::Counter(static_cast<double>(report->moves), benchmark::Counter::kIsIterationInvariantRate);
  }
}
BENCHMARK_CAPTURE(Verify, constant_errors, false)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(Verify, position_dependent_errors, true)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

}  // namespace
}  // namespace axiscal
