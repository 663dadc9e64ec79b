#include "core/plan/probe_writer.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/instruments/centres/centres_model.h"

namespace axiscal::plan {
namespace {

// The control counts its axes X, Y, Z, then the others (Yao 2022, Fig. 5.12: B is #5004, C #5005), whatever the order
// in which the machine's chain has them.
std::vector<std::string> ControlOrder(const machine::Machine& machine) {
  std::vector<std::string> names;
  for (const machine::Axis& axis : machine.axes) names.push_back(axis.name);
  const auto rank = [&](const std::string& name) {
    if (name == "X" || name == "Y" || name == "Z") return 0;
    return machine.axes[machine::FindAxis(machine, name)].kind == machine::AxisKind::kRotary ? 1 : 2;
  };
  std::sort(names.begin(), names.end(),
            [&](const std::string& a, const std::string& b) { return rank(a) != rank(b) ? rank(a) < rank(b) : a < b; });
  return names;
}

}  // namespace

std::string PrintOf(const machine::Machine& machine, const ProbeDialect& dialect) {
  if (dialect.log == TouchLog::kOfTheControl) return "";
  if (dialect.log == TouchLog::kSinumerik) {
    std::string form, values;
    for (const std::string& name : ControlOrder(machine)) {
      absl::StrAppend(&form, form.empty() ? "" : " ", name, "%.4F");
      absl::StrAppend(&values, ",$AA_MM[", name, "]");
    }
    return absl::StrCat("STOPRE\nIF $AC_MEA[1]==0 GOTOF NO_TOUCH\nWRITE(ERR,LOG,SPRINT(\"", form, "\"", values, "))\n");
  }
  int number = 5001;
  std::string prints;
  for (const std::string& name : ControlOrder(machine))
    absl::StrAppend(&prints, prints.empty() ? "" : "*", name, "#", number++, "[4 4]");
  return "DPRNT[" + prints + "]\n";
}

ProbeWriter::ProbeWriter(const machine::Machine& machine, const Eigen::Vector3d& tip_mm, const ProbeDialect& dialect,
                         double feed_mm_min)
    : machine_(machine),
      tip_mm_(tip_mm),
      dialect_(dialect),
      feed_(absl::StrFormat(" F%.4f", feed_mm_min)),
      print_(PrintOf(machine, dialect)) {}

absl::Status ProbeWriter::Move(const std::vector<double>& positions, const Eigen::Vector3d& target_mm) {
  return Block("G00", positions, target_mm, "");
}

absl::Status ProbeWriter::Touch(const std::vector<double>& positions, const Eigen::Vector3d& target_mm) {
  RETURN_IF_ERROR(Block(dialect_.skip, positions, target_mm, feed_));
  text_ += print_;
  return absl::OkStatus();
}

absl::Status ProbeWriter::Block(const std::string& code, const std::vector<double>& positions,
                                const Eigen::Vector3d& target_mm, const std::string& feed) {
  std::vector<double> commands = positions;
  RETURN_IF_ERROR(centres::SolveNominalCommands(machine_, tip_mm_, target_mm, commands.data()));
  text_ += code;
  for (int i = 0; i < machine_.axis_count(); ++i) {
    const machine::Axis& axis = machine_.axes[i];
    const bool is_rotary = axis.kind == machine::AxisKind::kRotary;
    constexpr double kTolerance = 1e-6;
    if ((axis.min_position && commands[i] < *axis.min_position - kTolerance) ||
        (axis.max_position && commands[i] > *axis.max_position + kTolerance)) {
      return absl::FailedPreconditionError("a touch lies beyond the travel of " + axis.name);
    }
    const double rounded = std::round(commands[i] * (is_rotary ? base::kDegPerRad : 1.0) * 1e4) / 1e4 + 0.0;
    text_ += absl::StrFormat(" %s%.4f", axis.name, rounded);
  }
  text_ += feed + "\n";
  return absl::OkStatus();
}

}  // namespace axiscal::plan
