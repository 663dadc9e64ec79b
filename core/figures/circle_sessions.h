// Figures of ball-bar sessions in which two linear axes move on a circle, or in which axes of both kinds take the bar
// round a cone: as when the envelope of a cone is milled, the path seen from the table (ISO 10791-6 has such tests; its
// text was not at hand, and the names are *assumed*).
#ifndef AXISCAL_CORE_FIGURES_CIRCLE_SESSIONS_H_
#define AXISCAL_CORE_FIGURES_CIRCLE_SESSIONS_H_

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/figures/circular.h"
#include "core/figures/figures.h"

namespace axiscal::figures {

// Sessions of one circle or cone: plane or axis, radius, ball and tool alike.
struct Circle {
  bool is_cone = false;
  std::string plane;  // "XY"; of a cone "half angle 30 deg about (0 0 1)"
  double radius_mm = 0.0;
  std::vector<const instruments::MeasuringRun*> runs;
  std::vector<CirclePoint> of_sense[2];  // counter-clockwise, clockwise
  std::vector<double> sigma_mm[2];       // of each point
  // What each stated fact that is off by one standard uncertainty adds to each point.
  std::map<std::string, std::vector<double>> stated_mm[2];
};

// Adds the readings of a session to its circle, by sense; what is wrong where the bar does not go round in a plane of
// the machine, and nothing is added.
std::optional<std::string> AddCircle(const machine::Machine& machine, const instruments::MeasuringRun& run,
                                     std::map<std::string, Circle>* circles);

// The same of a bar that goes round in the table's frame at a constant angle to the mean of its directions (a cone; at
// 90 deg the circle that is across), in the sense of a right-handed turn about that axis.
std::optional<std::string> AddCone(const machine::Machine& machine, const instruments::MeasuringRun& run,
                                   std::map<std::string, Circle>* circles);

MeasuredTest CircleTest(const Circle& circle);

}  // namespace axiscal::figures

#endif  // AXISCAL_CORE_FIGURES_CIRCLE_SESSIONS_H_
