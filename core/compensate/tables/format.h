// The registry of table formats: what a controller's table holds, how many points of which resolution, how it is
// written and read. A new format: docs/architecture.md, "A table format".
#ifndef AXISCAL_CORE_COMPENSATE_TABLES_FORMAT_H_
#define AXISCAL_CORE_COMPENSATE_TABLES_FORMAT_H_

#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/compensate/table.h"

namespace axiscal::tables {

// Which functions a format's tables hold.
enum class Layout {
  kOwnAxis,     // the correction of an axis over its own position
  kAnyAxis,     // the correction of an axis over the position of any axis
  kGrid,        // the corrections of the linear axes over the positions of three of them
  kComponents,  // ISO error components over axis positions
  kPoints,      // points on rotary axes
};

struct Limits {
  int max_points = 0;  // along one axis; 0: none, the format has no nodes
  int min_points = 2;
  bool equal_steps = false;         // nodes at equal distances
  bool from_reference = false;      // one of them at the reference position
  int most_increments = 0;          // values are increments of at most this many steps; 0: they are no increments
  bool power_of_two_steps = false;  // of the position step
  bool whole_axes = false;          // kComponents: all six of an axis, over its own position only, and no T and W
  bool by_sense = false;            // values by sense of motion
  bool one_axis = false;            // a file holds one axis
  bool holds_rotary = true;         // corrections of rotary axes
  bool is_resolution_free = false;  // the controller's own setting: --resolution may change it
  // Least steps of values and positions in the file's units (mm, deg, or as the format says), and the largest value.
  double value_step_mm = 1e-5, value_step_deg = 1e-6;
  double position_step_mm = 1e-4, position_step_deg = 1e-4;
  double largest_mm = 0.0, largest_deg = 0.0;  // 0: no limit
};

// A table and what stands beside it in its file.
struct Content {
  compensate::Table table;
  compensate::Pose reference;                             // where corrections are zero
  Eigen::Vector3d tool_tip_mm = Eigen::Vector3d::Zero();  // at home, machine frame
  // Per block the least step of its values, mm or rad: the controller's, or a multiple that the values need.
  std::vector<double> value_steps;
  // Per axis of the machine the controller's least step, mm or rad.
  std::vector<double> least_steps;
  // For people: one line each. The writer puts them where the controller does not read.
  std::vector<std::string> notes;
};

struct Format {
  std::string name;    // "linuxcnc-comp"
  std::string title;   // "LinuxCNC axis compensation (COMP_FILE)"
  std::string values;  // unit and sign: "corrections, added to the command; mm, deg"
  Layout layout = Layout::kOwnAxis;
  Limits limits;
  // What no table of this format can carry, whatever the machine.
  std::vector<std::string> cannot_carry;
  // What was assumed because no source was at hand, or not tried on a control; "" where the control's own source was
  // read. Every file says so.
  std::string assumed;
  // Chooses value_steps where values must be coarser than the least step, or says what does not fit. May be null.
  absl::Status (*fit)(const machine::Machine& machine, Content* content) = nullptr;
  // FAILED_PRECONDITION where the format cannot describe this machine.
  absl::StatusOr<std::string> (*write)(const machine::Machine& machine, const Content& content) = nullptr;
  // INVALID_ARGUMENT with line, value and what was expected.
  absl::StatusOr<compensate::Table> (*read)(const machine::Machine& machine, const std::string& text) = nullptr;
};

// In the order of the list that users see.
const std::vector<Format>& Formats();
// INVALID_ARGUMENT naming the formats that there are.
absl::StatusOr<const Format*> FindFormat(const std::string& name);

// "256 points", "128 points at equal steps, by sense of motion": for the list.
std::string LimitsText(const Format& format);
// The list as JSON: an array of {name, title, values, limits ...}.
std::string FormatsJson();

// One per file in this folder.
Format GeneralFormat();
Format LinuxcncCompFormat();
Format SiemensEecFormat();
Format SiemensCecFormat();
Format FanucPitchFormat();
Format FanucGridFormat();
Format HeidenhainComFormat();
Format HeidenhainKinematicsFormat();
Format IsgVolumetricFormat();
Format LinuxcncXyzacFormat();
Format LinuxcncXyzbcFormat();

}  // namespace axiscal::tables

#endif  // AXISCAL_CORE_COMPENSATE_TABLES_FORMAT_H_
