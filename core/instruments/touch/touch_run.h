// What the touches of one session touched: plain data of a `touch` run (docs/formats.md).
#ifndef AXISCAL_CORE_INSTRUMENTS_TOUCH_TOUCH_RUN_H_
#define AXISCAL_CORE_INSTRUMENTS_TOUCH_TOUCH_RUN_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/shapes/state.h"

namespace axiscal::touch {

// A sphere, or one plane face of a block or column: nominal, table frame at home.
struct Feature {
  std::string name;
  bool is_sphere = false;
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();  // the sphere's centre, or a point of the plane
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();   // plane: outward, unit
  double radius_mm = 0.0;                              // sphere
};

// A touch that a gate rejected: it is not taken for a reading of its feature and not fitted.
struct Rejection {
  int reading = 0;
  std::string gate;  // "sphere": off the sphere of the other touches; "repeat": off its repeats
  double off_mm = 0.0, limit_mm = 0.0;
};

struct Touches {
  std::vector<Feature> features;
  // Place about which the setup's angles turn the features: the mean of their points.
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  double stylus_radius_mm = 0.0;
  // By reading: what was touched, and the unit direction in which the stylus went, machine axes.
  std::vector<int> feature_of;
  std::vector<Eigen::Vector3d> approach;
  std::vector<shapes::Approach> approach_in_spindle;  // the same on the nominal machine
  std::vector<Rejection> rejected;                    // by reading, ascending
};

}  // namespace axiscal::touch

#endif  // AXISCAL_CORE_INSTRUMENTS_TOUCH_TOUCH_RUN_H_
