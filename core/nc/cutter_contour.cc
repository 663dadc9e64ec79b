#include "core/nc/cutter_contour.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/status.h"
#include "core/base/units.h"

namespace axiscal::nc {
namespace {

// A contour that turns by more goes back along itself, and controls differ on how the tool goes round.
constexpr double kMostTurnRad = 170.0 * base::kRadPerDeg;
// Up to such a turn a corner is smooth: it takes no more than radius * turn of both offsets.
constexpr double kSmoothRad = 0.002;
// The correction, and the rounding of words, must not turn a piece by more: the tool's centre is turned with it.
constexpr double kMostChangeRad = 0.01;
// What must be left of each piece's offset: corrections and rounding are smaller.
constexpr double kLeastRoomMm = 0.005;

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double TurnFrom(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return std::atan2(Cross(a, b), a.dot(b)); }

// Along the offset of a piece, from the offset of `at_mm` to `to_mm`, positive in the sense of motion.
double Along(const ContourPiece& piece, const Eigen::Vector2d& offset_mm, const Eigen::Vector2d& tangent,
             const Eigen::Vector2d& to_mm) {
  if (!piece.is_arc) return (to_mm - offset_mm).dot(tangent);
  const Eigen::Vector2d spoke = offset_mm - piece.arc.centre_mm, other = to_mm - piece.arc.centre_mm;
  return (piece.arc.sweep_rad > 0 ? 1.0 : -1.0) * TurnFrom(spoke, other) * spoke.norm();
}

// Where two offsets cut, the point nearest to `near_mm`. Infinite where they do not.
Eigen::Vector2d Cut(const ContourPiece& a, const Eigen::Vector2d& a_mm, const Eigen::Vector2d& a_tangent,
                    const ContourPiece& b, const Eigen::Vector2d& b_mm, const Eigen::Vector2d& b_tangent,
                    const Eigen::Vector2d& near_mm) {
  const Eigen::Vector2d none = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  const auto nearer = [&](const Eigen::Vector2d& p, const Eigen::Vector2d& q) -> Eigen::Vector2d {
    if ((p - near_mm).norm() <= (q - near_mm).norm()) return p;
    return q;
  };
  if (!a.is_arc && !b.is_arc) {
    const double sine = Cross(a_tangent, b_tangent);
    if (sine == 0) return none;
    return a_mm + a_tangent * (Cross(b_mm - a_mm, b_tangent) / sine);
  }
  if (a.is_arc && b.is_arc) {
    const Eigen::Vector2d apart = b.arc.centre_mm - a.arc.centre_mm;
    const double distance = apart.norm(), first = (a_mm - a.arc.centre_mm).norm(),
                 second = (b_mm - b.arc.centre_mm).norm();
    if (distance == 0) return none;
    const double along = (distance * distance + first * first - second * second) / (2.0 * distance);
    const double square = first * first - along * along;
    if (square < 0) return none;
    const Eigen::Vector2d unit = apart / distance, foot = a.arc.centre_mm + along * unit;
    const Eigen::Vector2d aside = std::sqrt(square) * Eigen::Vector2d(-unit.y(), unit.x());
    return nearer(foot + aside, foot - aside);
  }
  const bool is_first = a.is_arc;
  const Eigen::Vector2d &centre_mm = is_first ? a.arc.centre_mm : b.arc.centre_mm, &on_circle = is_first ? a_mm : b_mm,
                        &point = is_first ? b_mm : a_mm, &along = is_first ? b_tangent : a_tangent;
  const double radius_mm = (on_circle - centre_mm).norm();
  const Eigen::Vector2d foot = point + along * (centre_mm - point).dot(along);
  const double square = radius_mm * radius_mm - (foot - centre_mm).squaredNorm();
  return square < 0 ? none : nearer(foot + std::sqrt(square) * along, foot - std::sqrt(square) * along);
}

}  // namespace

Eigen::Vector2d ContourPiece::At(double t) const {
  if (is_arc) return arc.At(t);
  return start_mm + t * (end_mm - start_mm);
}

Eigen::Vector2d ContourPiece::Tangent(double t) const {
  if (!is_arc) return (end_mm - start_mm).normalized();
  const double angle = arc.start_rad + t * arc.sweep_rad;
  return (arc.sweep_rad > 0 ? 1.0 : -1.0) * Eigen::Vector2d(-std::sin(angle), std::cos(angle));
}

double ContourPiece::Length() const {
  return is_arc ? std::abs(arc.sweep_rad) * arc.radius_mm() : (end_mm - start_mm).norm();
}

void CutterContour::Begin(int side, double radius_mm) {
  side_ = side;
  radius_mm_ = radius_mm;
  has_last_ = false;
}

double CutterContour::OffsetLength(const ContourPiece& piece) const {
  if (!piece.is_arc) return piece.Length();
  const bool is_inside = side_ * piece.arc.sweep_rad > 0;
  return std::abs(piece.arc.sweep_rad) * (piece.arc.radius_mm() + (is_inside ? -radius_mm_ : radius_mm_));
}

std::string CutterContour::CornerTakes(const ContourPiece& from, const ContourPiece& to, double* of_from_mm,
                                       double* of_to_mm) const {
  const Eigen::Vector2d from_tangent = from.Tangent(1.0), to_tangent = to.Tangent(0.0);
  const double turn = TurnFrom(from_tangent, to_tangent);
  *of_from_mm = *of_to_mm = 0;
  if (std::abs(turn) > kMostTurnRad)
    return absl::StrFormat("the contour turns back by %.1f deg, and controls differ on how the tool goes round",
                           std::abs(turn) * base::kDegPerRad);
  if (side_ * turn <= 0) return "";  // the tool goes round outside
  if (std::abs(turn) <= kSmoothRad) {
    *of_from_mm = *of_to_mm = radius_mm_ * std::abs(turn);
    return "";
  }
  const Eigen::Vector2d from_mm = from.At(1.0) + radius_mm_ * Normal(from_tangent),
                        to_mm = to.At(0.0) + radius_mm_ * Normal(to_tangent);
  const Eigen::Vector2d cut_mm = Cut(from, from_mm, from_tangent, to, to_mm, to_tangent, 0.5 * (from_mm + to_mm));
  *of_from_mm = -Along(from, from_mm, from_tangent, cut_mm);
  *of_to_mm = Along(to, to_mm, to_tangent, cut_mm);
  if (!cut_mm.allFinite() || *of_from_mm < -kLeastRoomMm || *of_to_mm < -kLeastRoomMm)
    return absl::StrFormat("the cutter of radius %.4f mm finds no place in an inner corner", radius_mm_);
  return "";
}

std::string CutterContour::AddTo(const ContourPiece& piece, bool is_first, Track* track) const {
  if (piece.is_arc && side_ * piece.arc.sweep_rad > 0 && piece.arc.radius_mm() < radius_mm_ + kLeastRoomMm)
    return absl::StrFormat("an inner arc of radius %.4f mm leaves the cutter of radius %.4f mm no room",
                           piece.arc.radius_mm(), radius_mm_);
  double of_last_mm = 0, of_piece_mm = 0;
  if (!is_first) {
    if (std::string problem = CornerTakes(track->last, piece, &of_last_mm, &of_piece_mm); !problem.empty())
      return problem;
    if (OffsetLength(track->last) - track->taken_mm - of_last_mm < kLeastRoomMm)
      return absl::StrFormat(
          "the move in front of this one is too short for the cutter of radius %.4f mm between its "
          "corners",
          radius_mm_);
  }
  if (OffsetLength(piece) - of_piece_mm < kLeastRoomMm)
    return absl::StrFormat("the move is too short for the cutter of radius %.4f mm behind its corner", radius_mm_);
  track->last = piece;
  track->taken_mm = of_piece_mm;
  return "";
}

std::string CutterContour::Add(const ContourPiece& nominal, const ContourPiece& written) {
  const double change = std::max(std::abs(TurnFrom(nominal.Tangent(0.0), written.Tangent(0.0))),
                                 std::abs(TurnFrom(nominal.Tangent(1.0), written.Tangent(1.0))));
  if (!(change <= kMostChangeRad))
    return absl::StrFormat(
        "the move is so short (%.4f mm) that the correction, or the rounding of words, would turn it "
        "by %.4f rad, and the cutter with it: state more --decimals",
        nominal.Length(), change);
  const bool is_first = !has_last_;
  has_last_ = true;
  if (std::string problem = AddTo(nominal, is_first, &nominal_); !problem.empty()) return problem;
  const std::string problem = AddTo(written, is_first, &written_);
  return problem.empty() ? "" : problem + ", with its correction";
}

}  // namespace axiscal::nc
