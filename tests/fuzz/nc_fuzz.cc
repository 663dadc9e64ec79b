// Programs of any bytes: the rewriter never crashes, a null correction returns the bytes, pieces of any size give the
// same output, and what was rewritten once is refused the next time.
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/crc32c.h"
#include "core/compensate/compensator.h"
#include "core/machine/testing/machines.h"
#include "core/nc/dialect.h"
#include "core/nc/rewrite.h"
#include "core/nc/verify.h"
#include "tests/fuzz/driver.h"

namespace axiscal {
namespace {

const machine::Machine& Machine() {
  static const machine::Machine* const machine = new machine::Machine(machine::testing::MultiTasking());
  return *machine;
}

const machine::ErrorModel& Errors() {
  static const machine::ErrorModel* const errors = [] {
    auto* model = new machine::ErrorModel(machine::DeclaredModel(Machine()));
    for (auto& term : model->terms) term.amplitude[0] = machine::IsAngle(term.component) ? 1e-4 : 0.02;
    return model;
  }();
  return *errors;
}

constexpr double kToolMm = -350.0;

compensate::Compensator MakeCompensator(const machine::ErrorModel& errors) {
  compensate::Options options;
  options.tool_tip_mm = {0, 0, kToolMm};
  return *compensate::Compensator::Create(Machine(), errors, options);
}

absl::StatusOr<std::string> InPieces(const std::string& program, size_t piece,
                                     const compensate::Compensator& compensator, const nc::RewriteOptions& options) {
  std::string text;
  nc::RewriteReport report;
  const auto source = [&](const nc::ByteSink& take) {
    for (size_t at = 0; at < program.size(); at += piece) {
      RETURN_IF_ERROR(take(program.data() + at, std::min(piece, program.size() - at)));
    }
    return absl::OkStatus();
  };
  const auto sink = [&text](const char* bytes, size_t size) {
    text.append(bytes, size);
    return absl::OkStatus();
  };
  RETURN_IF_ERROR(nc::RewriteProgram(source, sink, compensator, options, &report));
  return text;
}

// The dialect that a program looks like, else any.
std::string DialectOf(const std::string& program, uint32_t choice) {
  const auto has = [&program](const char* text) { return program.find(text) != std::string::npos; };
  if (has("PGM") || has("FMAX") || has("L X")) return "heidenhain";
  if (has("_N_") || has("CR=") || has("SUPA")) return "sinumerik";
  return nc::Dialects()[choice % nc::Dialects().size()].name;
}

void RunOne(const std::string& program) {
  static const compensate::Compensator* const perfect = new compensate::Compensator(MakeCompensator({}));
  static const compensate::Compensator* const leaning = new compensate::Compensator(MakeCompensator(Errors()));
  nc::RewriteReport report;
  // One choice of options per program: mutations meet all of them.
  const uint32_t variant = base::Crc32c(0, program.data(), program.size());
  nc::RewriteOptions null_options;
  null_options.dialect = DialectOf(program, variant >> 8);
  const auto same = nc::RewriteText(program, *perfect, null_options, &report);
  MUST(same.ok() && *same == program);
  MUST(!reports::ToJson(nc::ReportOf(report)).empty());

  nc::RewriteOptions options;
  options.unit = variant & 8 ? nc::ProgramUnit::kInch : nc::ProgramUnit::kMillimetre;
  options.dialect = null_options.dialect;
  options.work_offsets = {{"G55", {{"X", 12.5}, {"C", 0.5}}}, {"G54.1 P1", {{"Z", -3.0}}}};
  options.tool_lengths = {{1, 25.0}};
  options.initial_position = {{"X", 0}, {"Y", 0}, {"Z", 0}, {"B", 0}, {"C", 0}};
  if (variant & 1) options.on_unsupported = nc::OnUnsupported::kPass;
  if (variant & 2) options.integer_words = nc::IntegerWords::kLeastIncrement;
  if (variant & 2) options.block_delete = nc::BlockDelete::kExecuted;
  options.orientation = variant & 4;
  options.max_rotary_correction_rad = 0.01;
  options.tolerance_mm = 0.01;
  options.max_correction_mm = 1e3;
  const auto whole = nc::RewriteText(program, *leaning, options, &report);
  MUST(!reports::ToJson(nc::ReportOf(report)).empty());
  const auto pieces = InPieces(program, 1 + program.size() % 7, *leaning, options);
  MUST(whole.ok() == pieces.ok() && (!whole.ok() || *whole == *pieces));
  if (!whole.ok()) return;
  MUST(std::count(whole->begin(), whole->end(), '\n') >= std::count(program.begin(), program.end(), '\n'));
  MUST(whole->find("-0.0000 ") == std::string::npos || program.find("-0.0000") != std::string::npos);
  const bool is_marked = whole->find("AXISCAL COMPENSATED") != std::string::npos;
  MUST(is_marked || *whole == program);
  if (report.blocks_corrected > 0) MUST(!nc::RewriteText(*whole, *leaning, options, &report).ok());
  nc::VerifyOptions verify;
  verify.tool_tip_mm = {0, 0, kToolMm};
  verify.reading = options;
  const auto verified = nc::VerifyText(program, *whole, Machine(), Errors(), verify);
  if (!verified.ok() || (variant & 3) != 0 || report.blocks_passed > 0) return;
  // What was written is right where both programs could be followed: within the words' rounding.
  MUST(verified->end_after.max_mm < 0.001);
}

}  // namespace

namespace fuzz {
void Look(const std::string& bytes) { RunOne(bytes); }
}  // namespace fuzz

}  // namespace axiscal
