#include "core/nc/verify.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/units.h"
#include "core/nc/move_reader.h"

namespace axiscal::nc {
namespace {

constexpr int kMaxPiecesPerMove = 2000;
constexpr double kRotaryMatchDeg = 0.0005;       // words of four decimals, and room for three
constexpr double kInside[] = {0.25, 0.5, 0.75};  // where a piece is looked at between its ends

using Positions = std::array<double, machine::kMaxAxes>;  // mm, rad

class Verifier {
 public:
  Verifier(const machine::Machine& machine, const machine::ErrorModel& errors, const VerifyOptions& options)
      : machine_(machine), errors_(errors), options_(options) {}

  absl::StatusOr<VerifyReport> Run(MoveReader* original, MoveReader* compensated) {
    Event wanted, found;
    while (true) {
      ASSIGN_OR_RETURN(const bool has_wanted, original->Next(&wanted));
      if (!has_wanted) break;
      if (wanted.step.kind == StepKind::kUnsupported) {
        ++report_.blocks_unsupported;
        RETURN_IF_ERROR(NextOf(compensated, wanted, &found));
        if (found.step.kind != StepKind::kUnsupported) return Mismatch(wanted, found, "is not the same block");
        continue;
      }
      RETURN_IF_ERROR(Pair(wanted, compensated, &found));
    }
    ASSIGN_OR_RETURN(const bool has_more, compensated->Next(&found));
    if (has_more)
      return absl::InvalidArgumentError(
          absl::StrCat("line ", found.line, " of the compensated program: the original has no such move"));
    return report_;
  }

 private:
  absl::Status NextOf(MoveReader* compensated, const Event& wanted, Event* found) const {
    ASSIGN_OR_RETURN(const bool has_found, compensated->Next(found));
    if (has_found) return absl::OkStatus();
    return absl::InvalidArgumentError(
        absl::StrCat("line ", wanted.line, " of the original: the compensated program ends before it"));
  }

  static absl::Status Mismatch(const Event& wanted, const Event& found, const std::string& what) {
    return absl::InvalidArgumentError(absl::StrCat("line ", found.line, " of the compensated program ", what,
                                                   " as line ", wanted.line, " of the original"));
  }

  bool IsKnown(const std::array<AxisPosition, machine::kMaxAxes>& positions) const {
    for (int i = 0; i < machine_.axis_count(); ++i) {
      if (!positions[i].is_known) return false;
    }
    return true;
  }

  bool Reaches(const Step& wanted, const Step& found) const {
    for (int i = 0; i < machine_.axis_count(); ++i) {
      const double apart = std::abs(static_cast<double>(found.end[i].ticks - wanted.end[i].ticks)) / kTicksPerUnit;
      const bool is_linear = machine_.axes[i].kind == machine::AxisKind::kLinear;
      if (apart > (is_linear ? options_.reading.max_correction_mm : kRotaryMatchDeg)) return false;
    }
    return true;
  }

  Positions PositionsOf(const std::array<AxisPosition, machine::kMaxAxes>& axes) const {
    Positions positions{};
    for (int i = 0; i < machine_.axis_count(); ++i) {
      const bool is_rotary = machine_.axes[i].kind == machine::AxisKind::kRotary;
      positions[i] = static_cast<double>(axes[i].ticks) / kTicksPerUnit * (is_rotary ? base::kRadPerDeg : 1.0);
    }
    return positions;
  }

  // The tool point of the machine with its errors. Senses are the original's: a correction of micrometres reverses no
  // axis.
  Eigen::Vector3d Actual(const Positions& at, const Step& senses) const {
    std::array<shapes::AxisState, machine::kMaxAxes> axes;
    for (int i = 0; i < machine_.axis_count(); ++i) {
      axes[i].position = at[i];
      axes[i].sense = senses.end[i].sense;
    }
    shapes::State state;
    state.axes = {axes.data(), static_cast<size_t>(machine_.axis_count())};
    state.time_s = options_.time_s;
    state.temperature_celsius = options_.temperature_celsius;
    const auto errors = machine::ErrorsAt(machine_, errors_, state);
    return machine::TipInTable(machine::EvaluateChain<double>(machine_, at.data(), errors), options_.tool_tip_mm);
  }

  Eigen::Vector3d Nominal(const Positions& at) const {
    return machine::TipInTable(machine::EvaluateChain<double>(machine_, at.data(), {}), options_.tool_tip_mm);
  }

  Positions Between(const Positions& from, const Positions& to, double t) const {
    Positions between{};
    for (int i = 0; i < machine_.axis_count(); ++i) between[i] = from[i] + t * (to[i] - from[i]);
    return between;
  }

  // Where on the nominal move a command between its pieces stands: by the axis that travels most.
  double FractionOf(const Positions& from, const Positions& to, const Positions& at) const {
    int longest = 0;
    double travel = 0;
    for (int i = 0; i < machine_.axis_count(); ++i) {
      const bool is_rotary = machine_.axes[i].kind == machine::AxisKind::kRotary;
      const double length = std::abs(to[i] - from[i]) * (is_rotary ? 1e6 : 1.0);  // a rotary axis is not corrected
      if (length > travel) longest = i, travel = length;
    }
    return travel == 0 ? 1.0 : (at[longest] - from[longest]) / (to[longest] - from[longest]);
  }

  void AddWorst(double error_mm, int64_t line) {
    if (error_mm <= worst_mm_) return;
    worst_mm_ = error_mm;
    report_.worst_line = line;
  }

  // Inside one piece, from command `from` to `to`, nominal fractions `first` to `last`.
  void LookInside(const Event& wanted, const Positions& nominal_from, const Positions& nominal_to,
                  const Positions& from, const Positions& to, double first, double last) {
    for (const double t : kInside) {
      const double fraction = first + t * (last - first);
      const Positions nominal = Between(nominal_from, nominal_to, fraction);
      const Eigen::Vector3d path_mm = Nominal(nominal);
      const Eigen::Vector3d ahead_mm = Nominal(Between(nominal_from, nominal_to, fraction + 1e-4)) - path_mm;
      const auto across = [&](const Eigen::Vector3d& error_mm) {
        const double squared = ahead_mm.squaredNorm();
        return squared < 1e-18 ? error_mm.norm() : (error_mm - ahead_mm * (ahead_mm.dot(error_mm) / squared)).norm();
      };
      report_.path_before.Add(across(Actual(nominal, wanted.step) - path_mm));
      const double after_mm = across(Actual(Between(from, to, t), wanted.step) - path_mm);
      report_.path_after.Add(after_mm);
      AddWorst(after_mm, wanted.line);
    }
  }

  absl::Status Pair(const Event& wanted, MoveReader* compensated, Event* found) {
    ++report_.moves;
    const bool is_known = IsKnown(wanted.step.end);
    const bool has_path = is_known && !wanted.step.is_rapid && IsKnown(wanted.step.start);
    report_.moves_unknown += !is_known;
    const Positions nominal_from = PositionsOf(wanted.step.start), nominal_to = PositionsOf(wanted.step.end);
    double fraction = 0.0;
    for (int piece = 0;; ++piece) {
      RETURN_IF_ERROR(NextOf(compensated, wanted, found));
      if (found->step.kind != StepKind::kMove) return Mismatch(wanted, *found, "is not such a move");
      ++report_.pieces;
      if (!is_known) return absl::OkStatus();
      if (piece >= kMaxPiecesPerMove || !IsKnown(found->step.end))
        return Mismatch(wanted, *found, "does not reach the same position");
      const bool is_last = Reaches(wanted.step, found->step);
      const Positions to = PositionsOf(found->step.end);
      const double next = is_last ? 1.0 : FractionOf(nominal_from, nominal_to, to);
      if (!is_last && !(has_path && next > fraction && next < 1.0))
        return Mismatch(wanted, *found, "does not go to the same position");
      if (has_path && IsKnown(found->step.start)) {
        LookInside(wanted, nominal_from, nominal_to, PositionsOf(found->step.start), to, fraction, next);
      }
      fraction = next;
      if (!is_last) continue;
      const Eigen::Vector3d wanted_mm = Nominal(nominal_to);
      report_.end_before.Add((Actual(nominal_to, wanted.step) - wanted_mm).norm());
      const double after_mm = (Actual(to, wanted.step) - wanted_mm).norm();
      report_.end_after.Add(after_mm);
      AddWorst(after_mm, wanted.line);
      return absl::OkStatus();
    }
  }

  const machine::Machine& machine_;
  const machine::ErrorModel& errors_;
  const VerifyOptions& options_;
  VerifyReport report_;
  double worst_mm_ = -1.0;
};

}  // namespace

absl::StatusOr<VerifyReport> Verify(const ByteReader& original, const ByteReader& compensated,
                                    const machine::Machine& machine, const machine::ErrorModel& errors,
                                    const VerifyOptions& options) {
  RETURN_IF_ERROR(machine::Validate(machine));
  RETURN_IF_ERROR(Validate(options.reading));
  ASSIGN_OR_RETURN(Interpreter of_original, Interpreter::Create(machine, options.reading));
  ASSIGN_OR_RETURN(Interpreter of_compensated, Interpreter::Create(machine, options.reading));
  MoveReader original_moves(original, std::move(of_original));
  MoveReader compensated_moves(compensated, std::move(of_compensated));
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

std::string ToJson(const VerifyReport& report) {
  const auto spread = [](const Spread& value) {
    return nlohmann::ordered_json{
        {"max_um", value.max_mm * base::kUmPerMm}, {"rms_um", value.rms_mm() * base::kUmPerMm}, {"count", value.count}};
  };
  nlohmann::ordered_json json;
  json["moves"] = report.moves;
  json["pieces"] = report.pieces;
  json["moves_unknown"] = report.moves_unknown;
  json["blocks_unsupported"] = report.blocks_unsupported;
  json["end"] = {{"before", spread(report.end_before)}, {"after", spread(report.end_after)}};
  json["path"] = {{"before", spread(report.path_before)}, {"after", spread(report.path_after)}};
  json["worst_line"] = report.worst_line;
  return json.dump(1) + "\n";
}

}  // namespace axiscal::nc
