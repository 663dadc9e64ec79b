#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>

#include "core/base/demand.h"
#include "core/base/units.h"
#include "core/compensate/compensator.h"
#include "core/nc/block_writer.h"
#include "core/nc/interpreter.h"
#include "core/nc/job_report.h"
#include "core/nc/line_splitter.h"
#include "core/nc/mark.h"
#include "core/nc/move_corrector.h"
#include "core/nc/out_buffer.h"
#include "core/nc/rewrite.h"

namespace axiscal::nc {
namespace {

using compensate::Compensator;

constexpr size_t kOutBytes = 1u << 16;

bool IsUtf16(const char* text, size_t size) {
  return size >= 2 && (std::memcmp(text, "\xFF\xFE", 2) == 0 || std::memcmp(text, "\xFE\xFF", 2) == 0);
}

absl::Status RequireRotaryAxis(const machine::Machine& machine) {
  for (const machine::Axis& axis : machine.axes) {
    if (axis.kind == machine::AxisKind::kRotary) return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("orientation: machine '", machine.id, "' has no rotary axis that could turn the tool"));
}

}  // namespace

struct Rewriter::Impl {
  // A tool of a stated length: its tool point stands elsewhere.
  struct Tool {
    int number;
    Compensator compensator;
  };

  // The interpreter refers to `*options_in`.
  Impl(const Compensator& compensator_in, std::vector<Tool> tools_in, std::unique_ptr<const RewriteOptions> options_in,
       ByteSink sink_in, Interpreter interpreter_in)
      : compensator(compensator_in),
        tools(std::move(tools_in)),
        owned_options(std::move(options_in)),
        sink(std::move(sink_in)),
        interpreter(std::move(interpreter_in)),
        writer(compensator.machine(), options, interpreter),
        job(compensator, options),
        base_corrector(compensator, options) {
    for (const Tool& tool : tools) tool_correctors.emplace_back(tool.compensator, options);
    unknown_reported.fill(-1);
    all_axes = static_cast<uint16_t>((1u << compensator.machine().axis_count()) - 1);
  }

  const Compensator& compensator;
  const std::vector<Tool> tools;
  const std::unique_ptr<const RewriteOptions> owned_options;
  const RewriteOptions& options = *owned_options;
  const ByteSink sink;
  Interpreter interpreter;
  BlockWriter writer;
  JobReport job;
  const MoveCorrector base_corrector;
  std::vector<MoveCorrector> tool_correctors;  // of `tools`
  LineSplitter splitter;
  Block block;
  BlockText now;
  Step step;
  Piece piece;
  WordGrain block_grain;  // with orientation
  OutBuffer out;
  absl::Status status;
  std::array<int64_t, machine::kMaxAxes> unknown_reported;  // line since which an axis' unknown position was reported
  uint16_t all_axes = 0;
  uint16_t half_turns = 0;  // axes of which a half turn was noted
  bool is_mark_written = false;
  bool is_finished = false;

  bool is_null() const { return job.report().is_null_correction; }

  const MoveCorrector& corrector() const {
    const int number = interpreter.coordinates().active_length();
    for (size_t i = 0; number > 0 && i < tools.size(); ++i) {
      if (tools[i].number == number) return tool_correctors[i];
    }
    return base_corrector;
  }

  void Line(const char* text, size_t size, bool is_overlong) {
    if (!status.ok()) return;
    if (interpreter.line() == 0 && size >= 3 && std::memcmp(text, "\xEF\xBB\xBF", 3) == 0) {
      if (!is_null()) out.append(text, 3);  // a byte-order mark stays in front of ours
      text += 3;
      size -= 3;
    }
    if (interpreter.line() == 0 && IsUtf16(text, size) && !is_null()) {
      status = absl::InvalidArgumentError("line 1: the program is in UTF-16, expected one byte per character");
      return;
    }
    now = {text, size, TextSize(text, size), interpreter.line() + 1};
    if (is_overlong) {
      block.word_count = 0;
      interpreter.ReadOverlong(&step);
    } else {
      interpreter.Read(text, now.text_size, &block, &step);
    }
    job.report().blocks_read += step.has_words;
    if (!step.note.empty() && job.report().notes.size() < 100) job.report().notes.push_back(step.note);
    if (block.is_marked && !is_overlong) {
      if (!is_null()) {
        status = absl::InvalidArgumentError(
            absl::StrCat("line ", now.line, ": '", Shown(now),
                         "': this program was compensated before; rewrite its source instead"));
        return;
      }
      job.Note(now, "this program was compensated before");
    }
    if (is_null()) return Observe();
    if (step.has_other_words && !is_mark_written) WriteMark();
    if (step.is_tool_change && job.report().blocks_corrected > 0 && tools.empty())
      job.Note(now, "tool change; all moves are corrected for the one tool point stated");
    if (step.kind == StepKind::kMove) {
      Move();
    } else {
      if (step.kind == StepKind::kUnsupported) NotCorrected(step.reason, step.is_consequence);
      if (step.kind == StepKind::kUntouched) job.Passed(now, step.reason + ": never touched", false);
      Copy();
    }
    if (step.is_tool_change) writer.ForgetAll();
    if (job.is_refused()) out.clear();
    if (out.size() >= kOutBytes) Flush();
    if (job.is_refused() && options.on_unsupported == OnUnsupported::kStop) status = job.Refusal();
  }

  void Rest(const char* text, size_t size) {
    if (!status.ok() || is_null()) return;
    out.append(text, size);
    if (out.size() >= kOutBytes) Flush();
  }

  void Flush() {
    if (!job.is_refused() && status.ok() && !out.empty()) status = sink(out.data(), out.size());
    out.clear();
  }

  // A null correction: the bytes are out already, only the report is kept.
  void Observe() {
    if (step.kind == StepKind::kNone) return;
    job.Passed(now, step.reason, step.is_consequence || step.kind == StepKind::kMove);
  }

  void NotCorrected(const std::string& reason, bool is_consequence) {
    if (options.on_unsupported == OnUnsupported::kPass) return job.Passed(now, reason, is_consequence);
    job.Refused(now, reason, is_consequence);
  }

  // The block stays as it is.
  void Copy() {
    writer.CopyBlock(now.text, now.size, block, step, &out);
    if (step.kind != StepKind::kNone || step.preset != PresetChange::kNone) {
      writer.Pass(step);
      job.BreakPath();
    }
  }

  void WriteMark() {
    is_mark_written = true;
    out.append(MarkComment(interpreter.dialect(), options.calibration, *options.source_crc32c));
    if (now.text_size == now.size) {
      out.push_back('\n');  // the only line of a program without line ends
    } else {
      out.append(now.text + now.text_size, now.size - now.text_size);
    }
  }

  // "position of Z is unknown: never programmed", or "" when all are known. `is_consequence`: reported before.
  std::string UnknownPosition(bool* is_consequence) {
    const machine::Machine& machine = compensator.machine();
    for (int i = 0; step.end.known != all_axes && i < machine.axis_count(); ++i) {
      if (step.end.is_known(i)) continue;
      const int64_t since = interpreter.unknown_since(i);
      *is_consequence = interpreter.is_unknown_reported(i) || unknown_reported[i] == since;
      unknown_reported[i] = since;
      return absl::StrCat("the position of ", machine.axes[i].name, " is unknown: ",
                          since == 0 ? "never programmed, and no initial position is stated"
                                     : absl::StrCat("not programmed since line ", since));
    }
    const int axis = writer.FirstUnknown(block, step);
    if (axis < 0) return "";
    *is_consequence = false;
    return absl::StrCat(step.is_arc ? "an arc" : "G91", " from a position of ", machine.axes[axis].name,
                        " that the controller may not have reached");
  }

  void Move() {
    bool is_consequence = false;
    const std::string unknown = UnknownPosition(&is_consequence);
    if (!unknown.empty()) {
      // A rapid does not cut: behind G28 or a tool change it brings back what is known of the axes.
      if (step.is_rapid) {
        job.Passed(now, "rapid move left as it is, " + unknown, is_consequence);
      } else {
        NotCorrected(unknown, is_consequence);
      }
      return Copy();
    }
    if (options.orientation) block_grain = writer.GrainOf(block, step);
    const absl::Status corrected = corrector().CorrectEnd(step, block_grain, &piece);
    if (!corrected.ok()) {
      job.Refused(now, std::string(corrected.message()), false);
      return Copy();
    }
    ++job.report().blocks_corrected;
    if (options.orientation) NoteHalfTurns();
    std::optional<Commanded> before;
    if (step.may_be_skipped) before = writer.commanded();
    if (step.is_arc) {
      WriteSplit(0.0);
    } else if (const double departure_mm = MoveDeparture(); departure_mm > options.tolerance_mm) {
      WriteSplit(departure_mm);
    } else {
      writer.WriteBlock(now.text, now.size, block, step, piece, 1.0, &out);
      job.Account(now, piece, writer.commanded(), departure_mm);
      if (piece.turned.limit != compensate::DirectionLimit::kNone) job.Tilted(now, piece.turned);
    }
    if (before) writer.ForgetChanges(*before);
  }

  // A control that takes rotary axes the shorter way round decides at half a turn, which a correction may cross. Noted
  // once for each axis.
  void NoteHalfTurns() {
    const machine::Machine& machine = compensator.machine();
    for (int i = 0; i < machine.axis_count(); ++i) {
      const auto bit = static_cast<uint16_t>(1u << i);
      if (machine.axes[i].kind != machine::AxisKind::kRotary || !step.start.is_known(i) || (half_turns & bit)) continue;
      const double travel_deg = std::abs(static_cast<double>(step.end.ticks[i] - step.start.ticks[i])) / kTicksPerUnit;
      const double apart_deg = std::abs(std::fmod(travel_deg, 360.0) - 180.0);
      if (apart_deg > 2.0 * options.max_rotary_correction_rad * base::kDegPerRad) continue;
      half_turns |= bit;
      job.Note(now, absl::StrCat("a move of ", machine.axes[i].name,
                                 " by half a turn: a control that takes the shorter way may now take the other one"));
    }
  }

  // 0 for a rapid, whose path no controller states, and for a move from an unknown position.
  double MoveDeparture() {
    if (step.is_rapid || step.start.known != all_axes) return 0.0;
    if (TakesUpReversal()) return std::numeric_limits<double>::infinity();
    const absl::StatusOr<double> departure_mm = corrector().Departure(step, piece);
    return departure_mm.ok() ? *departure_mm : std::numeric_limits<double>::infinity();
  }

  // Whether an axis turned back and its lost motion must be taken up before the move.
  bool TakesUpReversal() {
    if (!corrector().uses_sense() || writer.commanded().known != all_axes) return false;
    Piece start;
    return corrector().CorrectStart(step, WordGrain(), &start).ok() &&
           corrector().Apart(start, writer.commanded().ticks) > options.tolerance_mm;
  }

  absl::StatusOr<std::vector<Piece>> Pieces() {
    const WordGrain grain = writer.GrainOf(block, step);
    if (step.is_arc) return corrector().SplitArc(step, writer.commanded().ticks, grain);
    std::vector<Piece> pieces;
    if (TakesUpReversal()) {
      pieces.emplace_back();
      RETURN_IF_ERROR(corrector().CorrectStart(step, grain, &pieces.back()));
    }
    ASSIGN_OR_RETURN(const std::vector<Piece> moves, corrector().Split(step, grain));
    pieces.insert(pieces.end(), moves.begin(), moves.end());
    return pieces;
  }

  void WriteSplit(double departure_mm) {
    const absl::StatusOr<std::vector<Piece>> pieces = Pieces();
    if (!pieces.ok()) {
      job.Refused(now, std::string(pieces.status().message()), false);
      return Copy();
    }
    if (std::string reason = pieces->size() > 1 ? WhyNotSplit() : ""; !reason.empty()) {
      const std::string departs =
          std::isfinite(departure_mm) && !step.is_arc
              ? absl::StrFormat("the correction departs from linear by %.2f um", departure_mm * base::kUmPerMm)
              : std::string("the correction bends along the move");
      job.Refused(now, absl::StrCat(departs, " and the move cannot be split: ", reason), false);
      return Copy();
    }
    job.report().blocks_split += pieces->size() > 1;
    job.report().blocks_inserted += static_cast<int64_t>(pieces->size()) - 1;
    const std::string line_end =
        now.text_size == now.size ? "\n" : std::string(now.text + now.text_size, now.size - now.text_size);
    const bool is_packed = BlockWriter::IsPacked(now.text, block);
    double from = 0.0;
    compensate::Turned worst;
    for (const Piece& next : *pieces) {
      if (next.turned.limit != compensate::DirectionLimit::kNone && next.turned.tilt_left_rad > worst.tilt_left_rad)
        worst = next.turned;
      const double fraction = next.end_fraction - from;
      if (&next == pieces->data()) {
        writer.WriteBlock(now.text, now.size, block, step, next, fraction, &out);
        if (now.text_size == now.size && pieces->size() > 1) out.append(line_end);
      } else {
        out.append(SkipPrefix());
        writer.WritePiece(block, step, next, fraction, is_packed, line_end, &out);
      }
      from = next.end_fraction;
      job.Account(now, next, writer.commanded(), std::isfinite(options.tolerance_mm) ? options.tolerance_mm : 0.0);
      if (out.size() >= kOutBytes) Flush();
    }
    if (worst.limit != compensate::DirectionLimit::kNone) job.Tilted(now, worst);
  }

  // "/" or "/2" of a block that may be skipped: its pieces are skipped with it.
  std::string SkipPrefix() const {
    if (!block.is_deletable) return "";
    const char* const slash = std::strchr(now.text, '/');
    // Klartext: the digit is of the block's number.
    const bool has_switch = slash[1] >= '0' && slash[1] <= '9' && !interpreter.dialect().has_bare_keywords;
    return std::string(slash, has_switch ? 2 : 1);
  }

  // A code that acts after the move would act after its first piece; F words of G93 must be there to be scaled.
  std::string WhyNotSplit() const {
    constexpr double kMaxFeed = 1e9;
    if (step.ends_block || step.is_tool_change) return "its block has a code that acts, or may act, after the move";
    if (interpreter.modal().uncertain & kFeedGroup) return "the feed mode is not known";
    if (interpreter.modal().feed_mode != FeedMode::kInverseTime) return "";
    for (const Word& word : block) {
      if (word.letter == 'F') return ValueOf(word.number) < kMaxFeed ? "" : "its feed is out of range";
    }
    return "G93 without an F word";
  }
};

absl::StatusOr<Rewriter> Rewriter::Create(const Compensator& compensator, const RewriteOptions& options,
                                          ByteSink sink) {
  RETURN_IF_ERROR(Validate(options));
  if (!compensator.is_null() && !options.source_crc32c) {
    return absl::InvalidArgumentError("source_crc32c must be given: the output's mark names its source");
  }
  if (options.orientation) RETURN_IF_ERROR(RequireRotaryAxis(compensator.machine()));
  std::vector<Impl::Tool> tools;
  for (const ToolLength& length : options.tool_lengths) {
    ASSIGN_OR_RETURN(Compensator longer, compensator.WithLongerTool(length.length_mm));
    tools.push_back({length.number, std::move(longer)});
  }
  auto owned_options = std::make_unique<const RewriteOptions>(options);
  ASSIGN_OR_RETURN(Interpreter interpreter, Interpreter::Create(compensator.machine(), *owned_options));
  return Rewriter(std::make_unique<Impl>(compensator, std::move(tools), std::move(owned_options), std::move(sink),
                                         std::move(interpreter)));
}

Rewriter::Rewriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Rewriter::Rewriter(Rewriter&&) noexcept = default;
Rewriter::~Rewriter() = default;

absl::Status Rewriter::Feed(const char* bytes, size_t size) {
  DEMAND(!impl_->is_finished);
  if (!impl_->status.ok()) return impl_->status;
  if (impl_->is_null()) impl_->status = impl_->sink(bytes, size);
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
  if (impl_->status.ok() && impl_->job.is_refused()) impl_->status = impl_->job.Refusal();
  return impl_->status;
}

const RewriteReport& Rewriter::report() const { return impl_->job.report(); }

}  // namespace axiscal::nc
