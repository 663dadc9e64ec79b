// The twelve ball-bar patterns of Yao 2022 (Table 2.5) on a multi-tasking machine w-C'bZYXB: axis commands (mm, rad)
// that keep the nominal bar at its length while B or C turns. X, Y, Z command the B pivot, wherever it stands at home;
// the tool points to -Z at B = 0. The table ball stands on C's line for the tests of B and Rc beside it (+x) for those
// of C, at the machine's height Zc; the tool ball a distance R_B below the pivot.
#ifndef AXISCAL_CORE_INSTRUMENTS_BALLBAR_BALLBAR_PLAN_H_
#define AXISCAL_CORE_INSTRUMENTS_BALLBAR_BALLBAR_PLAN_H_

#include <string>
#include <vector>

#include "core/machine/machine.h"
#include "core/session/session.h"

namespace axiscal::ballbar {

enum class Pattern { kBX, kBY, kBZ, kBAxial, kBRadial, kBTangential, kCR, kCT, kCA, kCX, kCY, kCZ };

const std::vector<std::pair<std::string, Pattern>>& Patterns();
inline bool TurnsB(Pattern pattern) { return pattern <= Pattern::kBTangential; }

struct PatternOptions {
  double bar_length_mm = 100.0;   // L
  double tool_length_mm = 356.4;  // R_B: B pivot to the tool ball
  double ball_height_mm = 65.5;   // Zc, machine frame
  double ball_radius_mm = 50.0;   // Rc: distance of the table ball from C
  double step_deg = 1.0;
  bool both_senses = true;  // there and back: backlash shows only so
  double sigma_um = 0.3;
  double seconds_per_reading = 0.25;
  double start_s = 0.0;
};

// A session without its reading column: header and axis columns in time order. B turns 0..90 degrees, C 0..360.
// FAILED_PRECONDITION when the machine has not the axes X Y Z B C of this structure; INVALID_ARGUMENT naming a bad
// option.
absl::StatusOr<session::Session> PlanPattern(const machine::Machine& machine, const std::string& name, Pattern pattern,
                                             const PatternOptions& options);

}  // namespace axiscal::ballbar

#endif  // AXISCAL_CORE_INSTRUMENTS_BALLBAR_BALLBAR_PLAN_H_
