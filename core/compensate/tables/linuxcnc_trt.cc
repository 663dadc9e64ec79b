// LinuxCNC's trtfuncs.c (xyzac-trt-kins, xyzbc-trt-kins): a tilting table A or B that carries a rotary table C. HAL
// pins say where the axes are, in the coordinates of the linear axes:
//   xyzac: P = Rx(a) (Rz(c) (p - rot) - d) + d + rot,  d = (0, y-offset, z-offset + tool-offset)
//   xyzbc: P = Ry(b) (Rz(c) (p - rot) - d) + d + rot,  d = (x-offset, 0, z-offset + tool-offset)
// so C passes through rot and the tilting axis through rot + d. Axis positions are zero with the tool point at home, so
// a point of the machine frame stands at point - tool point.
#include <algorithm>
#include <cmath>
#include <map>

#include "core/compensate/tables/format.h"
#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

using compensate::Table;
using machine::Machine;

constexpr int kDecimals = 6;

struct Trt {
  const char* name;    // of the HAL component
  const char* tilt;    // the tilting axis
  int across;          // coordinate of the offset between the axes: y of A, x of B
  const char* offset;  // its pin
};
constexpr Trt kXyzac = {"xyzac-trt-kins", "A", 1, "y-offset"};
constexpr Trt kXyzbc = {"xyzbc-trt-kins", "B", 0, "x-offset"};

bool Is(const Eigen::Vector3d& direction, int coordinate, double sign) {
  return (direction - sign * Eigen::Vector3d::Unit(coordinate)).norm() < 1e-9;
}

// X, Y, Z take the tool to +X, +Y, +Z of the table; the tilting axis and C turn the table right-handed, in this order.
absl::Status RequireTrt(const Machine& machine, const Trt& trt) {
  const auto refuse = [&](const std::string& rule) {
    return absl::FailedPreconditionError(absl::StrCat("machine '", machine.id, "' is none for ", trt.name, ": ", rule));
  };
  const int tilt = machine::FindAxis(machine, trt.tilt), c = machine::FindAxis(machine, "C");
  if (machine.axis_count() != 5 || tilt < 0 || c < 0)
    return refuse(absl::StrCat("it must have X, Y, Z, ", trt.tilt, " and C"));
  const std::vector<int>& work = machine.work_branch;
  if (work.size() < 2 || work.back() != c || work[work.size() - 2] != tilt)
    return refuse(absl::StrCat("the table must turn about ", trt.tilt, " and then C, with nothing between and behind"));
  if (!Is(machine.axes[tilt].direction, trt.across == 1 ? 0 : 1, 1.0) || !Is(machine.axes[c].direction, 2, 1.0))
    return refuse(absl::StrCat(trt.tilt, " and C must turn the table right-handed for positive commands"));
  const char* const names[] = {"X", "Y", "Z"};
  for (int k = 0; k < 3; ++k) {
    const int axis = machine::FindAxis(machine, names[k]);
    const bool carries_tool = axis >= 0 && std::find(machine.tool_branch.begin(), machine.tool_branch.end(), axis) !=
                                               machine.tool_branch.end();
    if (axis < 0 || !Is(machine.axes[axis].direction, k, carries_tool ? 1.0 : -1.0))
      return refuse(absl::StrCat(names[k], "+ must take the tool to +", names[k]));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> Write(const Trt& trt, const Machine& machine, const Content& content) {
  RETURN_IF_ERROR(RequireTrt(machine, trt));
  const Eigen::Vector3d tilt = content.table.points_mm.at(machine::FindAxis(machine, trt.tilt)) - content.tool_tip_mm;
  const Eigen::Vector3d c = content.table.points_mm.at(machine::FindAxis(machine, "C")) - content.tool_tip_mm;
  std::string text;
  for (const std::string& note : content.notes) absl::StrAppend(&text, "# ", note, "\n");
  absl::StrAppend(&text,
                  "# HAL: load after the kinematics module; tool-offset is the tool's length beyond the tool point "
                  "below\n# tool point at home: ",
                  Fixed(content.tool_tip_mm.x(), kDecimals), " ", Fixed(content.tool_tip_mm.y(), kDecimals), " ",
                  Fixed(content.tool_tip_mm.z(), kDecimals), "\n");
  const auto pin = [&](const char* name, double value) {
    absl::StrAppend(&text, "setp ", trt.name, ".", name, " ", Fixed(value, kDecimals), "\n");
  };
  pin("x-rot-point", c.x());
  pin("y-rot-point", c.y());
  pin("z-rot-point", tilt.z());
  pin(trt.offset, tilt[trt.across] - c[trt.across]);
  pin("z-offset", 0.0);
  return text;
}

absl::StatusOr<Table> Read(const Trt& trt, const Machine& machine, const std::string& text) {
  RETURN_IF_ERROR(RequireTrt(machine, trt));
  const std::string prefix = std::string(trt.name) + ".", tip_note = "# tool point at home: ";
  std::map<std::string, double> pins;
  std::vector<double> tip;
  const std::vector<std::string> lines = Lines(text);
  for (size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].rfind(tip_note, 0) == 0) {
      for (const std::string& word : Words(lines[i].substr(tip_note.size()))) {
        const std::optional<double> number = ParseFixed(word);
        if (!number) return BadLine(i + 1, word, "a decimal number");
        tip.push_back(*number);
      }
    }
    if (lines[i].empty() || lines[i][0] == '#') continue;
    const std::vector<std::string> words = Words(lines[i]);
    const std::optional<double> value = words.size() == 3 ? ParseFixed(words[2]) : std::nullopt;
    if (!value || words[0] != "setp" || words[1].rfind(prefix, 0) != 0)
      return BadLine(i + 1, lines[i], "setp " + prefix + "PIN NUMBER");
    const std::string pin = words[1].substr(prefix.size());
    if (pin != "x-rot-point" && pin != "y-rot-point" && pin != "z-rot-point" && pin != "z-offset" && pin != trt.offset)
      return BadLine(i + 1, words[1], absl::StrCat("x-, y-, z-rot-point, ", trt.offset, " or z-offset"));
    if (!pins.emplace(pin, *value).second) return BadLine(i + 1, words[1], "every pin once");
  }
  if (pins.size() != 5 || tip.size() != 3)
    return absl::InvalidArgumentError(
        absl::StrCat("expected five pins of ", trt.name, " and the note of the tool point"));
  Table table;
  table.kind = compensate::TableKind::kPoints;
  table.points_mm.assign(static_cast<size_t>(machine.axis_count()), Eigen::Vector3d::Zero());
  const Eigen::Vector3d tip_mm(tip[0], tip[1], tip[2]);
  const Eigen::Vector3d rot(pins["x-rot-point"], pins["y-rot-point"], pins["z-rot-point"]);
  Eigen::Vector3d offset(0, 0, pins["z-offset"]);
  offset[trt.across] = pins[trt.offset];
  table.points_mm[static_cast<size_t>(machine::FindAxis(machine, "C"))] = tip_mm + rot;
  table.points_mm[static_cast<size_t>(machine::FindAxis(machine, trt.tilt))] = tip_mm + rot + offset;
  return table;
}

Format TrtFormat(const Trt& trt) {
  Format format;
  format.name = std::string("linuxcnc-") + std::string(trt.name, 5);
  format.title = absl::StrCat("LinuxCNC pins of ", trt.name, ": where ", trt.tilt, " and C are");
  format.values = "positions of the axes, mm, in the coordinates of X, Y, Z";
  format.layout = Layout::kPoints;
  format.limits.value_step_mm = 1e-5;
  format.cannot_carry = {"tilts of the rotary axes and squareness", "errors that vary with a position",
                         "what moves all axes alike (work offset)"};
  return format;
}

}  // namespace

Format LinuxcncXyzacFormat() {
  Format format = TrtFormat(kXyzac);
  format.write = [](const Machine& machine, const Content& content) { return Write(kXyzac, machine, content); };
  format.read = [](const Machine& machine, const std::string& text) { return Read(kXyzac, machine, text); };
  return format;
}

Format LinuxcncXyzbcFormat() {
  Format format = TrtFormat(kXyzbc);
  format.write = [](const Machine& machine, const Content& content) { return Write(kXyzbc, machine, content); };
  format.read = [](const Machine& machine, const std::string& text) { return Read(kXyzbc, machine, text); };
  return format;
}

}  // namespace axiscal::tables
