// The keys under which a cutter and its run stand in a `tool-curve` session's header and in a cutter.json: the same in
// both, lengths in mm, angles in deg.
//   tool_radius_mm insert_radius_mm inserts radial_angle_deg axial_angle_deg offset_d_mm beam_radius_mm spindle_rpm
//   feed_mm_min; optional theta_t_deg, clearance_deg, insert_thickness_mm, start_height_mm (1 where nothing is stated),
//   insert_angles_deg (of uneven spacing), wear_mm (cutter.json only)
#ifndef AXISCAL_CORE_TOOLSETTER_CUTTER_KEYS_H_
#define AXISCAL_CORE_TOOLSETTER_CUTTER_KEYS_H_

#include <string>
#include <vector>

#include "core/session/session.h"
#include "core/toolsetter/cutter.h"

namespace axiscal::toolsetter {

struct CutterDescription {
  Cutter cutter;
  CutterRun run;
  std::vector<double> wear_mm;  // all 0 where nothing is stated
};

// A cutter.json: `id` and `note` are texts. Fields and values are checked one by one; whether they make a cutter that
// reaches the beam is for Validate. INVALID_ARGUMENT naming field, value and rule.
absl::StatusOr<CutterDescription> ReadCutterJson(const std::string& text);
// NOT_FOUND when there is no such file.
absl::StatusOr<CutterDescription> ReadCutterFile(const std::string& path);

// The header's lines of a cutter.json, numbers as the file writes them; `wear_mm` and texts have none. INVALID_ARGUMENT
// as ParseStrictJson.
absl::StatusOr<std::string> HeaderOfCutter(const std::string& cutter_json);

// From a session's header.
absl::StatusOr<CutterDescription> ReadCutterKeys(const session::Session& session);

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_CUTTER_KEYS_H_
