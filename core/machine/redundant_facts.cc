#include "core/machine/redundant_facts.h"

#include <cmath>

#include "core/base/error_detail.h"

namespace axiscal::machine {
namespace {

// "XYZB" of axes in this order.
std::string Names(const Machine& machine, const std::vector<int>& axes, const char* between) {
  std::string names;
  for (const int axis : axes) absl::StrAppend(&names, names.empty() ? "" : between, machine.axes[axis].name);
  return names;
}

// Without what says nothing about the order.
std::string Plain(const std::string& structure) {
  std::string plain;
  int depth = 0;
  for (const char c : structure) {
    depth += c == '(' ? 1 : 0;
    if (depth == 0 && c != '\'' && c != ' ') plain += c;
    depth -= c == ')' ? 1 : 0;
  }
  return plain;
}

}  // namespace

absl::Status CheckToolTip(const Machine& machine, const Eigen::Vector3d& tool_tip_mm) {
  constexpr double kAboutTheTool = 0.999;    // cosine: such an axis turns the tool about itself
  const double kOpposite = std::sqrt(0.75);  // cosine of 30 deg
  constexpr double kOnAxisMm = 1e-6;
  for (auto name = machine.tool_branch.rbegin(); name != machine.tool_branch.rend(); ++name) {
    const Axis& axis = machine.axes[*name];
    if (axis.kind != AxisKind::kRotary || std::abs(axis.direction.dot(machine.tool_direction)) > kAboutTheTool)
      continue;
    const Eigen::Vector3d from_point_mm = tool_tip_mm - axis.point_mm;
    const double along_mm = from_point_mm.dot(machine.tool_direction), away_mm = from_point_mm.norm();
    if (away_mm < kOnAxisMm || along_mm > -kOpposite * away_mm) return absl::OkStatus();
    const Eigen::Vector3d& d = machine.tool_direction;
    const std::string text = absl::StrFormat(
        "tool tip %g %g %g: stands %.4g mm behind axis %s, on the other side than tool_direction %g %g %g of machine "
        "%s "
        "points to, expected a tip on that side (is a sign wrong?)",
        tool_tip_mm.x(), tool_tip_mm.y(), tool_tip_mm.z(), -along_mm, axis.name, d.x(), d.y(), d.z(), machine.id);
    return base::Error(absl::StatusCode::kInvalidArgument, text, {"TOOL_TIP_INVALID", {}});
  }
  return absl::OkStatus();
}

absl::Status CheckStructure(const Machine& machine) {
  std::string plain = Plain(machine.structure);
  if (!plain.starts_with("w-") || !plain.ends_with("-t")) return absl::OkStatus();
  plain = plain.substr(2, plain.size() - 4);
  const size_t bed = plain.find('b');
  if (bed == std::string::npos) return absl::OkStatus();
  const std::vector<int> from_work(machine.work_branch.rbegin(), machine.work_branch.rend());
  const std::string branches = Names(machine, from_work, "") + "b" + Names(machine, machine.tool_branch, "");
  // Only axes that both have: a description may leave axes out.
  const auto shared = [](const std::string& of, const std::string& other) {
    std::string kept;
    for (const char c : of) {
      if (other.find(c) != std::string::npos) kept += c;
    }
    return kept;
  };
  if (shared(plain, branches) == shared(branches, plain)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "machine ", machine.id, ": structure '", machine.structure, "' contradicts the branches (tool_branch ",
      Names(machine, machine.tool_branch, " "), ", work_branch ", Names(machine, machine.work_branch, " "),
      ", both from the bed outwards), which read w-", branches, "-t, expected the same order in both"));
}

}  // namespace axiscal::machine
