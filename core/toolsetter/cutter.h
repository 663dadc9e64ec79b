// A mill with round inserts and how it runs when a tool setter measures it (Fang 2022, ch. 3). Tool frame: x radial, z
// up, origin O_t at the lowest nominal point of the inserts on the axis.
//   cutting edge of an insert at spindle angle 0:  P(x) = c + u cos x + w sin x,
//   c = (r, 0, 0) + M (-R, 0, R),  u = M (R, 0, 0),  w = M (0, 0, -R),
//   M = [[cr, sr ca, sr sa], [-sr, cr ca, cr sa], [0, -sa, ca]],  cr = cos theta_r, sr = sin theta_r, ca = cos theta_a
// Radial and axial angle enter signed: -8 and -5 deg of the published cutters. The edge is seen along X, the tool's
// axis at y = -offset (3.18 with its sign put right).
#ifndef AXISCAL_CORE_TOOLSETTER_CUTTER_H_
#define AXISCAL_CORE_TOOLSETTER_CUTTER_H_

#include <numbers>
#include <string>
#include <vector>

#include "core/base/status.h"

namespace axiscal::toolsetter {

inline constexpr double kTurn = 2.0 * std::numbers::pi;  // rad

struct Cutter {
  std::string id;
  double tool_radius_mm = 0.0;               // r: of the circle on which the inserts' outermost points stand
  double insert_radius_mm = 0.0;             // R
  int inserts = 0;                           // n
  double radial_rad = 0.0, axial_rad = 0.0;  // theta_r, theta_a
  double theta_t_rad = 0.0;                  // of insert 1 in the spindle
  double clearance_rad = 0.0;                // tau of the flank
  double insert_thickness_mm = 0.0;          // d_i; with the clearance only to see that the flank stays clear
  std::vector<double> insert_angles_rad;     // of each insert after insert 1; empty: evenly spaced

  // Of insert k from 0, after insert 1.
  double InsertAngle(int k) const;
};

// How the length is measured.
struct CutterRun {
  double offset_mm = 0.0;        // d
  double beam_radius_mm = 0.2;   // R_l
  double spindle_rpm = 0.0;      // N > 0: counter-clockwise seen from above
  double feed_mm_min = 0.0;      // v, downwards
  double start_height_mm = 0.0;  // h: of O_t above the beam where the spindle angle is that of the start

  double feed_per_turn_mm() const { return feed_mm_min / spindle_rpm; }
  // f = v / (n N): what the tool sinks from one insert to the next.
  double feed_per_insert_mm(const Cutter& cutter) const { return feed_per_turn_mm() / cutter.inserts; }
};

inline constexpr double kMaxFeedMmMin = 1e5;  // of a run: more than machines have

// INVALID_ARGUMENT naming field, value and rule: numbers out of range, several inserts at one angle; with the run also
// inserts that never reach the beam, a flank that stands below the edge, a start in the beam.
absl::Status Validate(const Cutter& cutter);
absl::Status Validate(const Cutter& cutter, const CutterRun& run);
// One wear per insert, 0 or more and less than the insert's radius.
absl::Status ValidateWear(const Cutter& cutter, const std::vector<double>& wear_mm);

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_CUTTER_H_
