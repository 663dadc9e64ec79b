// One run of the rewriter: what it holds between the lines of a program. Private to rewriter.cc (one line after the
// other) and rewriter_split.cc (moves in pieces).
#ifndef AXISCAL_CORE_NC_REWRITER_IMPL_H_
#define AXISCAL_CORE_NC_REWRITER_IMPL_H_

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/compensate/compensator.h"
#include "core/nc/block_writer.h"
#include "core/nc/calls.h"
#include "core/nc/corners.h"
#include "core/nc/cutter_contour.h"
#include "core/nc/interpreter.h"
#include "core/nc/job_report.h"
#include "core/nc/line_splitter.h"
#include "core/nc/move_corrector.h"
#include "core/nc/out_buffer.h"
#include "core/nc/preamble.h"
#include "core/nc/rewrite.h"

namespace axiscal::nc {

inline constexpr size_t kOutBytes = 1u << 16;

struct Rewriter::Impl : CornerHost {
  // A tool of a stated length: its tool point stands elsewhere.
  struct Tool {
    int number;
    double length_mm;
    compensate::Compensator compensator;
  };

  // The interpreter refers to `*options_in`.
  Impl(const compensate::Compensator& compensator_in, std::vector<Tool> tools_in,
       std::unique_ptr<const RewriteOptions> options_in, ByteSink sink_in, Interpreter interpreter_in)
      : compensator(compensator_in),
        tools(std::move(tools_in)),
        owned_options(std::move(options_in)),
        sink(std::move(sink_in)),
        interpreter(std::move(interpreter_in)),
        writer(compensator.machine(), options, interpreter),
        job(compensator, options),
        base_corrector(compensator, options, 0.0) {
    for (const Tool& tool : tools) tool_correctors.emplace_back(tool.compensator, options, tool.length_mm);
    unknown_reported.fill(-1);
    all_axes = static_cast<uint16_t>((1u << compensator.machine().axis_count()) - 1);
    for (int i = 0; i < compensator.machine().axis_count(); ++i) {
      if (compensator.machine().axes[i].kind == machine::AxisKind::kRotary) rotary_axes.push_back(i);
    }
  }

  const compensate::Compensator& compensator;
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
  Preamble preamble;
  Block block;
  BlockText now;
  Step step;
  Piece piece;
  WordGrain block_grain;  // with orientation
  OutBuffer out;
  absl::Status status;
  std::array<int64_t, machine::kMaxAxes> unknown_reported;  // line since which an axis' unknown position was reported
  uint16_t all_axes = 0;
  std::vector<int> rotary_axes;
  uint16_t named_rotary = 0;  // rotary axes of which a corrected block has a word, or that turn otherwise
  uint16_t half_turns = 0;    // axes of which a half turn was noted
  // The mark goes in front of the first block of words, once a word has changed; in front of that word's block where
  // the first one is on its way already.
  bool is_mark_written = false;
  bool has_mark_place = false;
  size_t mark_place = 0;  // in `out`, while nothing of it was sent since the program's begin
  bool is_flushed = false;
  std::string mark_line_end;
  bool is_last_split = false;  // the last move was written in pieces
  bool is_finished = false;
  bool has_noted_tool_point = false, has_noted_kept = false;
  bool has_changed_frame = false;  // the block that is read
  // Cutter compensation (G41, G42): its moves to the contour and away from it may stand in later blocks than its codes.
  enum class ContourState { kOff, kStarting, kOn, kEnding };
  ContourState contour_state = ContourState::kOff;
  // What the move that is read is to the contour: kHeld has no part in X and Y, and must not get one.
  enum class ContourRole { kNone, kHeld, kEntry, kPiece, kExit };
  ContourRole contour_role = ContourRole::kNone;
  CutterContour contour;
  int64_t programs_begun = 0;  // as the writer knows
  bool has_ended = false;      // the program that is read now
  Corners corners;
  // Why the corner at an end of the move that is read stays the control's, or the pattern of holes is not followed.
  std::string line_problem;
  int64_t refused_corner_line = -1;  // the last line that is listed for its corner

  // From the first line on that calls a subprogram the lines wait for the end of the text, where they are run in the
  // order of the control.
  bool is_waiting = false, is_running = false, wants_mark = false;
  std::vector<std::string> waiting;
  int64_t first_waiting = 1;  // its line number

  bool is_null() const { return job.report().is_null_correction; }

  const MoveCorrector& corrector() const {
    const int number = interpreter.coordinates().active_length();
    for (size_t i = 0; number > 0 && i < tools.size(); ++i) {
      if (tools[i].number == number) return tool_correctors[i];
    }
    return base_corrector;
  }

  void Line(const char* text, size_t size, bool is_overlong);
  // The line that `now` is.
  void ReadLine(bool is_overlong, bool is_resolved);
  // The same, or the blocks that it stands for (hole_patterns.h).
  void ReadOrExpand(bool is_overlong, bool is_resolved);
  // The line that was read is none of the program's, behind which `corrected` blocks were.
  void CountInserted(int64_t corrected);
  void Read(const CornerLine& line) override;
  const Interpreter& reader() const override { return interpreter; }
  bool IsOnContour() const override { return contour_state == ContourState::kOn; }
  bool Knows(const Step& move) const override { return move.start.known == all_axes; }
  bool MayStay(const Step& from, const Step& to, double reach_mm) override;
  // The words of a line that is no line of the program: their decimals beyond the resolution are none of the program's.
  void ShortenWords();
  // Why a correction must not move the axis out of the plane beside the corner, or "".
  std::string WhyNoCorner() const;
  // The axes whose position the move needs, and that nothing in front of it states, are asked for.
  void AskStart();
  // Rotary axes that no block names, for the report.
  void NoteRotaryStood();
  // What waits: each run of a subprogram is written for itself, and texts that agree are one.
  void RunCalls();
  struct Run;
  struct Version;
  class Written;
  // A line of a listing in front of the first '%'.
  void Skip(const char* text, size_t size);
  // Once: which axes tool changes leave where they stand.
  void NoteKept();
  void Take(const char* text, size_t size, bool is_overlong) {
    preamble.Take(
        interpreter.dialect(), text, size, is_overlong,
        [this](const char* line, size_t length, bool is_long) { Line(line, length, is_long); },
        [this](const char* line, size_t length) { Skip(line, length); });
  }
  void Rest(const char* text, size_t size);
  void Flush();
  // A null correction: the bytes are out already, only the report is kept.
  void Observe();
  void NotCorrected(const std::string& reason, bool is_consequence);
  // The block stays as it is.
  void Copy();
  bool passes() const { return options.on_unsupported == OnUnsupported::kPass; }
  // Whether what follows the block that is read must find the control where the program says: it is passed, or leads to
  // what is not followed.
  bool MustReturn() const;
  // In front of such a block. Refused where that cannot be.
  void Return();
  std::string LineEnd() const {
    return now.text_size == now.size ? "\n" : std::string(now.text + now.text_size, now.size - now.text_size);
  }
  void KeepMarkPlace();
  // Whether what was written from `begin` on is the block's own bytes.
  bool IsWrittenAsItWas(size_t begin) const;
  // In front of what was written from `block_begin` on, or farther up.
  void WriteMark(size_t block_begin);
  // "position of Z is unknown: never programmed", or "" when all are known. `is_consequence`: reported before.
  std::string UnknownPosition(bool* is_consequence);
  void MoveFromUnknown(const std::string& unknown, bool is_consequence);
  void Move();
  void Drill();
  // Fills contour_role. Why the move cannot be one of a contour, or "".
  std::string TakeContour();
  // A move without a part in X and Y: it moves there with no correction either, since the control would offset that.
  void WriteHeld();
  // Behind each piece of a move of a contour, which began at `from` (commanded) and at the fraction `first`.
  void FollowContour(const AxisTicks& from, double first, const Piece& written);
  // What is left along it: across the contour, and along Z, mm.
  absl::StatusOr<double> LeftAlong(const ContourPiece& nominal, const ContourPiece& as_written, const AxisTicks& from,
                                   double first, const Piece& written);
  double RoundingMm() const;  // of the words of linear axes, all together
  // The tool point's error where the control is told `at` in place of the piece's targets, mm.
  double LeftAt(const Piece& wanted, const Commanded& at) const;
  // A control that takes rotary axes the shorter way round decides at half a turn, which a correction may cross. Noted
  // once for each axis.
  void NoteHalfTurns();
  // Why the control would take F for another speed with the correction: it moves linear axes where the program turns
  // rotary axes alone. "": it would not.
  std::string WhyNoFeed(double departure_mm) const;
  // Why a move under tool centre point control cannot be corrected, or "".
  std::string WhyNoToolPoint() const;
  // With orientation: why the control may turn a rotary axis the long way round to where a corrected word sends it. ""
  // where it does not. `last`: the piece of the same move that is written in front of it, nullptr for the first.
  std::string WhyNoTurn(const Piece& next, const Piece* last) const;
  // The same of a block that stays as it is, from where the control stands.
  std::string WhyNoCopy() const;
  // How the control takes the block's word of the axis, or one that is inserted; kNone: by the difference of the
  // numbers, as the word says itself, or it is no rotary axis.
  machine::RollOver WayOfWord(int axis) const;
  // Whether it turns the axis where the program does not, or back where the program goes on. False where it is not
  // known how the program turns it.
  bool TurnsOtherwise(int axis, Ticks from, Ticks to) const;
  // What WhyNoTurn gives a reason for.
  void LeaveUnturned(const std::string& reason);
  // Refuses a block that was written from `begin` on, when it is longer than the control reads.
  void CheckLength(size_t begin);
  // 0 for a rapid, whose path no controller states, and for a move from an unknown position.
  double MoveDeparture();
  // Whether an axis turned back and its lost motion must be taken up before the move.
  bool TakesUpReversal();
  absl::StatusOr<std::vector<Piece>> Pieces();
  // False: the block was left as it is.
  bool WriteSplit(double departure_mm);
  // "/" or "/2" of a block that may be skipped: its pieces are skipped with it.
  std::string SkipPrefix() const;
  // A code that acts after the move would act after its first piece; F words of G93 must be there to be scaled.
  std::string WhyNotSplit() const;
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_REWRITER_IMPL_H_
