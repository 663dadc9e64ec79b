#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "core/base/demand.h"
#include "core/base/units.h"
#include "core/nc/mark.h"
#include "core/nc/rewriter_impl.h"

namespace axiscal::nc {
namespace {

using compensate::Compensator;

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

void Rewriter::Impl::Line(const char* text, size_t size, bool is_overlong) {
  if (!status.ok()) return;
  if (is_waiting && !is_running) {
    waiting.emplace_back(text, size);
    return;
  }
  const int64_t number = interpreter.line() + 1 + (is_running ? 0 : corners.held_lines());
  if (is_overlong) {
    corners.Release("the block behind it is too long to be one", this);
  } else if (corners.Wants(interpreter.dialect(), text, size)) {
    return corners.Take(number, text, size, this);
  }
  now = {text, size, TextSize(text, size), interpreter.line() + 1};
  ReadOrExpand(is_overlong, false);
  if (!line_problem.empty() && step.kind != StepKind::kNone) line_problem.clear();
}

void Rewriter::Impl::ReadLine(bool is_overlong, bool is_resolved) {
  if (interpreter.line() == 0 && now.size >= 3 && std::memcmp(now.text, "\xEF\xBB\xBF", 3) == 0) {
    if (!is_null()) out.append(now.text, 3);  // a byte-order mark stays in front of ours
    now.text += 3;
    now.size -= 3;
    now.text_size -= std::min<size_t>(now.text_size, 3);
  }
  if (interpreter.line() == 0 && IsUtf16(now.text, now.size) && !is_null()) {
    status = absl::InvalidArgumentError("line 1: the program is in UTF-16, expected one byte per character");
    return;
  }
  if (is_overlong) {
    block.word_count = 0;
    interpreter.ReadOverlong(&step);
  } else {
    interpreter.Read(now.text, now.text_size, &block, &step);
  }
  step.is_resolved = is_resolved;
  if (is_resolved) ShortenWords();
  if (step.begins_structure) {
    is_waiting = true;
    first_waiting = now.line;
    waiting.emplace_back(now.text, now.size);
    return;
  }
  job.report().blocks_read += step.has_words;
  has_changed_frame = false;
  if (!step.note.text.empty() && job.report().notes.size() < 100) job.report().notes.push_back(step.note);
  if (block.is_marked && !is_overlong) {
    if (!is_null()) {
      status = absl::InvalidArgumentError(absl::StrCat(
          "line ", now.line, ": '", Shown(now), "': this program was compensated before; rewrite its source instead"));
      return;
    }
    job.Note(now, "compensated-before", "this program was compensated before");
  }
  if (is_null()) return Observe();
  if (step.jumps_back && job.report().blocks_corrected > 0) {
    job.Refused(now, "it may lead back to blocks that were corrected, and these hold for their order in the text only",
                false);
  }
  if (programs_begun != interpreter.programs_begun()) {
    writer.BeginProgram(has_ended);
    programs_begun = interpreter.programs_begun();
    contour_state = ContourState::kOff;
  }
  has_ended = step.ends_program || (has_ended && !step.has_other_words);
  if (step.has_other_words && !has_mark_place) KeepMarkPlace();
  if (step.is_tool_change && job.report().blocks_corrected > 0 && tools.empty())
    job.Note(now, "tool-change", "tool change; all moves are corrected for the one tool point stated");
  if (step.frame.is_changed && step.kind != StepKind::kUnsupported && !step.moves_away) {
    if (step.frame.to == FrameChange::To::kWords && !has_noted_tool_point)
      job.Note(now, "tool-point-control",
               "tool centre point control: its kinematics are taken as machine.json's nominal chain, words as in the "
               "workpiece's frame with the table at zero");
    has_noted_tool_point |= step.frame.to == FrameChange::To::kWords;
    if (passes() && !interpreter.IsKept(step.frame)) Return();
    writer.ChangeFrame(step.frame);
    has_changed_frame = true;
    job.BreakPath();
  }
  if (step.is_corner && is_last_split)
    job.Refused(now, "the move in front of the corner had to be split, and the control needs it whole", false);
  if (step.kind == StepKind::kUnsupported && !line_problem.empty() && !step.is_consequence)
    absl::StrAppend(&step.reason, ": ", line_problem);
  if (step.kind == StepKind::kMove) {
    is_last_split = false;
    Move();
  } else if (step.kind == StepKind::kHole) {
    is_last_split = false;
    Drill();
  } else {
    if (step.kind == StepKind::kUnsupported) NotCorrected(step.reason, step.is_consequence);
    if (step.kind == StepKind::kUntouched) job.Passed(now, step.reason + ": never touched", false);
    if (MustReturn()) Return();
    Copy();
  }
  if (step.kept_away != 0 && step.is_tool_change) NoteKept();
  if (step.moves_away) writer.ForgetAll(step.kept_away), contour_state = ContourState::kOff;
  if (job.is_refused()) out.clear();
  if (out.size() >= kOutBytes) Flush();
  if (job.is_refused() && options.on_unsupported == OnUnsupported::kStop) status = job.Refusal();
}

void Rewriter::Impl::NoteKept() {
  if (has_noted_kept) return;
  has_noted_kept = true;
  std::string names;
  for (const int axis : rotary_axes) {
    if (step.kept_away >> axis & 1)
      absl::StrAppend(&names, names.empty() ? "" : ", ", compensator.machine().axes[axis].name);
  }
  job.Note(now, "tool-change-keeps",
           absl::StrCat("tool changes are taken to leave ", names, " where they stand, as stated"));
}

void Rewriter::Impl::Skip(const char* text, size_t size) {
  interpreter.SkipLine();
  if (interpreter.line() == 1)
    job.report().notes.push_back(
        RemarkAt(1, "text-before-start", "text in front of the first '%' is left as it is: no control reads it"));
  if (status.ok() && !is_null()) out.append(text, size);
}

void Rewriter::Impl::Rest(const char* text, size_t size) {
  if (is_waiting) {
    waiting.back().append(text, size);
    return;
  }
  if (!status.ok() || is_null()) return;
  out.append(text, size);
  if (out.size() >= kOutBytes) Flush();
}

void Rewriter::Impl::Flush() {
  if (is_running) return;
  if (!job.is_refused() && status.ok() && !out.empty()) status = sink(out.data(), out.size());
  is_flushed |= has_mark_place && !out.empty();
  mark_place = 0;
  out.clear();
}

void Rewriter::Impl::Observe() {
  if (step.kind == StepKind::kNone) return;
  const bool is_followed = step.kind == StepKind::kMove || step.kind == StepKind::kHole;
  job.Passed(now, step.reason, step.is_consequence || is_followed);
}

void Rewriter::Impl::NotCorrected(const std::string& reason, bool is_consequence) {
  if (options.on_unsupported == OnUnsupported::kPass) return job.Passed(now, reason, is_consequence);
  job.Refused(now, reason, is_consequence);
}

bool Rewriter::Impl::MustReturn() const {
  if (!passes()) return false;
  // DEP goes on from the contour, wherever that was led.
  const bool moves_away = step.moves_away && !step.departs;
  if (step.kind == StepKind::kUnsupported || step.kind == StepKind::kHole || moves_away || step.ends_subprogram ||
      step.begins_definition)
    return true;
  if (step.kind == StepKind::kUntouched) return interpreter.positions().known == 0;
  return step.is_arc || (step.sets_pole && !interpreter.pole().is_known);
}

void Rewriter::Impl::Return() {
  if (contour_state != ContourState::kOff) {
    return job.Refused(now,
                       "cutter compensation is active, or its end waits for a move in X or Y: what is not corrected "
                       "there cannot stand beside corrected moves",
                       false);
  }
  const size_t begin = out.size();
  const double way_mm = writer.HasDeparted() && !step.is_tangential ? writer.WayBackMm() : 0.0;
  const std::string problem =
      step.is_tangential ? ""
      : has_changed_frame && writer.HasDeparted()
          ? "the control stands at a corrected position, and the block changes the frame of the words"
          : writer.Return(interpreter.Before(), LineEnd(), &out);
  if (step.is_tangential) writer.LeaveAdrift(now.text, now.text_size, interpreter.Before(), LineEnd(), &out);
  if (!problem.empty()) {
    return job.Refused(now, absl::StrCat("it must begin where the program says, and cannot: ", problem), false);
  }
  if (out.size() != begin) {
    ++job.report().blocks_inserted;
    if (way_mm > 0) {
      const char* const added = out.data() + begin;
      const char* const end = std::find(added, out.data() + out.size(), '\n');
      job.WentBack(now, std::string(added, TextSize(added, static_cast<size_t>(end - added))), way_mm);
    }
    job.BreakPath();
  }
  const machine::Machine& machine = compensator.machine();
  const Modal& modal = interpreter.modal();
  const bool may_be_arc =
      step.is_curve || modal.motion == Meaning::kArc || step.leaves_text || (modal.uncertain & kMotionGroup) != 0;
  for (int i = 0; may_be_arc && i < machine.axis_count(); ++i) {
    if ((writer.adrift() >> i & 1) == 0) continue;
    return job.Refused(now,
                       absl::StrCat("it is, or may lead to, an arc from a corrected position of ", machine.axes[i].name,
                                    " that is not known: a block that may be skipped moves it; state --block-delete"),
                       false);
  }
  if (!writer.LeavesInChords(block, step)) return;
  job.Refused(now,
              "the program leaves this text in G02 or G03 and the control in G01, by a straight block that was "
              "inserted: state G00 or G01 in front of it",
              false);
}

void Rewriter::Impl::Copy() {
  if (const std::string reason = WhyNoCopy(); !reason.empty() && !job.is_refused()) job.Refused(now, reason, false);
  const size_t begin = out.size();
  writer.CopyBlock(now.text, now.size, block, step, &out);
  CheckLength(begin);
  if (step.sets_pole) writer.TakePole(interpreter.pole());
  if (step.defines_cycle) writer.ForgetCycle();
  if (step.kind != StepKind::kNone || step.preset != PresetChange::kNone) {
    writer.Pass(block, step);
    job.BreakPath();
  }
}

bool Rewriter::Impl::IsWrittenAsItWas(size_t begin) const {
  return out.size() - begin == now.size && std::memcmp(out.data() + begin, now.text, now.size) == 0;
}

void Rewriter::Impl::KeepMarkPlace() {
  if (is_running) return;
  has_mark_place = true;
  mark_place = out.size();
  mark_line_end.assign(now.text + now.text_size, now.size - now.text_size);
  if (mark_line_end.empty()) mark_line_end.push_back('\n');  // the only line of a program without line ends
}

void Rewriter::Impl::WriteMark(size_t block_begin) {
  if (is_mark_written || job.is_refused()) return;  // a refused program has no output
  is_mark_written = true;
  if (is_running) {
    wants_mark = true;
    return;
  }
  const std::string mark =
      HeadComments(interpreter.dialect(), compensator, options, *options.source_crc32c, mark_line_end);
  out.insert(is_flushed ? block_begin : mark_place, mark);
}

std::string Rewriter::Impl::UnknownPosition(bool* is_consequence) {
  const machine::Machine& machine = compensator.machine();
  for (int i = 0; step.end.known != all_axes && i < machine.axis_count(); ++i) {
    if (step.end.is_known(i)) continue;
    const int64_t since = interpreter.unknown_since(i);
    *is_consequence = interpreter.is_unknown_reported(i) || unknown_reported[i] == since;
    unknown_reported[i] = since;
    if (interpreter.modal().uncertain & kLengthGroup) return "the tool length is not known";
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

void Rewriter::Impl::MoveFromUnknown(const std::string& unknown, bool is_consequence) {
  if (contour_role == ContourRole::kExit) contour_state = ContourState::kOff;
  if (contour_state != ContourState::kOff) {
    job.Refused(now, unknown + ", while cutter compensation is active", is_consequence);
    return Copy();
  }
  // A rapid does not cut: behind G28 or a tool change it brings back what is known of the axes.
  if (step.is_rapid) {
    job.Passed(now, "rapid move left as it is, " + unknown, is_consequence);
  } else {
    AskStart();
    NotCorrected(unknown, is_consequence);
    if (MustReturn()) Return();
  }
  Copy();
}

void Rewriter::Impl::AskStart() {
  std::vector<int> axes, kept;
  for (int i = 0; i < compensator.machine().axis_count(); ++i) {
    if (step.end.is_known(i)) continue;
    if (interpreter.is_never_known(i)) axes.push_back(i);
    if (interpreter.is_lost_in_tool_change(i)) kept.push_back(i);
  }
  job.AskStart(axes);
  job.AskKept(kept);
}

void Rewriter::Impl::NoteRotaryStood() {
  RewriteReport& report = job.report();
  if (report.blocks_corrected == 0) return;
  for (const AxisValue& stated : options.initial_position) {
    const int axis = machine::FindAxis(compensator.machine(), stated.axis);
    if (compensator.machine().axes[axis].kind != machine::AxisKind::kRotary || (named_rotary >> axis & 1)) continue;
    report.rotary_stood.emplace_back(stated.axis, stated.value * base::kDegPerRad);
  }
}

void Rewriter::Impl::Move() {
  if (passes() && step.ends_subprogram) {
    job.Passed(now, "the move ends a subprogram: left as it is, what called it goes on from there", false);
    Return();
    return Copy();
  }
  if (step.wrapped != 0) writer.Wrap(step);
  if (const std::string reason = TakeContour(); !reason.empty()) {
    job.Refused(now, reason, false);
    return Copy();
  }
  if (step.end.known != all_axes || writer.commanded().known != all_axes) [[unlikely]] {
    bool is_consequence = false;
    const std::string unknown = UnknownPosition(&is_consequence);
    if (!unknown.empty()) return MoveFromUnknown(unknown, is_consequence);
  }
  if (const std::string reason = step.is_tool_point ? WhyNoToolPoint() : ""; !reason.empty()) {
    NotCorrected(reason, false);
    if (passes()) Return();
    return Copy();
  }
  job.SetPlace(interpreter.tool(), interpreter.coordinates());
  for (const int axis : rotary_axes)
    named_rotary |= static_cast<uint16_t>((step.word_of_axis[axis] >= 0 || step.has_vector) << axis);
  if (options.orientation) block_grain = writer.GrainOf(block, step);
  const absl::Status corrected = corrector().CorrectEnd(step, block_grain, &piece);
  if (!corrected.ok()) {
    job.Refused(now, std::string(corrected.message()), false);
    return Copy();
  }
  if (const std::string reason = step.is_at_corner ? WhyNoCorner() : ""; !reason.empty()) {
    if (now.line != refused_corner_line) NotCorrected(reason, false);
    if (MustReturn()) Return();
    return Copy();
  }
  ++job.report().blocks_corrected;
  if (options.orientation) NoteHalfTurns();
  if (contour_role == ContourRole::kHeld) return WriteHeld();
  const bool is_at_contour = contour_role != ContourRole::kNone && contour_role != ContourRole::kPiece;
  const double departure_mm = step.is_arc || is_at_contour ? 0.0 : MoveDeparture();
  if (const std::string reason = WhyNoFeed(departure_mm); !reason.empty()) {
    --job.report().blocks_corrected;
    NotCorrected(reason, false);
    if (passes()) Return();  // from where it moves no linear axis, whether it names one or not
    return Copy();
  }
  if (const std::string reason = WhyNoTurn(piece, nullptr); !reason.empty()) return LeaveUnturned(reason);
  std::optional<Commanded> before;
  if (step.may_be_skipped) before = writer.commanded();
  if (step.is_arc || departure_mm > options.tolerance_mm) {
    if (!WriteSplit(departure_mm)) return;
  } else {
    const size_t begin = out.size();
    const AxisTicks commanded = writer.commanded().ticks;
    writer.WriteBlock(now.text, now.size, block, step, piece, 1.0, &out);
    CheckLength(begin);
    if (!is_mark_written && !IsWrittenAsItWas(begin)) WriteMark(begin);
    FollowContour(commanded, 0.0, piece);
    job.Account(now, piece, writer.commanded(), departure_mm);
    if (piece.turned.limit != compensate::DirectionLimit::kNone) job.Tilted(now, piece.turned);
  }
  if (passes()) writer.Arrive(step);
  if (before) writer.ForgetChanges(*before);
  if (before) writer.ForgetPole();
}

std::string Rewriter::Impl::WhyNoToolPoint() const {
  for (const int axis : interpreter.frame().xyz()) {
    if (!compensator.uses_sense(axis)) continue;
    return absl::StrCat(step.placed == nullptr ? "under tool centre point control " : "in a turned frame ",
                        compensator.machine().axes[axis].name,
                        " turns back inside moves, and its lost motion cannot be taken up there");
  }
  return "";
}

std::string Rewriter::Impl::WhyNoFeed(double departure_mm) const {
  const Interpreter& reader = interpreter;
  // Under tool centre point control F is of the tool point, on every control.
  if (step.is_rapid || step.is_arc || (reader.dialect().feeds_all_axes && !step.is_tool_point) ||
      reader.modal().feed_mode == FeedMode::kInverseTime)
    return "";
  const machine::Machine& machine = compensator.machine();
  // F is of X, Y and Z when one of them moves, else of other linear axes, else of rotary ones.
  const auto rank = [&](int axis) {
    if (machine.axes[axis].kind == machine::AxisKind::kRotary) return 2;
    const std::string& name = machine.axes[axis].name;
    return name == "X" || name == "Y" || name == "Z" ? 0 : 1;
  };
  constexpr int kNone = 3;
  int programmed = kNone, written = kNone;
  std::string word;
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (!step.start.is_known(i) || step.start.ticks[i] != step.end.ticks[i]) programmed = std::min(programmed, rank(i));
  }
  if (programmed == 0 || programmed == kNone) return "";
  written = programmed;
  for (const int axis : compensator.linear_axes()) {
    const Ticks grain =
        GrainTicks(reader.ticks_per_unit(axis), reader.modal().is_inch ? options.decimals_inch : options.decimals_mm);
    const bool moves = departure_mm > options.tolerance_mm || writer.NeedsWord(axis, piece.targets[axis], grain);
    if (!moves || rank(axis) >= written) continue;
    written = rank(axis);
    word = machine.axes[axis].name;
  }
  if (written == programmed) return "";
  return absl::StrCat(
      "a feed move of ", programmed == 2 ? "rotary axes" : "other axes than X, Y and Z", " alone: with the word of ",
      word,
      " that the correction needs the control would take F for another speed; program the move in G93 or "
      "as a rapid");
}

void Rewriter::Impl::LeaveUnturned(const std::string& reason) {
  --job.report().blocks_corrected;
  NotCorrected(reason, false);
  if (MustReturn()) Return();
  Copy();
}

machine::RollOver Rewriter::Impl::WayOfWord(int axis) const {
  if (compensator.machine().axes[axis].kind != machine::AxisKind::kRotary || (step.wrapped >> axis & 1))
    return machine::RollOver::kNone;
  const int index = step.word_of_axis[axis];
  const bool is_incremental = index < 0 ? interpreter.modal().is_incremental
                                        : interpreter.IsIncremental(block.words[static_cast<size_t>(index)]);
  return is_incremental ? machine::RollOver::kNone : interpreter.WayOf(axis);
}

bool Rewriter::Impl::TurnsOtherwise(int axis, Ticks from, Ticks to) const {
  if (to == from || !step.start.is_known(axis)) return false;
  const Ticks travel = step.end.ticks[axis] - step.start.ticks[axis];
  return to > from ? travel <= 0 : travel >= 0;
}

std::string Rewriter::Impl::WhyNoTurn(const Piece& next, const Piece* last) const {
  const machine::Machine& machine = compensator.machine();
  for (int i = 0; options.orientation && i < machine.axis_count(); ++i) {
    const machine::RollOver way = WayOfWord(i);
    if (way == machine::RollOver::kNone || way == machine::RollOver::kShortest) continue;
    const bool is_named = step.word_of_axis[i] >= 0;
    // By the sign 0.004 deg back is nearly a full turn, by the difference so is 0.004 deg across 0.
    const auto turns = [&](Ticks number) {
      return std::floor(static_cast<double>(number) / static_cast<double>(kTurn));
    };
    const bool crosses = is_named && turns(next.targets[i] - interpreter.offset(i) - writer.preset_shift(i)) !=
                                         turns(next.nominal[i] - interpreter.offset(i));
    const bool turns_otherwise =
        is_named && way == machine::RollOver::kUnstated && (last != nullptr || writer.commanded().is_known(i)) &&
        TurnsOtherwise(i, last != nullptr ? last->targets[i] : writer.commanded().ticks[i], next.targets[i]);
    if (is_named ? !crosses && !turns_otherwise : !writer.NeedsWord(i, next.targets[i], 0)) continue;
    const std::string& name = machine.axes[i].name;
    if (way == machine::RollOver::kUnstated) {
      return absl::StrCat("the correction turns ", name,
                          !is_named ? ", which the block does not name"
                          : crosses ? " across 0"
                                    : " another way than the program does",
                          ", and the way is not known: state in machine.json how the axis counts (roll_over)");
    }
    return absl::StrCat("the correction turns ", name, ", which the block does not name, and the axis goes by the ",
                        way == machine::RollOver::kBySign ? "sign" : "difference",
                        " (roll_over): that may be nearly a full turn");
  }
  return "";
}

std::string Rewriter::Impl::WhyNoCopy() const {
  const machine::Machine& machine = compensator.machine();
  for (int i = 0; options.orientation && step.kind == StepKind::kMove && i < machine.axis_count(); ++i) {
    if (step.word_of_axis[i] < 0 || WayOfWord(i) != machine::RollOver::kUnstated || !writer.commanded().is_known(i))
      continue;
    if (!TurnsOtherwise(i, writer.commanded().ticks[i], step.end.ticks[i] + writer.preset_shift(i))) continue;
    return absl::StrCat("the control stands at a corrected position of ", machine.axes[i].name,
                        ", and the block as it is would turn it another way than the program does: state in "
                        "machine.json how the axis counts (roll_over)");
  }
  return "";
}

void Rewriter::Impl::CheckLength(size_t begin) {
  const size_t most = interpreter.dialect().max_block_bytes;
  const size_t size = out.size() - begin;
  if (most == 0 || size <= most) return;
  const std::string reason = absl::StrCat("the block has ", size, " bytes with its line end, and the control reads ",
                                          most, ": shorten its comment");
  if (step.kind == StepKind::kMove) return job.Refused(now, reason, false);
  NotCorrected(reason, false);
}

void Rewriter::Impl::NoteHalfTurns() {
  const machine::Machine& machine = compensator.machine();
  for (int i = 0; i < machine.axis_count(); ++i) {
    const auto bit = static_cast<uint16_t>(1u << i);
    if (machine.axes[i].kind != machine::AxisKind::kRotary || machine.axes[i].roll_over == machine::RollOver::kNone ||
        !step.start.is_known(i) || (half_turns & bit))
      continue;
    const double travel_deg = std::abs(static_cast<double>(step.end.ticks[i] - step.start.ticks[i])) / kTicksPerUnit;
    const double apart_deg = std::abs(std::fmod(travel_deg, 360.0) - 180.0);
    if (apart_deg > 2.0 * options.max_rotary_correction_rad * base::kDegPerRad) continue;
    half_turns |= bit;
    job.Note(now, "half-turn",
             absl::StrCat("a move of ", machine.axes[i].name,
                          " by half a turn: a control that takes the shorter way may now take the other one"));
  }
}

double Rewriter::Impl::MoveDeparture() {
  if (step.is_rapid || step.start.known != all_axes) return 0.0;
  if (TakesUpReversal()) return std::numeric_limits<double>::infinity();
  const absl::StatusOr<double> departure_mm = corrector().Departure(step, piece);
  return departure_mm.ok() ? *departure_mm : std::numeric_limits<double>::infinity();
}

bool Rewriter::Impl::TakesUpReversal() {
  if (!corrector().uses_sense() || writer.commanded().known != all_axes) return false;
  Piece start;
  return corrector().CorrectStart(step, WordGrain(), &start).ok() &&
         corrector().Apart(start, writer.commanded().ticks) > options.tolerance_mm;
}

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
    tools.push_back({length.number, length.length_mm, std::move(longer)});
  }
  auto complete = std::make_unique<RewriteOptions>(options);
  complete->tool_tip_mm = compensator.tool_tip_mm();
  std::unique_ptr<const RewriteOptions> owned_options = std::move(complete);
  ASSIGN_OR_RETURN(Interpreter interpreter, Interpreter::Create(compensator.machine(), *owned_options));
  interpreter.StopAtCalls();
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
      [this](const char* text, size_t length, bool is_overlong) { impl_->Take(text, length, is_overlong); },
      [this](const char* text, size_t length) { impl_->Rest(text, length); });
  return impl_->status;
}

absl::Status Rewriter::Finish() {
  if (impl_->is_finished) return impl_->status;
  impl_->is_finished = true;
  impl_->splitter.Finish(
      [this](const char* text, size_t length, bool is_overlong) { impl_->Take(text, length, is_overlong); });
  impl_->preamble.Finish(
      [this](const char* text, size_t length, bool is_overlong) { impl_->Line(text, length, is_overlong); });
  if (impl_->status.ok()) impl_->corners.Release(kNoMoveBehind, impl_.get());
  if (impl_->is_waiting && impl_->status.ok()) impl_->RunCalls();
  impl_->NoteRotaryStood();
  impl_->job.Finish();
  impl_->Flush();
  if (!impl_->is_null() && !impl_->is_mark_written && !impl_->job.is_refused())
    impl_->job.report().notes.push_back(
        {"unchanged", "no word changed: the program stays byte for byte, without a mark"});
  if (impl_->status.ok() && impl_->job.is_refused()) impl_->status = impl_->job.Refusal();
  return impl_->status;
}

const RewriteReport& Rewriter::report() const { return impl_->job.report(); }

}  // namespace axiscal::nc
