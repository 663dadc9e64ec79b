// In which frame words of linear axes stand while tool centre point control is active: that of the workpiece.
//
// The control takes X, Y and Z for the place of the tool point as the table sees it, and moves the linear axes to where
// its own kinematics need them; these are taken as the machine's nominal chain (docs/nc.md, "Tool centre point
// control"). With all rotary axes at zero the words are what they are without that control, the tool length apart:
//   D (word + work offset) = tip_in_table(axes; nominal machine, tool with its length) - gauge_mm
// D: the directions in which X, Y and Z move the tool over the table at home; gauge_mm: the point at home from which
// tool lengths count (RewriteOptions::tool_tip_mm), both in the machine frame. mm and rad.
#ifndef AXISCAL_CORE_NC_TOOL_POINT_FRAME_H_
#define AXISCAL_CORE_NC_TOOL_POINT_FRAME_H_

#include <Eigen/Core>
#include <array>
#include <string>

#include "core/machine/machine.h"
#include "core/nc/modal.h"
#include "core/nc/word_frame.h"

namespace axiscal::nc {

class ToolPointFrame {
 public:
  // `machine` must outlive it.
  ToolPointFrame(const machine::Machine& machine, const Eigen::Vector3d& gauge_mm);

  // Why programs for this machine cannot stand in the workpiece's frame; "": they can. Nothing below may be asked else.
  const std::string& problem() const { return problem_; }
  // Indices of X, Y and Z in machine.axes.
  const std::array<int, 3>& xyz() const { return xyz_; }

  // words = at_zero_mm + words_of_axes * (X, Y, Z) at a pose of the rotary axes.
  struct Map {
    Eigen::Matrix3d words_of_axes, axes_of_words;
    Eigen::Vector3d at_zero_mm;
    Eigen::Vector3d direction;  // of the tool, in the axes of the words
  };
  // `positions` by machine.axes, those of rotary axes are read. False: the linear axes do not reach three directions
  // there. `placed`: where the words stand in the workpiece's frame, or over the axes; nullptr: as the frame is. Of
  // words over the axes `direction` is not filled, and `problem` does not matter.
  bool At(const double* positions, double length_mm, const WordFrame* placed, Map* map) const;

  // In `values`, by machine.axes (mm, rad): X, Y and Z from the one to the other. False as above.
  bool ToWords(double length_mm, const WordFrame* placed, double* values) const;
  bool ToAxes(double length_mm, const WordFrame* placed, double* values) const;
  // The same of ticks.
  bool ToWords(double length_mm, AxisTicks* ticks) const;
  bool ToAxes(double length_mm, AxisTicks* ticks) const;
  // Whether the tool stands along the way of the axis Z, to 0.03 deg. Of machines without a problem().
  bool IsAlongZ(const AxisTicks& ticks) const;
  // Whether Z moves the tool along the Z of the words there, and the tool stands along it.
  bool IsUpright(const AxisTicks& ticks) const;
  // The angle between the tool and the direction along which it must stand in a tilted plane, rad.
  double Lean(const AxisTicks& ticks, const WordFrame& placed) const;
  // From the tool's tip to the spindle, along the axes of the words. Of machines without a problem().
  Eigen::Vector3d Up(const AxisTicks& ticks) const;
  // Whether the machine has linear axes X, Y and Z.
  bool has_xyz() const;

  // The direction of word `index` (0 to 2) in the table's frame, and that of a vector of words.
  Eigen::Vector3d InTable(int index) const { return home_.col(index); }
  Eigen::Vector3d InTable(const Eigen::Vector3d& words) const { return home_ * words; }

 private:
  // Without D: columns in the table's frame, and the tool point there with X = Y = Z = 0.
  void Evaluate(const double* positions, double length_mm, Eigen::Matrix3d* columns, Eigen::Vector3d* tip_mm,
                Eigen::Vector3d* direction) const;

  const machine::Machine* machine_;
  Eigen::Vector3d gauge_mm_;
  std::array<int, 3> xyz_{-1, -1, -1};
  Eigen::Matrix3d home_ = Eigen::Matrix3d::Identity();  // D
  std::string problem_;
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_TOOL_POINT_FRAME_H_
