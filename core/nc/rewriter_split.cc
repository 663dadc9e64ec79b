// A move in pieces: an arc, a reversal whose lost motion is taken up first, or a correction that bends too much.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/units.h"
#include "core/nc/rewriter_impl.h"

namespace axiscal::nc {

absl::StatusOr<std::vector<Piece>> Rewriter::Impl::Pieces() {
  const WordGrain grain = writer.GrainOf(block, step);
  if (step.is_arc) return corrector().SplitArc(step, writer.commanded().ticks, grain);
  std::vector<Piece> pieces;
  if (TakesUpReversal()) {  // of no contour: TakeContour refuses machines that have any
    pieces.emplace_back();
    RETURN_IF_ERROR(corrector().CorrectStart(step, grain, &pieces.back()));
  }
  ASSIGN_OR_RETURN(const std::vector<Piece> moves, corrector().Split(step, grain));
  pieces.insert(pieces.end(), moves.begin(), moves.end());
  return pieces;
}

bool Rewriter::Impl::WriteSplit(double departure_mm) {
  const absl::StatusOr<std::vector<Piece>> pieces = Pieces();
  if (!pieces.ok()) {
    job.Refused(now, std::string(pieces.status().message()), false);
    Copy();
    return false;
  }
  const Piece* last = nullptr;
  for (const Piece& next : *pieces) {
    if (const std::string reason = WhyNoTurn(next, last); !reason.empty()) {
      LeaveUnturned(reason);
      return false;
    }
    last = &next;
  }
  const bool is_straight = std::any_of(pieces->begin(), pieces->end(), [](const Piece& next) { return !next.is_arc; });
  if (contour_role == ContourRole::kPiece && step.is_arc && is_straight) {
    job.Refused(now,
                "the correction makes no arcs of it within the tolerance, and a straight piece would lead the cutter "
                "aside: state a larger --tolerance-um, or end cutter compensation in front of it",
                false);
    Copy();
    return false;
  }
  if (std::string reason = pieces->size() > 1 ? WhyNotSplit() : ""; !reason.empty()) {
    const std::string departs =
        std::isfinite(departure_mm) && !step.is_arc
            ? absl::StrFormat("the correction departs from linear by %.2f um", departure_mm * base::kUmPerMm)
            : std::string("the correction bends along the move");
    job.Refused(now, absl::StrCat(departs, " and the move cannot be split: ", reason), false);
    Copy();
    return false;
  }
  is_last_split = pieces->size() > 1;
  job.report().blocks_split += is_last_split;
  job.report().blocks_inserted += static_cast<int64_t>(pieces->size()) - 1;
  const std::string line_end = LineEnd();
  const bool is_packed = BlockWriter::IsPacked(now.text, block);
  double from = 0.0;
  compensate::Turned worst;
  if (pieces->size() > 1) WriteMark(out.size());
  for (const Piece& next : *pieces) {
    if (next.turned.limit != compensate::DirectionLimit::kNone && next.turned.tilt_left_rad > worst.tilt_left_rad)
      worst = next.turned;
    const double fraction = next.end_fraction - from;
    const AxisTicks commanded = writer.commanded().ticks;
    if (&next == pieces->data()) {
      const size_t begin = out.size();
      writer.WriteBlock(now.text, now.size, block, step, next, fraction, &out);
      CheckLength(begin);
      if (!is_mark_written && !IsWrittenAsItWas(begin)) WriteMark(begin);
      if (now.text_size == now.size && pieces->size() > 1) out.append(line_end);
    } else {
      out.append(SkipPrefix());
      writer.WritePiece(now.text, block, step, next, fraction, is_packed, line_end, &out);
    }
    FollowContour(commanded, from, next);
    from = next.end_fraction;
    job.Account(now, next, writer.commanded(), std::isfinite(options.tolerance_mm) ? options.tolerance_mm : 0.0);
    if (out.size() >= kOutBytes) Flush();
  }
  if (worst.limit != compensate::DirectionLimit::kNone) job.Tilted(now, worst);
  return true;
}

std::string Rewriter::Impl::SkipPrefix() const {
  if (!block.is_deletable) return "";
  const char* const slash = std::strchr(now.text, '/');
  // Klartext: the digit is of the block's number.
  const bool has_switch = slash[1] >= '0' && slash[1] <= '9' && !interpreter.dialect().has_bare_keywords;
  return std::string(slash, has_switch ? 2 : 1);
}

std::string Rewriter::Impl::WhyNotSplit() const {
  constexpr double kMaxFeed = 1e9;
  if (step.ends_block || step.is_tool_change) return "its block has a code that acts, or may act, after the move";
  if (step.is_at_corner) {
    return absl::StrCat("the control rounds or chamfers the corner at one of its ends, and needs it whole",
                        line_problem.empty() ? "" : ": ", line_problem);
  }
  // Pieces are written in the mode of the program, and an absolute word may go another way than the block's own.
  for (int i = 0; i < compensator.machine().axis_count() && !interpreter.modal().is_incremental; ++i) {
    const machine::Axis& axis = compensator.machine().axes[i];
    const int index = step.word_of_axis[i];
    if (axis.kind == machine::AxisKind::kRotary && index >= 0 &&
        interpreter.IsIncremental(block.words[static_cast<size_t>(index)]) &&
        interpreter.WayOf(i) != machine::RollOver::kNone) {
      return absl::StrCat("its pieces would be absolute, its word of ", axis.name,
                          " is incremental, and that axis does not count on (roll_over)");
    }
  }
  if (interpreter.modal().uncertain & kFeedGroup) return "the feed mode is not known";
  if (interpreter.modal().feed_mode != FeedMode::kInverseTime) return "";
  for (const Word& word : block) {
    if (word.letter == 'F') return ValueOf(word.number) < kMaxFeed ? "" : "its feed is out of range";
  }
  return "G93 without an F word";
}

}  // namespace axiscal::nc
