// What a machine did, moment by moment: what effects with a memory (heat, friction, servos) are computed from.
#ifndef AXISCAL_CORE_SYNTHETIC_HISTORY_H_
#define AXISCAL_CORE_SYNTHETIC_HISTORY_H_

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/instruments/run.h"
#include "core/machine/machine.h"
#include "core/shapes/state.h"

namespace axiscal::synthetic {

// Of a `channel` in place of a temperature: the time since the clock's zero, s.
inline constexpr char kTimeChannel[] = "time";

// The readings of one or several sessions in time order. Memory runs on through the gaps between sessions; a sense of
// motion and a speed are those of the session (MeasuringRun).
struct History {
  int axis_count = 0;
  std::vector<double> positions;                             // moment-major, mm or rad
  std::vector<shapes::AxisState> axis_states;                // the same positions with sense, travel and speed
  std::vector<double> time_s;                                // never runs back
  std::map<std::string, std::vector<double>> celsius;        // per temperature channel ("temp_C"), deg C
  std::vector<size_t> session_begin;                         // first moment of each session
  std::shared_ptr<const shapes::Temperatures> temperatures;  // `celsius` at `time_s`, for shapes that remember it

  size_t size() const { return time_s.size(); }
  const double* PositionsOf(size_t moment) const { return positions.data() + moment * axis_count; }
  const shapes::AxisState& AxisAt(size_t moment, int axis) const { return axis_states[moment * axis_count + axis]; }
  bool BeginsSession(size_t moment) const;
  // The state with the temperature of channel "temp_C", where there is one.
  shapes::State StateOf(size_t moment) const;
  // Positions of one axis over all moments.
  std::vector<double> PathOf(int axis) const;
};

// Appends a session that was bound. `celsius` has the channels by which the history began, one value per reading.
void Append(const instruments::MeasuringRun& run, const std::map<std::string, std::vector<double>>& celsius,
            History* history);

// Lowest and highest position of an axis, or of the time (axis -1).
struct Range {
  double low = 0.0, high = 0.0;
  double length() const { return high - low; }
};
Range RangeOf(const History& history, int axis);

// The path of an axis between its moments: through every position, with the speeds of central differences (cubic
// Hermite). At a session's end it stays.
class Path {
 public:
  Path(const History& history, int axis);
  // Position, speed and acceleration at `time_s`, in the interval that begins at `moment`.
  struct Point {
    double position, speed, acceleration;
  };
  Point At(size_t moment, double time_s) const;
  // At any time from the history's first to its last.
  double PositionAt(double time_s) const;
  double SpeedOf(size_t moment) const { return speed_[moment]; }

 private:
  const std::vector<double> time_s_, position_;
  std::vector<double> speed_;
};

}  // namespace axiscal::synthetic

#endif  // AXISCAL_CORE_SYNTHETIC_HISTORY_H_
