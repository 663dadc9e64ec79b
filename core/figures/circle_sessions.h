// Figures of ball-bar sessions in which two linear axes move on a circle.
#ifndef AXISCAL_CORE_FIGURES_CIRCLE_SESSIONS_H_
#define AXISCAL_CORE_FIGURES_CIRCLE_SESSIONS_H_

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/figures/circular.h"
#include "core/figures/figures.h"

namespace axiscal::figures {

// Sessions of one circle: plane, radius, ball and tool alike.
struct Circle {
  std::string plane;  // "XY"
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

MeasuredTest CircleTest(const Circle& circle);

}  // namespace axiscal::figures

#endif  // AXISCAL_CORE_FIGURES_CIRCLE_SESSIONS_H_
