// The contour that a control offsets by the cutter's radius (G41, G42; RL, RR), as the program has it and as it is
// written. What the control makes of corners and of room for the tool must be the same for both: where it depends on
// micrometres, nothing is known of the offset path.
//
// Lengths in mm, in the frame of the words. The offset of a point is radius_mm along its normal: the tangent turned by
// +90 deg (tool left of the contour) or -90 deg.
#ifndef AXISCAL_CORE_NC_CUTTER_CONTOUR_H_
#define AXISCAL_CORE_NC_CUTTER_CONTOUR_H_

#include <Eigen/Core>
#include <string>

#include "core/nc/arc.h"

namespace axiscal::nc {

// A straight piece, or one of a circle (`arc`, whose axes are the first and second of its points).
struct ContourPiece {
  Eigen::Vector2d start_mm = Eigen::Vector2d::Zero(), end_mm = Eigen::Vector2d::Zero();
  bool is_arc = false;
  Arc arc;

  Eigen::Vector2d At(double t) const;
  Eigen::Vector2d Tangent(double t) const;  // unit
  double Length() const;
};

class CutterContour {
 public:
  // A contour begins, behind the move that leads to it. `side`: +1 the tool stands left of it, -1 right.
  void Begin(int side, double radius_mm);
  // The next piece of both contours. Why the offset path is not known, or "".
  std::string Add(const ContourPiece& nominal, const ContourPiece& written);
  // The move behind it leads away.
  void End() { has_last_ = false; }

  int side() const { return side_; }
  double radius_mm() const { return radius_mm_; }
  // The direction from the contour to the tool's centre, unit.
  Eigen::Vector2d Normal(const Eigen::Vector2d& tangent) const {
    return side_ * Eigen::Vector2d(-tangent.y(), tangent.x());
  }
  // Of the path of the tool's centre beside a piece, above zero where the tool has room.
  double OffsetLength(const ContourPiece& piece) const;

 private:
  // One of both contours: its last piece, and how much of that piece's offset the corner in front of it takes.
  struct Track {
    ContourPiece last;
    double taken_mm = 0;
  };
  std::string AddTo(const ContourPiece& piece, bool is_first, Track* track) const;
  // An inner corner: how much of both offsets it takes. Why that is not known, or "".
  std::string CornerTakes(const ContourPiece& from, const ContourPiece& to, double* of_from_mm, double* of_to_mm) const;

  int side_ = 1;
  double radius_mm_ = 0;
  bool has_last_ = false;
  Track nominal_, written_;
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_CUTTER_CONTOUR_H_
