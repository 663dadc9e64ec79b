// What a machine's earlier sessions tell a planner: where its axes have been, which instruments, tools and balls are at
// hand, and the time of the sessions' clock.
#ifndef AXISCAL_CORE_PLAN_SITUATION_H_
#define AXISCAL_CORE_PLAN_SITUATION_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/instruments/run.h"

namespace axiscal::plan {

struct Range {
  double lowest = 0.0, highest = 0.0;  // mm or rad
};

// One kind of instrument as the sessions used it, or common values where they did not.
struct InstrumentUse {
  bool is_used = false;
  double sigma_mm = 0.0;  // the best stated repeatability of one reading
  double seconds_per_reading = 0.0;
};

struct Situation {
  const machine::Machine* machine = nullptr;
  std::vector<const instruments::MeasuringRun*> runs;
  std::vector<Range> ranges;              // per axis, of all sessions; axes that stood still have lowest = highest
  std::vector<Eigen::Vector3d> tips_mm;   // tool points in use, shortest tool first, machine frame at home
  std::vector<Eigen::Vector3d> balls_mm;  // places of the table ball in use, machine frame at home
  std::vector<double> bars_mm;            // bar lengths in use, shortest first
  double stylus_radius_mm = 3.0, sphere_radius_mm = 12.5;  // of the touch probe, of a sphere on the table
  double start_s = 0.0;                                    // when the next session can start
  bool has_time = false, has_temperature = false;
  double temperature_celsius = 20.0;  // mean of the sessions
  InstrumentUse ballbar, rtest;

  bool Turns(int axis) const { return ranges[axis].highest - ranges[axis].lowest > 1e-3; }
};

// `runs` must outlive the result. Never fails: what no session tells gets a common value (a tool of 150 mm below the
// pivot, a ball at the table's axis, a bar of 100 mm).
Situation SituationOf(const machine::Machine& machine, const std::vector<instruments::MeasuringRun>& runs);

// What is mounted, for machines of which no session tells it.
struct Mounted {
  std::vector<Eigen::Vector3d> tips_mm, balls_mm;  // at home, machine frame; empty: common values
  std::vector<double> bars_mm;
  double stylus_radius_mm = 3.0, sphere_radius_mm = 12.5;
};

// How far a rotary axis may be taken on a machine that was never measured. A table that spins about the tool's
// direction, or whose stated travel is a whole turn, turns round; all others tilt: heads, and tables that carry or lie
// across.
enum class Turning { kRound, kTilts };
Turning TurningOf(const machine::Machine& machine, int axis);

// The tilting axes whose travel machine.json does not state: nobody should command them anywhere before it does.
std::vector<std::string> TiltingWithoutTravel(const machine::Machine& machine);

// A machine that was never measured: an axis that turns round makes one turn, within its travel where it states one;
// one that tilts goes as far as its travel allows within 90 degrees to either side (where none of it is there, all of
// it). Without a stated travel it is taken to reach both 90 degrees: whoever commands a machine asks first
// (TiltingWithoutTravel).
Situation SituationOfMachine(const machine::Machine& machine, const Mounted& mounted);

}  // namespace axiscal::plan

#endif  // AXISCAL_CORE_PLAN_SITUATION_H_
