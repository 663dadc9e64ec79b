#include "core/nc/verify.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include "core/base/units.h"
#include "core/machine/redundant_facts.h"
#include "core/nc/moves_ahead.h"
#include "core/nc/poses.h"
#include "core/nc/tool_chain.h"

namespace axiscal::nc {
namespace {

constexpr int kMaxPiecesPerMove = 20000;
constexpr double kRotaryMatchDeg = 0.0005;  // words of four decimals, and room for three
// Where a piece is looked at between its ends: evenly, so often at least, and so that waves of an error show.
constexpr int kLeastLooks = 3;
// A move of no more than this on every axis is looked at in its middle alone: looks, with the ends, then stand closer
// than on longer moves, and there the departure of a straight piece, a parabola, is largest.
constexpr double kShortMm = 1.0, kShortRad = 1.0 * base::kRadPerDeg;
constexpr int kMostLooks = 255;
constexpr double kLookMm = 5.0;
constexpr double kLookRad = 5.0 * base::kRadPerDeg;

using Values = std::array<double, machine::kMaxAxes>;  // mm, rad

double AngleBetween(const ToolPose& a, const ToolPose& b) {
  // Up to here the series is exact but for the last bit of a double: the next term is 3/40 of its fifth power.
  constexpr double kSmall = 1e-3;
  const double sine = a.direction.cross(b.direction).norm(), cosine = a.direction.dot(b.direction);
  return sine < kSmall && cosine > 0.0 ? sine * (1.0 + sine * sine / 6.0) : std::atan2(sine, cosine);
}

class Verifier {
 public:
  Verifier(const machine::Machine& machine, const machine::ErrorModel& errors, const VerifyOptions& options)
      : machine_(machine),
        options_(options),
        frame_(machine, options.tool_tip_mm),
        nominal_(machine, {}, options.time_s, options.temperature_celsius),
        actual_(machine, errors, options.time_s, options.temperature_celsius) {
    if (options.reading.orientation) rotary_match_deg_ += options.reading.max_rotary_correction_rad * base::kDegPerRad;
  }

  absl::StatusOr<VerifyReport> Run(MovesAhead* original, MovesAhead* compensated) {
    Event wanted, found;
    while (true) {
      ASSIGN_OR_RETURN(const bool has_wanted, original->Next(&wanted));
      if (!has_wanted) break;
      if (wanted.step.kind == StepKind::kHole) {
        RETURN_IF_ERROR(PairHole(wanted, compensated, &found));
        last_end_ = wanted.step.end;
        continue;
      }
      if (wanted.step.kind != StepKind::kMove) {
        do {
          RETURN_IF_ERROR(NextOf(compensated, wanted, &found));
        } while (IsReturn(last_end_, found.step));
        if (found.step.kind != wanted.step.kind) return Mismatch(wanted, found, "is not the same block");
        if (wanted.step.kind == StepKind::kNone) continue;
        ++report_.blocks_unsupported;
        report_.blocks_passed += wanted.step.kind == StepKind::kUnsupported;
        report_.not_judged.Add(wanted.line, wanted.step.reason);
        if (wanted.step.kind == StepKind::kUnsupported) last_end_.known = 0;
        continue;
      }
      RETURN_IF_ERROR(Pair(wanted, compensated, &found));
      last_end_ = wanted.step.end;
    }
    ASSIGN_OR_RETURN(const bool has_more, Take(compensated, &found));
    if (has_more)
      return absl::InvalidArgumentError(
          absl::StrCat("line ", found.line, " of the compensated program: the original has no such move"));
    return report_;
  }

 private:
  // The next event of the compensated program: one that was looked at already, or a new one.
  absl::StatusOr<bool> Take(MovesAhead* compensated, Event* found) {
    if (ahead_.empty()) return compensated->Next(found);
    *found = std::move(ahead_.front());
    ahead_.pop_front();
    return true;
  }

  absl::Status NextOf(MovesAhead* compensated, const Event& wanted, Event* found) {
    ASSIGN_OR_RETURN(const bool has_found, Take(compensated, found));
    if (has_found) return absl::OkStatus();
    return absl::InvalidArgumentError(
        absl::StrCat("line ", wanted.line, " of the original: the compensated program ends before it"));
  }

  static absl::Status Mismatch(const Event& wanted, const Event& found, const std::string& what) {
    return absl::InvalidArgumentError(absl::StrCat("line ", found.line, " of the compensated program ", what,
                                                   " as line ", wanted.line, " of the original"));
  }

  bool IsKnown(const nc::Positions& positions) const { return positions.known == (1u << machine_.axis_count()) - 1; }

  // A hole: the tool point where the drill goes in, and at the bottom.
  absl::Status PairHole(const Event& wanted, MovesAhead* compensated, Event* found) {
    do {
      RETURN_IF_ERROR(NextOf(compensated, wanted, found));
    } while (IsReturn(last_end_, found->step));
    if (found->step.kind != StepKind::kHole) return Mismatch(wanted, *found, "is not such a hole");
    if (found->step.is_tool_point != wanted.step.is_tool_point)
      return Mismatch(wanted, *found, "does not stand in the same frame");
    ++report_.moves;
    ++report_.pieces;
    TakeTool(wanted.step);
    const int z = machine::FindAxis(machine_, "Z");
    const auto at = [z](const Step& step, Ticks height) {
      nc::Positions position = step.end;
      position.ticks[z] = height;
      position.known |= static_cast<uint16_t>(1u << z);
      return position;
    };
    if (!IsKnown(at(wanted.step, 0))) {
      ++report_.moves_unknown;
      report_.not_judged.Add(wanted.line, "an axis position is unknown");
      return absl::OkStatus();
    }
    report_.not_judged.End();
    AxisSenses senses = wanted.step.end.sense;
    senses[z] = -1;
    for (const bool is_bottom : {false, true}) {
      const auto height = [is_bottom](const Step& step) { return is_bottom ? step.hole.bottom : step.hole.entry; };
      const nc::Positions nominal = at(wanted.step, height(wanted.step)), told = at(found->step, height(found->step));
      if (!IsNear(nominal, told, static_cast<uint16_t>((1u << machine_.axis_count()) - 1)))
        return Mismatch(wanted, *found, "does not drill at the same position");
      AddEnd(ToolsAt(AxesOf(wanted.step, PositionsOf(nominal)), AxesOf(found->step, PositionsOf(told)), senses),
             wanted.line);
    }
    return absl::OkStatus();
  }

  // Brings a piece of a move whose axes count from 0 to 360 deg to the turns of that move.
  static void Unwrap(const Step& wanted, Step* found) {
    for (int i = 0; wanted.wrapped >> i; ++i) {
      if ((wanted.wrapped >> i & 1) == 0) continue;
      const Ticks to = wanted.end.ticks[i], from = wanted.start.is_known(i) ? wanted.start.ticks[i] : to;
      const Ticks turns = RoundToGrains(found->end.ticks[i] - from - (to - from) / 2, kTurn) * kTurn;
      found->end.ticks[i] -= turns, found->start.ticks[i] -= turns;
    }
  }

  // Whether the move only brings the control back to where the program is: within a correction of it.
  bool IsReturn(const nc::Positions& at, const Step& found) const {
    if (found.kind != StepKind::kMove || found.is_arc || (at.known & found.end.known) == 0) return false;
    return IsNear(at, found.end, static_cast<uint16_t>(at.known & found.end.known));
  }

  bool Reaches(const Step& wanted, const Step& found) const {
    return IsNear(wanted.end, found.end, static_cast<uint16_t>((1u << machine_.axis_count()) - 1));
  }

  bool IsNear(const nc::Positions& wanted, const nc::Positions& found, uint16_t axes) const {
    for (int i = 0; i < machine_.axis_count(); ++i) {
      if ((axes >> i & 1) == 0) continue;
      const double apart = std::abs(static_cast<double>(found.ticks[i] - wanted.ticks[i])) / kTicksPerUnit;
      const bool is_linear = machine_.axes[i].kind == machine::AxisKind::kLinear;
      if (apart > (is_linear ? options_.reading.max_correction_mm : rotary_match_deg_)) return false;
    }
    return true;
  }

  // The tool where the original's command leads: nominal, and of the machine with its errors; and where the command of
  // the compensated program leads the latter.
  struct Tools {
    ToolPose nominal, before, after;

    double after_mm() const { return (after.tip_mm - nominal.tip_mm).norm(); }
  };

  // Senses are the original's: a correction of micrometres reverses no axis.
  Tools ToolsAt(const Values& original, const Values& compensated, const AxisSenses& senses) const {
    const AxesAt original_axes = ToolChain::Prepare(machine_, original, nullptr);
    const AxesAt axes = ToolChain::Prepare(machine_, compensated, &original_axes);
    return {nominal_.At(original_axes, senses, tip_mm_), actual_.At(original_axes, senses, tip_mm_),
            actual_.At(axes, senses, tip_mm_)};
  }

  Tools ToolsAtEnd(const Event& wanted, const Event& found) const {
    return ToolsAt(AxesOf(wanted.step, PositionsOf(wanted.step.end)), AxesOf(found.step, PositionsOf(found.step.end)),
                   wanted.step.end.sense);
  }

  void AddEnd(const Tools& tools, int64_t line) {
    const double after_mm = tools.after_mm();
    report_.end_before.Add((tools.before.tip_mm - tools.nominal.tip_mm).norm());
    report_.end_after.Add(after_mm);
    report_.end_tilt_before.Add(AngleBetween(tools.before, tools.nominal));
    report_.end_tilt_after.Add(AngleBetween(tools.after, tools.nominal));
    AddWorst(after_mm, line);
  }

  // Whether the piece, though near the move's end and `error_mm` off it, is not its last one (pieces may be short):
  // that is so where the pieces behind it come nearer, and one of them reaches the end exactly.
  absl::StatusOr<bool> IsBeforeLast(const Event& wanted, double error_mm, MovesAhead* compensated) {
    constexpr double kExactMm = 0.002;  // the words' rounding, and room
    constexpr size_t kMostPieces = 1000;
    for (size_t k = 0; error_mm > kExactMm && k < kMostPieces; ++k) {
      if (k == ahead_.size()) {
        Event next;
        ASSIGN_OR_RETURN(const bool has_next, compensated->Next(&next));
        if (!has_next) return false;
        if (next.step.wrapped == wanted.step.wrapped) Unwrap(wanted.step, &next.step);
        ahead_.push_back(std::move(next));
      }
      const Event& next = ahead_[k];
      if (next.step.kind != StepKind::kMove || !Reaches(wanted.step, next.step)) return false;
      const double next_mm = ToolsAtEnd(wanted, next).after_mm();
      if (next_mm <= kExactMm) return true;
      if (next_mm >= error_mm) return false;
      error_mm = next_mm;
    }
    return false;
  }

  // Whether the piece ends the arc: from `fraction` on there is no room for another piece. Along an arc of more than
  // half a turn the tool first goes away from its end, so that a piece near the end may be one of its first.
  bool IsAtEnd(const Event& wanted, const Event& found, double fraction) const {
    constexpr double kLastChordBegins = 0.4;  // of the arc at least: it has two chords or more, and words are rounded
    if (std::abs(wanted.step.arc.sweep_rad) <= std::numbers::pi) return true;
    if (found.step.is_arc) {
      return fraction + std::abs(found.step.arc.sweep_rad / wanted.step.arc.sweep_rad) > 0.99;
    }
    return fraction > kLastChordBegins;
  }

  Values PositionsOf(const nc::Positions& axes) const { return AxisValuesOf(machine_, axes); }

  // Axis positions of what the words of a move say, in the frame in which they stand.
  Values AxesOf(const Step& step, Values words) const {
    if (step.is_tool_point) frame_.ToAxes(LengthMm(step), step.placed.get(), words.data());
    return words;
  }

  double LengthMm(const Step& step) const {
    for (const ToolLength& length : options_.reading.tool_lengths) {
      if (length.number == step.tool_length) return length.length_mm;
    }
    return 0.0;
  }

  ToolPose Nominal(const Values& at) const {
    return nominal_.At(ToolChain::Prepare(machine_, at, nullptr), {}, tip_mm_);
  }
  ToolPose Actual(const Values& at, const AxisSenses& senses) const {
    return actual_.At(ToolChain::Prepare(machine_, at, nullptr), senses, tip_mm_);
  }

  // The tool point with the tool length in force.
  void TakeTool(const Step& step) { tip_mm_ = options_.tool_tip_mm + LengthMm(step) * machine_.tool_direction; }

  Values Between(const Values& from, const Values& to, double t) const {
    Values between{};
    for (int i = 0; i < machine_.axis_count(); ++i) between[i] = from[i] + t * (to[i] - from[i]);
    return between;
  }

  // The position of a program's axes at a fraction of its move.
  Values AlongMove(const Step& step, const Values& from, const Values& to, double t) const {
    Values between = Between(from, to, t);
    if (!step.is_arc) return between;
    const Eigen::Vector2d at_mm = step.arc.At(t);
    between[step.arc.first] = at_mm.x();
    between[step.arc.second] = at_mm.y();
    return between;
  }

  // The fraction of the nominal move at which a command inside it stands: by the angle of an arc, else by the axis that
  // travels most. A correction may move it by up to `slack`.
  double FractionOf(const Step& step, const Values& from, const Values& to, const Values& at, double last,
                    double* slack) const {
    *slack = 1e-3;
    if (step.is_arc) {
      const Eigen::Vector2d spoke = Eigen::Vector2d(at[step.arc.first], at[step.arc.second]) - step.arc.centre_mm;
      const double angle = std::atan2(spoke.y(), spoke.x()) - step.arc.start_rad;
      const double turn = 2.0 * std::numbers::pi / std::abs(step.arc.sweep_rad);
      double fraction = angle / step.arc.sweep_rad;
      *slack =
          std::max(1e-3, options_.reading.max_correction_mm / (step.arc.radius_mm() * std::abs(step.arc.sweep_rad)));
      // A correction may move it back a little, even before the begin.
      const double least = last - std::min(*slack, 0.1);
      while (fraction < least) fraction += turn;
      while (fraction - turn >= least) fraction -= turn;
      return fraction;
    }
    int longest = 0;
    double travel = 0;
    for (int i = 0; i < machine_.axis_count(); ++i) {
      const bool is_rotary = machine_.axes[i].kind == machine::AxisKind::kRotary;
      // Rotary axes come first: their corrections are the smallest, or none.
      const double length = std::abs(to[i] - from[i]) * (is_rotary ? 1e6 : 1.0);
      if (length > travel) longest = i, travel = length;
    }
    if (travel == 0) return 1.0;
    if (machine_.axes[longest].kind == machine::AxisKind::kLinear) {
      *slack = std::max(1e-3, options_.reading.max_correction_mm / travel);
    } else {
      *slack = std::max(1e-3, rotary_match_deg_ * base::kRadPerDeg / (1e-6 * travel));
    }
    return (at[longest] - from[longest]) / (to[longest] - from[longest]);
  }

  // The same where rotary commands are corrected too and tell the fraction less well: the fraction where the nominal
  // tool is nearest, in point and direction, to that of the machine with its errors. Starts at a fraction that is near.
  double NearestFraction(const Step& step, const Values& from, const Values& to, const Values& at,
                         double fraction) const {
    constexpr double kStep = 1e-4;
    constexpr int kIterations = 3;
    using Tool6 = Eigen::Matrix<double, 6, 1>;
    const auto stacked = [](const ToolPose& tool) {
      constexpr double kMmPerRad = 100.0;  // a direction counts as a point that far along the tool
      Tool6 all;
      all << tool.tip_mm, kMmPerRad * tool.direction;
      return all;
    };
    for (int i = 0; i < kIterations; ++i) {
      const Tool6 here = stacked(Nominal(AxesOf(step, AlongMove(step, from, to, fraction))));
      const Tool6 ahead = stacked(Nominal(AxesOf(step, AlongMove(step, from, to, fraction + kStep))));
      const Tool6 slope = (ahead - here) / kStep;
      const Tool6 apart = stacked(Actual(AxesOf(step, at), SensesAt(step, fraction))) - here;
      if (slope.squaredNorm() == 0) return fraction;
      fraction += slope.dot(apart) / slope.squaredNorm();
    }
    return fraction;
  }

  void AddWorst(double error_mm, int64_t line) {
    if (error_mm <= worst_mm_) return;
    worst_mm_ = error_mm;
    report_.worst_line = line;
  }

  int LooksInside(const Step& step, const Values& from, const Values& to) const {
    double looks = kLeastLooks;
    bool is_short = !step.is_arc;
    for (int i = 0; i < machine_.axis_count(); ++i) {
      const bool is_rotary = machine_.axes[i].kind == machine::AxisKind::kRotary;
      const double travel = std::abs(to[i] - from[i]);
      is_short = is_short && travel <= (is_rotary ? kShortRad : kShortMm);
      looks = std::max(looks, travel / (is_rotary ? kLookRad : kLookMm));
    }
    if (is_short) return 1;
    if (step.is_arc) looks = std::max(looks, std::abs(step.arc.sweep_rad) * step.arc.radius_mm() / kLookMm);
    return static_cast<int>(std::ceil(std::min<double>(looks, kMostLooks)));
  }

  // Inside one piece, from command `from` to `to`, nominal fractions `first` to `last`.
  void LookInside(const Event& wanted, const Values& nominal_from, const Values& nominal_to, const Event& found,
                  const Values& from, const Values& to, double first, double last) {
    const int looks = LooksInside(found.step, from, to);
    for (int look = 1; look <= looks; ++look) {
      const double t = look / (looks + 1.0);
      const double fraction = first + t * (last - first);
      const Tools tools =
          ToolsAt(AxesOf(wanted.step, AlongMove(wanted.step, nominal_from, nominal_to, fraction)),
                  AxesOf(found.step, AlongMove(found.step, from, to, t)), SensesAt(wanted.step, fraction));
      const ToolPose& path = tools.nominal;
      const Eigen::Vector3d ahead_mm =
          Nominal(AxesOf(wanted.step, AlongMove(wanted.step, nominal_from, nominal_to, fraction + 1e-4))).tip_mm -
          path.tip_mm;
      const auto across = [&](const Eigen::Vector3d& error_mm) {
        const double squared = ahead_mm.squaredNorm();
        return squared < 1e-18 ? error_mm.norm() : (error_mm - ahead_mm * (ahead_mm.dot(error_mm) / squared)).norm();
      };
      report_.path_before.Add(across(tools.before.tip_mm - path.tip_mm));
      const double after_mm = across(tools.after.tip_mm - path.tip_mm);
      report_.path_after.Add(after_mm);
      report_.path_tilt_before.Add(AngleBetween(tools.before, path));
      report_.path_tilt_after.Add(AngleBetween(tools.after, path));
      AddWorst(after_mm, wanted.line);
    }
  }

  // The senses of motion at a fraction of the original's move: on an arc they turn.
  static AxisSenses SensesAt(const Step& step, double fraction) {
    AxisSenses senses = step.end.sense;
    if (!step.is_arc) return senses;
    const double angle = step.arc.start_rad + fraction * step.arc.sweep_rad;
    senses[step.arc.first] = -std::sin(angle) * step.arc.sweep_rad > 0 ? 1 : -1;
    senses[step.arc.second] = std::cos(angle) * step.arc.sweep_rad > 0 ? 1 : -1;
    return senses;
  }

  absl::Status Pair(const Event& wanted, MovesAhead* compensated, Event* found) {
    ++report_.moves;
    TakeTool(wanted.step);
    const bool is_known = IsKnown(wanted.step.end);
    const bool has_path = is_known && !wanted.step.is_rapid && IsKnown(wanted.step.start);
    report_.moves_unknown += !is_known;
    if (is_known) {
      report_.not_judged.End();
    } else {
      report_.not_judged.Add(wanted.line, "an axis position is unknown");
    }
    const Values nominal_from = PositionsOf(wanted.step.start), nominal_to = PositionsOf(wanted.step.end);
    double fraction = 0.0;
    for (int piece = 0;; ++piece) {
      RETURN_IF_ERROR(NextOf(compensated, wanted, found));
      // In front of an arc that is passed, or of a pole.
      const bool may_return = is_known ? !has_path && !Reaches(wanted.step, found->step) : wanted.step.is_arc;
      if (found->step.kind == StepKind::kMove && found->step.is_tool_point != wanted.step.is_tool_point)
        return Mismatch(wanted, *found, "does not stand in the same frame");
      if (piece == 0 && may_return && IsReturn(wanted.step.start, found->step)) continue;
      if (found->step.kind != StepKind::kMove) return Mismatch(wanted, *found, "is not such a move");
      ++report_.pieces;
      if (found->step.wrapped == wanted.step.wrapped) Unwrap(wanted.step, &found->step);
      if (!is_known) return absl::OkStatus();
      if (piece >= kMaxPiecesPerMove || !IsKnown(found->step.end))
        return Mismatch(wanted, *found, "does not reach the same position");
      const Values to = PositionsOf(found->step.end);
      // Pieces of a full circle pass its end at the begin.
      bool is_last = Reaches(wanted.step, found->step) && (!wanted.step.is_arc || IsAtEnd(wanted, *found, fraction));
      std::optional<Tools> at_end;  // of the last piece
      if (is_last) at_end = ToolsAt(AxesOf(wanted.step, nominal_to), AxesOf(found->step, to), wanted.step.end.sense);
      if (is_last && has_path) {
        ASSIGN_OR_RETURN(const bool is_before_last, IsBeforeLast(wanted, at_end->after_mm(), compensated));
        is_last = !is_before_last;
      }
      double slack = 0;
      double next = is_last ? 1.0 : FractionOf(wanted.step, nominal_from, nominal_to, to, fraction, &slack);
      if (!is_last && has_path && options_.reading.orientation && std::isfinite(next))
        next = NearestFraction(wanted.step, nominal_from, nominal_to, to, next);
      if (!is_last && !(has_path && next > fraction - slack && next < 1.0 + slack))
        return Mismatch(wanted, *found, "does not go to the same position");
      // A piece of no length takes up what a reversal left: the tool stands meanwhile.
      if (has_path && IsKnown(found->step.start) && next - fraction > slack) {
        LookInside(wanted, nominal_from, nominal_to, *found, PositionsOf(found->step.start), to, fraction, next);
      }
      fraction = std::max(fraction, next);
      if (!is_last) continue;
      AddEnd(*at_end, wanted.line);
      return absl::OkStatus();
    }
  }

  const machine::Machine& machine_;
  const VerifyOptions& options_;
  const ToolPointFrame frame_;
  const ToolChain nominal_, actual_;
  VerifyReport report_;
  Eigen::Vector3d tip_mm_ = Eigen::Vector3d::Zero();
  double rotary_match_deg_ = kRotaryMatchDeg;
  double worst_mm_ = -1.0;
  std::deque<Event> ahead_;  // of the compensated program
  nc::Positions last_end_;   // of the original's last move
};

}  // namespace

absl::StatusOr<VerifyReport> Verify(const ByteReader& original, const ByteReader& compensated,
                                    const machine::Machine& machine, const machine::ErrorModel& errors,
                                    const VerifyOptions& options) {
  RETURN_IF_ERROR(machine::Validate(machine));
  RETURN_IF_ERROR(machine::CheckToolTip(machine, options.tool_tip_mm));
  RETURN_IF_ERROR(Validate(options.reading));
  RewriteOptions reading = options.reading;
  reading.tool_tip_mm = options.tool_tip_mm;
  ASSIGN_OR_RETURN(Interpreter of_original, Interpreter::Create(machine, reading));
  RewriteOptions reading_compensated = reading;
  reading_compensated.subprograms = options.compensated_subprograms;
  ASSIGN_OR_RETURN(Interpreter of_compensated, Interpreter::Create(machine, reading_compensated));
  MovesAhead original_moves(original, std::move(of_original));
  MovesAhead compensated_moves(compensated, std::move(of_compensated));
  return Verifier(machine, errors, options).Run(&original_moves, &compensated_moves);
}

absl::StatusOr<VerifyReport> VerifyText(const std::string& original, const std::string& compensated,
                                        const machine::Machine& machine, const machine::ErrorModel& errors,
                                        const VerifyOptions& options) {
  return Verify(TextReader(original), TextReader(compensated), machine, errors, options);
}

absl::StatusOr<VerifyReport> VerifyFiles(const std::string& original_path, const std::string& compensated_path,
                                         const machine::Machine& machine, const machine::ErrorModel& errors,
                                         const VerifyOptions& options) {
  ASSIGN_OR_RETURN(const ByteReader original, FileReader(original_path));
  ASSIGN_OR_RETURN(const ByteReader compensated, FileReader(compensated_path));
  return Verify(original, compensated, machine, errors, options);
}

}  // namespace axiscal::nc
