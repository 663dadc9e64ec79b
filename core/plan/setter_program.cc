#include "core/plan/setter_program.h"

#include <algorithm>
#include <cmath>

#include "core/session/text.h"

namespace axiscal::plan {
namespace {

absl::Status Validate(const SetterOptions& options) {
  const struct {
    const char* name;
    double value;
    bool may_be_zero;
  } fields[] = {{"clearance_mm", options.clearance_mm, false},
                {"overtravel_mm", options.overtravel_mm, false},
                {"retract_mm", options.retract_mm, true},
                {"feed_mm_min", options.feed_mm_min, false}};
  for (const auto& field : fields) {
    constexpr double kMost = 1e4;
    if (!(field.may_be_zero ? field.value >= 0.0 : field.value > 0.0) || !(field.value <= kMost))
      return absl::InvalidArgumentError(
          absl::StrFormat("%s = %g, expected above 0 to %g", field.name, field.value, kMost));
  }
  return absl::OkStatus();
}

// The linear axis along the tool, and the sense of its command that takes the tool up.
struct FeedAxis {
  int axis = 0;
  double up = 1.0;
};

absl::StatusOr<FeedAxis> FeedAxisOf(const machine::Machine& machine) {
  for (int i = 0; i < machine.axis_count(); ++i) {
    const machine::Axis& axis = machine.axes[i];
    constexpr double kAlong = 0.999;
    const double along = -axis.direction.dot(machine.tool_direction);
    if (axis.kind != machine::AxisKind::kLinear || std::abs(along) < kAlong) continue;
    const bool is_of_table =
        std::find(machine.work_branch.begin(), machine.work_branch.end(), i) != machine.work_branch.end();
    return FeedAxis{i, (is_of_table ? -1.0 : 1.0) * (along > 0.0 ? 1.0 : -1.0)};
  }
  return absl::FailedPreconditionError("machine " + machine.id +
                                       " has no linear axis along its tool, which a tool setter is fed onto with");
}

absl::StatusOr<std::vector<double>> NumbersOf(const session::Session& session, const std::string& key, size_t count) {
  std::vector<double> numbers;
  if (!session::ParseNumbers(session::FindHeader(session, key).value_or(""), &numbers) || numbers.size() != count)
    return absl::InvalidArgumentError(absl::StrFormat("header '%s': expected %u numbers", key, count));
  return numbers;
}

// One line of the session: the spindle's angle, deg, and how far the trigger is expected above the beam's position.
struct Feed {
  std::string rod;  // that must be in the spindle; empty: the mill
  double angle_deg = 0.0, from_mm = 0.0, to_mm = 0.0, feed_mm_min = 0.0;
};

}  // namespace

absl::StatusOr<std::string> SetterBlocks(const machine::Machine& machine, const session::Session& session,
                                         const SetterOptions& options, const ProbeDialect& dialect,
                                         const SpindleWords& words) {
  RETURN_IF_ERROR(Validate(options));
  ASSIGN_OR_RETURN(const FeedAxis along, FeedAxisOf(machine));
  for (const machine::Axis& axis : machine.axes) {
    if (axis.kind == machine::AxisKind::kLinear && options.beam_at_mm.count(axis.name) == 0)
      return absl::InvalidArgumentError("the position of " + axis.name +
                                        " over the beam is not stated, expected one of every linear axis");
  }
  const std::string instrument = session::FindHeader(session, "instrument").value_or("");
  std::vector<Feed> feeds;
  double spindle_rpm = 0.0;
  if (instrument == "tool-setter") {
    const session::Column* const rods = session::FindColumn(session, "rod");
    if (rods == nullptr) return absl::InvalidArgumentError("the session has no column rod");
    for (const std::string& rod : rods->texts) {
      ASSIGN_OR_RETURN(const std::vector<double> numbers, NumbersOf(session, "rod " + rod, 6));
      const double length_mm = numbers[4], holder_deg = numbers[5];
      feeds.push_back({rod.substr(0, rod.find('@')), holder_deg, length_mm + options.clearance_mm,
                       length_mm - options.overtravel_mm, options.feed_mm_min});
    }
  } else if (instrument == "tool-curve") {
    const session::Column* const starts = session::FindColumn(session, "start_deg");
    if (starts == nullptr) return absl::InvalidArgumentError("the session has no column start_deg");
    ASSIGN_OR_RETURN(const std::vector<double> rpm, NumbersOf(session, "spindle_rpm", 1));
    ASSIGN_OR_RETURN(const std::vector<double> feed, NumbersOf(session, "feed_mm_min", 1));
    std::vector<double> height = {1.0};  // as tool-curve sessions are read
    if (session::FindHeader(session, "start_height_mm")) {
      ASSIGN_OR_RETURN(height, NumbersOf(session, "start_height_mm", 1));
    }
    spindle_rpm = rpm[0];
    for (const double start_deg : starts->values)
      feeds.push_back({"", start_deg, height[0], -options.overtravel_mm, feed[0]});
  } else {
    return absl::InvalidArgumentError("instrument '" + instrument + "', expected tool-setter or tool-curve");
  }
  if (feeds.empty()) return absl::InvalidArgumentError("the session plans no reading");

  const machine::Axis& axis = machine.axes[along.axis];
  const double beam_mm = options.beam_at_mm.at(axis.name);
  double top_mm = 0.0;
  for (const Feed& feed : feeds) top_mm = std::max(top_mm, feed.from_mm);
  top_mm += options.retract_mm;
  for (const double up_mm : {top_mm, std::min_element(feeds.begin(), feeds.end(), [](const Feed&a, const Feed&b) {
                                       return a.to_mm < b.to_mm;
                                     })->to_mm}) {
    const double position_mm = beam_mm + along.up * up_mm;
    if ((axis.min_position && position_mm < *axis.min_position) ||
        (axis.max_position && position_mm > *axis.max_position))
      return absl::FailedPreconditionError(
          absl::StrFormat("%s would go to %.4f mm, beyond its travel", axis.name, position_mm));
  }
  std::string text;
  const auto move = [&](const std::string& code, double up_mm, const std::string& rest) {
    absl::StrAppendFormat(&text, "%s %s%.4f%s\n", code, axis.name, beam_mm + along.up * up_mm + 0.0, rest);
  };
  // Up first, then over the beam.
  move("G00", top_mm, "");
  text += "G00";
  for (int i = 0; i < machine.axis_count(); ++i) {
    const machine::Axis& other = machine.axes[i];
    if (i == along.axis) continue;
    absl::StrAppendFormat(&text, " %s%.4f", other.name,
                          other.kind == machine::AxisKind::kLinear ? options.beam_at_mm.at(other.name) : 0.0);
  }
  text += "\n";
  const std::string print = PrintOf(machine, dialect);
  std::string in_spindle;
  for (const Feed& feed : feeds) {
    if (!feed.rod.empty() && feed.rod != in_spindle) {
      absl::StrAppend(&text, words.stop_for_a_person, "\n");
      in_spindle = feed.rod;
    }
    absl::StrAppendFormat(&text, "%s%.4f\n", words.orient, feed.angle_deg);
    move("G00", feed.from_mm, "");
    if (spindle_rpm != 0.0)
      absl::StrAppendFormat(&text, "S%.4g %s\n", std::abs(spindle_rpm), spindle_rpm > 0.0 ? "M04" : "M03");
    move(dialect.skip, feed.to_mm, absl::StrFormat(" F%.4f", feed.feed_mm_min));
    text += print;
    if (spindle_rpm != 0.0) text += "M05\n";
    move("G00", top_mm, "");
  }
  return text;
}

}  // namespace axiscal::plan
