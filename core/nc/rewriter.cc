#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

#include "core/base/demand.h"
#include "core/base/units.h"
#include "core/compensate/compensator.h"
#include "core/nc/block_writer.h"
#include "core/nc/interpreter.h"
#include "core/nc/line_splitter.h"
#include "core/nc/mark.h"
#include "core/nc/move_corrector.h"
#include "core/nc/rewrite.h"

namespace axiscal::nc {
namespace {

using compensate::Compensator;

constexpr size_t kOutBytes = 1u << 16;
constexpr size_t kShownBytes = 120;  // of a block in a report
constexpr size_t kMaxNotes = 100;

}  // namespace

struct Rewriter::Impl {
  // The interpreter refers to `*options_in`.
  Impl(const Compensator& compensator_in, std::unique_ptr<const RewriteOptions> options_in, ByteSink sink_in,
       Interpreter interpreter_in)
      : compensator(compensator_in),
        owned_options(std::move(options_in)),
        sink(std::move(sink_in)),
        interpreter(std::move(interpreter_in)),
        writer(compensator.machine(), options, interpreter),
        corrector(compensator, options) {
    report.calibration = options.calibration;
    report.is_null_correction = compensator.is_null();
    report.has_source_crc32c = options.source_crc32c.has_value();
    report.source_crc32c = options.source_crc32c.value_or(0);
    report.notes = compensator.not_carried();
    for (std::string& note : report.notes) note = "not carried: " + note;
    for (const int axis : compensator.linear_axes()) report.axes.push_back({compensator.machine().axes[axis].name, {}});
    unknown_reported.fill(-1);
    out.reserve(2 * kOutBytes);
  }

  const Compensator& compensator;
  const std::unique_ptr<const RewriteOptions> owned_options;
  const RewriteOptions& options = *owned_options;
  const ByteSink sink;
  Interpreter interpreter;
  BlockWriter writer;
  MoveCorrector corrector;
  RewriteReport report;
  LineSplitter splitter;
  Block block;
  Step step;
  Piece piece;
  std::string out;
  absl::Status status;
  std::array<int64_t, machine::kMaxAxes> unknown_reported;  // line since which an axis' unknown position was reported
  bool is_mark_written = false;
  bool is_finished = false;

  bool is_refused() const { return report.blocks_refused > 0; }

  void Line(const char* text, size_t size, bool is_overlong) {
    if (!status.ok()) return;
    if (interpreter.line() == 0 && size >= 3 && std::memcmp(text, "\xEF\xBB\xBF", 3) == 0) {
      if (!report.is_null_correction) out.append(text, 3);  // a byte-order mark stays in front of ours
      text += 3;
      size -= 3;
    }
    const size_t text_size = TextSize(text, size);
    if (is_overlong) {
      block.word_count = 0;
      interpreter.ReadOverlong(&step);
    } else {
      interpreter.Read(text, text_size, &block, &step);
    }
    report.blocks_read += step.has_words;
    if (!step.note.empty()) Note(step.note);
    if (block.is_marked && !is_overlong) {
      if (!report.is_null_correction) {
        status = absl::InvalidArgumentError(
            absl::StrCat("line ", interpreter.line(), ": '", Shown(text, text_size),
                         "': this program was compensated before; rewrite its source instead"));
        return;
      }
      Note(absl::StrCat("line ", interpreter.line(), ": this program was compensated before"));
    }
    if (report.is_null_correction) return Observe(text, text_size);
    if (step.has_other_words && !is_mark_written) WriteMark(text, size, text_size);
    if (step.is_tool_change && report.blocks_corrected > 0) {
      Note(absl::StrCat("line ", interpreter.line(),
                        ": tool change; all moves are corrected for the one tool point stated"));
    }
    const size_t before = out.size();
    if (step.kind == StepKind::kMove) {
      Move(text, size, text_size);
    } else if (step.kind == StepKind::kUnsupported) {
      NotCorrected(text, text_size, step.reason, step.is_consequence, false);
      writer.ForgetAll();
    }
    if (step.kind == StepKind::kNone || (out.size() == before && !is_refused())) out.append(text, size);
    if (step.is_tool_change) writer.ForgetAll();
    if (out.size() >= kOutBytes) Flush();
  }

  void Rest(const char* text, size_t size) {
    if (!status.ok() || report.is_null_correction) return;
    out.append(text, size);
    if (out.size() >= kOutBytes) Flush();
  }

  void Flush() {
    if (!is_refused() && status.ok() && !out.empty()) status = sink(out.data(), out.size());
    out.clear();
  }

  // A null correction: the bytes are out already, only the report is kept.
  void Observe(const char* text, size_t size) {
    if (step.kind == StepKind::kUnsupported) {
      ++report.blocks_passed;
      if (!step.is_consequence) AddFinding(text, size, step.reason, &report.passed);
    } else if (step.kind == StepKind::kMove) {
      ++report.blocks_passed;
    }
  }

  static std::string Shown(const char* text, size_t size) { return std::string(text, std::min(size, kShownBytes)); }

  void AddFinding(const char* text, size_t size, const std::string& reason, std::vector<Finding>* findings) {
    if (findings->size() >= kMaxFindings) return;
    findings->push_back({interpreter.line(), Shown(text, size), reason});
  }

  void Note(const std::string& note) {
    if (report.notes.size() < kMaxNotes) report.notes.push_back(note);
  }

  void NotCorrected(const char* text, size_t size, const std::string& reason, bool is_consequence, bool always_refuse) {
    const bool refuses = always_refuse || options.on_unsupported == OnUnsupported::kRefuse;
    ++(refuses ? report.blocks_refused : report.blocks_passed);
    if (refuses) out.clear();
    if (!is_consequence) AddFinding(text, size, reason, refuses ? &report.refused : &report.passed);
  }

  void WriteMark(const char* text, size_t size, size_t text_size) {
    is_mark_written = true;
    out.append(MarkComment(interpreter.dialect(), options.calibration, *options.source_crc32c));
    if (text_size == size) {
      out.push_back('\n');  // the only line of a program without line ends
    } else {
      out.append(text + text_size, size - text_size);
    }
  }

  // "position of Z is unknown: never programmed", or "" when all are known. `is_consequence`: reported before.
  std::string UnknownPosition(bool* is_consequence) {
    const machine::Machine& machine = compensator.machine();
    for (int i = 0; i < machine.axis_count(); ++i) {
      const AxisPosition& position = step.end[i];
      if (position.is_known) continue;
      *is_consequence = position.is_consequence || unknown_reported[i] == position.unknown_since_line;
      unknown_reported[i] = position.unknown_since_line;
      return absl::StrCat("the position of ", machine.axes[i].name, " is unknown: ",
                          position.unknown_since_line == 0
                              ? "never programmed, and no initial position is stated"
                              : absl::StrCat("not programmed since line ", position.unknown_since_line));
    }
    const int axis = writer.FirstUnknown(step);
    if (axis < 0) return "";
    *is_consequence = false;
    return absl::StrCat("G91 from a position of ", machine.axes[axis].name,
                        " that the controller may not have reached");
  }

  void Move(const char* text, size_t size, size_t text_size) {
    bool is_consequence = false;
    const std::string unknown = UnknownPosition(&is_consequence);
    if (!unknown.empty()) {
      NotCorrected(text, text_size, unknown, is_consequence, false);
      writer.Pass(step);
      return;
    }
    const absl::Status corrected = corrector.CorrectEnd(step, &piece);
    if (!corrected.ok()) {
      NotCorrected(text, text_size, std::string(corrected.message()), false, true);
      writer.Pass(step);
      return;
    }
    ++report.blocks_corrected;
    const Commanded before = step.may_be_skipped ? writer.commanded() : Commanded();
    const double departure_mm = MoveDeparture();
    if (departure_mm > options.tolerance_mm) {
      WriteSplit(text, size, text_size, departure_mm);
    } else {
      report.max_departure_mm = std::max(report.max_departure_mm, departure_mm);
      writer.WriteBlock(text, size, block, step, piece.targets, 1.0, &out);
      Account(text, text_size, piece);
    }
    if (step.may_be_skipped) writer.ForgetChanges(before);
    if (is_refused()) out.clear();
  }

  // 0 for a rapid, whose path no controller states, and for a move from an unknown position.
  double MoveDeparture() {
    if (step.is_rapid) return 0.0;
    const machine::Machine& machine = compensator.machine();
    for (int i = 0; i < machine.axis_count(); ++i) {
      if (!step.start[i].is_known) return 0.0;
    }
    const absl::StatusOr<double> departure_mm = corrector.Departure(step);
    return departure_mm.ok() ? *departure_mm : std::numeric_limits<double>::infinity();
  }

  void WriteSplit(const char* text, size_t size, size_t text_size, double departure_mm) {
    const machine::Machine& machine = compensator.machine();
    if (std::string reason = WhyNotSplit(); !reason.empty()) {
      reason = absl::StrFormat("the correction departs from linear by %.2f um and the move cannot be split: %s",
                               departure_mm * base::kUmPerMm, reason);
      return NotCorrected(text, text_size, reason, false, true);
    }
    AxisTicks grain{};
    for (int i = 0; i < machine.axis_count(); ++i) {
      grain[i] = GrainTicks(interpreter.ticks_per_unit(i), writer.DecimalsOf(block, step, i));
    }
    const absl::StatusOr<std::vector<Piece>> pieces = corrector.Split(step, grain);
    if (!pieces.ok()) return NotCorrected(text, text_size, std::string(pieces.status().message()), false, true);
    report.max_departure_mm = std::max(report.max_departure_mm, options.tolerance_mm);
    report.blocks_split += pieces->size() > 1;
    report.blocks_inserted += static_cast<int64_t>(pieces->size()) - 1;
    const std::string line_end = text_size == size ? "\n" : std::string(text + text_size, size - text_size);
    const bool is_packed = BlockWriter::IsPacked(text, block);
    double from = 0.0;
    for (const Piece& next : *pieces) {
      const double fraction = next.end_fraction - from;
      if (from == 0.0) {
        writer.WriteBlock(text, size, block, step, next.targets, fraction, &out);
        if (text_size == size && pieces->size() > 1) out.append(line_end);
      } else {
        out.append(SkipPrefix(text));
        writer.WritePiece(block, step, next.targets, fraction, is_packed, line_end, &out);
      }
      from = next.end_fraction;
      Account(text, text_size, next);
      if (out.size() >= kOutBytes) Flush();
    }
  }

  // "/" or "/2" of a block that may be skipped: its pieces are skipped with it.
  std::string SkipPrefix(const char* text) const {
    if (!block.is_deletable) return "";
    const char* const slash = std::strchr(text, '/');
    return std::string(slash, slash[1] >= '0' && slash[1] <= '9' ? 2 : 1);
  }

  // A code that acts after the move would act after its first piece; F words of G93 must be there to be scaled.
  std::string WhyNotSplit() const {
    constexpr double kMaxFeed = 1e9;
    if (step.ends_block || step.is_tool_change) return "its block has a code that acts after the move";
    if (interpreter.modal().feed_mode != FeedMode::kInverseTime) return "";
    for (const Word& word : block) {
      if (word.letter == 'F') return ValueOf(word.number) < kMaxFeed ? "" : "its feed is out of range";
    }
    return "G93 without an F word";
  }

  // Limits and statistics of what was written for one piece.
  void Account(const char* text, size_t text_size, const Piece& written) {
    const machine::Machine& machine = compensator.machine();
    const std::vector<int>& axes = compensator.linear_axes();
    Eigen::Vector3d after_mm = Eigen::Vector3d::Zero();
    for (size_t k = 0; k < axes.size(); ++k) {
      const int axis = axes[k];
      const double correction_mm = static_cast<double>(written.targets[axis] - written.nominal[axis]) / kTicksPerUnit;
      report.axes[k].correction.Add(correction_mm);
      if (std::abs(correction_mm) > options.max_correction_mm) {
        NotCorrected(text, text_size,
                     absl::StrFormat("correction of %s = %.1f um, the limit is %.1f um", machine.axes[axis].name,
                                     correction_mm * base::kUmPerMm, options.max_correction_mm * base::kUmPerMm),
                     has_exceeded_limit, true);
        has_exceeded_limit = true;
      }
      const Ticks commanded = writer.commanded().ticks[axis];
      CheckTravel(text, text_size, axis, static_cast<double>(commanded) / kTicksPerUnit);
      const double rounding_mm = static_cast<double>(commanded - written.targets[axis]) / kTicksPerUnit;
      after_mm += written.correction.tip_per_mm[k] * rounding_mm;
    }
    report.error_before.Add(written.correction.before_mm);
    report.error_after.Add(after_mm.norm() + written.correction.after_mm);
    report.max_tilt_left_rad = std::max(report.max_tilt_left_rad, written.correction.tilt_left_rad);
  }
  bool has_exceeded_limit = false;  // listed once, counted on

  void CheckTravel(const char* text, size_t text_size, int index, double commanded_mm) {
    const machine::Axis& axis = compensator.machine().axes[index];
    const bool is_below = axis.min_position && commanded_mm < *axis.min_position;
    const bool is_above = axis.max_position && commanded_mm > *axis.max_position;
    if (!is_below && !is_above) return;
    NotCorrected(text, text_size,
                 absl::StrFormat("%s = %.4f mm with its correction, beyond the travel limit of %.4f mm", axis.name,
                                 commanded_mm, is_below ? *axis.min_position : *axis.max_position),
                 false, true);
  }

  absl::Status Refusal() const {
    const std::string count =
        absl::StrCat(report.blocks_refused, report.blocks_refused == 1 ? " block" : " blocks", " refused");
    if (report.refused.empty()) return absl::FailedPreconditionError(count);
    const Finding& first = report.refused.front();
    return absl::FailedPreconditionError(
        absl::StrCat(count, "; line ", first.line, ": '", first.block, "': ", first.reason));
  }
};

absl::StatusOr<Rewriter> Rewriter::Create(const Compensator& compensator, const RewriteOptions& options,
                                          ByteSink sink) {
  RETURN_IF_ERROR(Validate(options));
  if (!compensator.is_null() && !options.source_crc32c) {
    return absl::InvalidArgumentError("source_crc32c must be given: the output's mark names its source");
  }
  auto owned_options = std::make_unique<const RewriteOptions>(options);
  ASSIGN_OR_RETURN(Interpreter interpreter, Interpreter::Create(compensator.machine(), *owned_options));
  return Rewriter(
      std::make_unique<Impl>(compensator, std::move(owned_options), std::move(sink), std::move(interpreter)));
}

Rewriter::Rewriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Rewriter::Rewriter(Rewriter&&) noexcept = default;
Rewriter::~Rewriter() = default;

absl::Status Rewriter::Feed(const char* bytes, size_t size) {
  DEMAND(!impl_->is_finished);
  if (!impl_->status.ok()) return impl_->status;
  if (impl_->report.is_null_correction) impl_->status = impl_->sink(bytes, size);
  impl_->splitter.Feed(
      bytes, size,
      [this](const char* text, size_t length, bool is_overlong) { impl_->Line(text, length, is_overlong); },
      [this](const char* text, size_t length) { impl_->Rest(text, length); });
  return impl_->status;
}

absl::Status Rewriter::Finish() {
  if (impl_->is_finished) return impl_->status;
  impl_->is_finished = true;
  impl_->splitter.Finish(
      [this](const char* text, size_t length, bool is_overlong) { impl_->Line(text, length, is_overlong); });
  impl_->Flush();
  if (impl_->status.ok() && impl_->is_refused()) impl_->status = impl_->Refusal();
  return impl_->status;
}

const RewriteReport& Rewriter::report() const { return impl_->report; }

}  // namespace axiscal::nc
