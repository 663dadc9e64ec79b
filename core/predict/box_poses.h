// A box of axis positions and poses in it: in use wherever something is said of a whole work space before it is known
// which part of it a program goes through.
#ifndef AXISCAL_CORE_PREDICT_BOX_POSES_H_
#define AXISCAL_CORE_PREDICT_BOX_POSES_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/base/status.h"
#include "core/instruments/run.h"
#include "core/machine/machine.h"
#include "core/reports/axis_range.h"
#include "core/shapes/state.h"

namespace axiscal::predict {

// Least and greatest position of each axis of the machine, mm or rad.
struct Box {
  std::vector<double> low, high;
};

// Travel of the machine's axes, a full turn of a rotary axis that states none. INVALID_ARGUMENT naming a linear axis
// without travel.
absl::StatusOr<Box> BoxOfTravel(const machine::Machine& machine);

// Positions that the readings of `runs` covered; empty without readings.
Box MeasuredBox(const std::vector<instruments::MeasuringRun>& runs);
// The same in mm and deg, as reports have it.
std::vector<reports::AxisRange> RangesOf(const machine::Machine& machine, const Box& box);
// What lies in either; one that is empty takes nothing in.
Box Around(const Box& one, const Box& other);

// Where and in which state the tool point is looked at.
struct Workspace {
  Eigen::Vector3d tip_mm = Eigen::Vector3d::Zero();  // nominal, at home, machine frame
  Box box;
  int poses = 400;
  double time_s = 0.0;
  double temperature_celsius = 20.0;
};

// Poses that stand for a box: the mean square over it is off by about 1 / sqrt(poses) of the spread of the squares, 3 %
// of the root.
inline constexpr int kBoxPoses = 400;

// Poses in a box, each with the state that the machine is in there. The same arguments give the same poses.
class BoxPoses {
 public:
  // At the corners of the box (of up to eight axes that move), then Workspace::poses drawn evenly from it, each axis at
  // rest after a move of either sense.
  explicit BoxPoses(const Workspace& workspace);
  // Drawn evenly, one after the other, no axis faster than it was in the runs. Time, temperature and whatever else a
  // state holds are those of readings drawn from the runs: nothing is said of times and temperatures that nobody
  // measured. `runs`: at least one reading; must outlive it. Without `box`: MeasuredBox().
  BoxPoses(const std::vector<instruments::MeasuringRun>& runs, int count, const std::optional<Box>& box = {});

  const Box& box() const { return box_; }
  int count() const { return static_cast<int>(states_.size()); }
  // In the machine's order, mm or rad.
  const double* PositionsOf(int pose) const { return positions_.data() + static_cast<size_t>(pose) * axes_; }
  shapes::State At(int pose) const;

 private:
  const Box box_;
  const size_t axes_;
  std::vector<double> positions_;
  std::vector<shapes::AxisState> axis_states_;
  std::vector<shapes::State> states_;  // without their axes
};

}  // namespace axiscal::predict

#endif  // AXISCAL_CORE_PREDICT_BOX_POSES_H_
