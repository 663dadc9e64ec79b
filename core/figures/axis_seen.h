// What an instrument sees of one axis that moves alone, stop by stop: deviations along the motion, across it, and
// turns.
#ifndef AXISCAL_CORE_FIGURES_AXIS_SEEN_H_
#define AXISCAL_CORE_FIGURES_AXIS_SEEN_H_

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/figures/axis_sessions.h"

namespace axiscal::figures {

// Deviations across the motion or turns about an axis, mm or mm per metre, and what the range of them is called.
struct Across {
  std::string symbol, text;
  bool is_about_line = true;      // their range is about the least-squares line
  std::vector<double> values_mm;  // of each stop
};

// What the readings say of each stop.
struct Deviations {
  std::vector<double> along_mm;  // actual - target; empty where the instrument does not see it
  std::vector<Across> across;
};

struct AxisSeen {
  std::vector<double> positions;  // mm or deg
  std::vector<double> senses;
  std::vector<double> sigma_mm;            // of a mean of a stop's readings
  Eigen::MatrixXd measured_mm;             // rows of a reading x stops, means
  Eigen::MatrixXd perfect_mm;              // what a machine without errors would show
  std::vector<Eigen::MatrixXd> stated_mm;  // what each stated fact that is off by one sigma adds, as measured_mm
  double scale_sigma = 0.0;                // of a length along the motion: how well its scale is known, by length
  std::function<Deviations(const Eigen::MatrixXd& readings_mm)> deviations_of;
};

// INVALID_ARGUMENT with the reason where no figure is known of such a session.
absl::StatusOr<AxisSeen> SeenOf(const machine::Machine& machine, const instruments::MeasuringRun& run, int axis,
                                const std::vector<Stop>& stops);

}  // namespace axiscal::figures

#endif  // AXISCAL_CORE_FIGURES_AXIS_SEEN_H_
