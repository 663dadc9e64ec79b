// Lines that stand in place of the program's: corners as moves (corners.h), patterns of holes (hole_patterns.h).
#include <cmath>
#include <cstdlib>

#include "core/nc/hole_patterns.h"
#include "core/nc/rewriter_impl.h"

namespace axiscal::nc {

void Rewriter::Impl::Read(const CornerLine& line) {
  if (!status.ok()) return;
  interpreter.ReadAs(line.number);
  now = {line.text, line.size, TextSize(line.text, line.size), line.number};
  if (line.is_changed && !is_null()) {
    if (!has_mark_place) KeepMarkPlace();
    WriteMark(out.size());
  }
  if (line.is_refused && is_null()) job.Passed(now, line.problem, false);
  if (line.is_refused && !is_null()) job.Refused(now, line.problem, false);
  if (line.is_refused) refused_corner_line = line.number;
  if (!line.problem.empty()) line_problem = line.problem;
  const int64_t corrected = job.report().blocks_corrected;
  ReadOrExpand(false, line.is_changed);
  if (step.kind == StepKind::kMove && line.problem.empty()) line_problem.clear();
  if (line.is_inserted) CountInserted(corrected);
}

void Rewriter::Impl::CountInserted(int64_t corrected) {
  job.report().blocks_read -= step.has_words;
  job.report().blocks_corrected = corrected;
  ++job.report().blocks_inserted;
}

void Rewriter::Impl::ReadOrExpand(bool is_overlong, bool is_resolved) {
  if (is_overlong || !MayBeHolePattern(interpreter.dialect(), now.text, now.text_size))
    return ReadLine(is_overlong, is_resolved);
  const HolePattern pattern = ReadHolePattern(interpreter, now.text, now.size);
  if (!pattern.problem.empty()) line_problem = pattern.problem;
  if (pattern.lines.empty()) return ReadLine(false, is_resolved);
  const int64_t number = now.line;
  if (!is_null()) {
    if (!has_mark_place) KeepMarkPlace();
    WriteMark(out.size());
  }
  for (const std::string& line : pattern.lines) {
    if (!status.ok()) return;
    interpreter.ReadAs(number);
    now = {line.data(), line.size(), TextSize(line.data(), line.size()), number};
    const int64_t corrected = job.report().blocks_corrected;
    ReadLine(false, true);
    if (&line != pattern.lines.data()) CountInserted(corrected);
  }
}

bool Rewriter::Impl::MayStay(const Step& from, const Step& to, double reach_mm) {
  if (from.cutter_side != 0 || from.is_arc || to.is_arc || options.orientation || corrector().uses_sense() ||
      from.tool_length != interpreter.coordinates().active_length())
    return false;
  Piece begin, first, second;
  if (!corrector().CorrectStart(from, WordGrain(), &begin).ok() ||
      !corrector().CorrectEnd(from, WordGrain(), &first).ok() || !corrector().CorrectEnd(to, WordGrain(), &second).ok())
    return false;
  for (const Step* side : {&from, &to}) {
    const absl::StatusOr<double> departure_mm = corrector().Departure(*side, side == &from ? first : second);
    if (!departure_mm.ok() || *departure_mm > options.tolerance_mm) return false;
  }
  // What the correction, and the rounding of words, turn and stretch each move by.
  const auto strain = [&](const Step& side, const Piece& before, const Piece& behind) {
    double length = 0, change = 0;
    for (const int axis : compensator.linear_axes()) {
      const auto grain = static_cast<double>(GrainTicks(
          interpreter.ticks_per_unit(axis), interpreter.modal().is_inch ? options.decimals_inch : options.decimals_mm));
      length = std::hypot(length, static_cast<double>(side.end.ticks[axis] - side.start.ticks[axis]));
      change = std::hypot(change, grain + std::abs(static_cast<double>((behind.targets[axis] - behind.nominal[axis]) -
                                                                       (before.targets[axis] - before.nominal[axis]))));
    }
    return change / length;
  };
  constexpr double kShareOfTolerance = 0.5;
  const double off_mm = reach_mm * (strain(from, begin, first) + strain(to, first, second));
  if (!(off_mm <= kShareOfTolerance * options.tolerance_mm)) return false;
  for (int axis = 0; axis < compensator.machine().axis_count(); ++axis) {
    if (axis == interpreter.PlaneAxis(0) || axis == interpreter.PlaneAxis(1)) continue;
    const Ticks grain = GrainTicks(interpreter.ticks_per_unit(axis),
                                   interpreter.modal().is_inch ? options.decimals_inch : options.decimals_mm);
    // Both beside what is commanded now, as it stays so; between them lies where a corner behind may end the second.
    if (writer.NeedsWord(axis, first.targets[axis], grain) || writer.NeedsWord(axis, second.targets[axis], grain))
      return false;
  }
  return true;
}

void Rewriter::Impl::ShortenWords() {
  // No word says so: a word of these decimals is written anew.
  constexpr int64_t kUnsaid = 77'777'777'777'777;
  const int decimals = interpreter.modal().is_inch ? options.decimals_inch : options.decimals_mm;
  for (int i = 0; i < block.word_count; ++i) {
    Word& word = block.words[static_cast<size_t>(i)];
    const Role role = interpreter.RoleOf(word.letter);
    if ((role != Role::kAxis && role != Role::kCentre) || word.number.decimals != kMaxDecimals) continue;
    word.number.mantissa = kUnsaid;
    word.number.decimals = static_cast<int8_t>(decimals);
  }
}

std::string Rewriter::Impl::WhyNoCorner() const {
  if (!interpreter.dialect().has_equals) return "";
  for (int axis = 0; axis < compensator.machine().axis_count(); ++axis) {
    if (axis == interpreter.PlaneAxis(0) || axis == interpreter.PlaneAxis(1)) continue;
    const bool moves = !step.start.is_known(axis) || step.start.ticks[axis] != step.end.ticks[axis];
    const Ticks grain = GrainTicks(interpreter.ticks_per_unit(axis),
                                   interpreter.modal().is_inch ? options.decimals_inch : options.decimals_mm);
    if (moves || !writer.NeedsWord(axis, piece.targets[axis], grain)) continue;
    return absl::StrCat("the correction moves ", compensator.machine().axes[axis].name,
                        ", and the control rounds or chamfers no corner beside a move that leaves the working plane",
                        line_problem.empty() ? "" : ": ", line_problem);
  }
  return "";
}

}  // namespace axiscal::nc
