// Where words of X, Y and Z stand while a rotation, a mirror, a scale or a tilted plane is in force:
//   base = linear * position + shift_mm
// position: what words say, work offset included, as Interpreter keeps them (ticks as mm).
#ifndef AXISCAL_CORE_NC_WORD_FRAME_H_
#define AXISCAL_CORE_NC_WORD_FRAME_H_

#include <Eigen/Core>
#include <cstdint>

namespace axiscal::nc {

struct WordFrame {
  enum class Base : uint8_t {
    kAxes,    // base: axis positions
    kTable,   // base: positions under tool centre point control, in the workpiece's frame (tool_point_frame.h)
    kOrigin,  // words count along the axes, from where the turned table has carried `shift_mm`, a position as of kTable
  };
  Base base = Base::kAxes;
  Eigen::Matrix3d linear = Eigen::Matrix3d::Identity(), inverse = Eigen::Matrix3d::Identity();
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
  double scale = 1.0;           // how long 1 mm of words is at most, mm
  bool keeps_circles = true;    // a circle of words in XY is a circle of the tool point
  Eigen::Vector3d up{0, 0, 1};  // of kTable: the direction along which the tool must stand, base
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_WORD_FRAME_H_
