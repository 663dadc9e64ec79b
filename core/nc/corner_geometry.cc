#include "core/nc/corner_geometry.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "core/base/units.h"

namespace axiscal::nc {
namespace {

using Eigen::Vector2d;

// A contour that turns by more goes back along itself.
constexpr double kMostCornerRad = 170.0 * base::kRadPerDeg;
// A corner that comes nearer than that to the path around it is none: words and corrections are coarser.
constexpr double kNothingMm = 1e-5;
// Lengths are the same to that.
constexpr double kSameLengthMm = 1e-7;

double CrossOf(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }
Vector2d LeftOf(const Vector2d& tangent) { return {-tangent.y(), tangent.x()}; }
double SenseOf(const Arc& arc) { return arc.sweep_rad > 0 ? 1.0 : -1.0; }

Vector2d TangentAt(const CornerMove& move, bool is_end) {
  if (!move.is_arc) return (move.end_mm - move.start_mm).normalized();
  const Vector2d spoke = (is_end ? move.end_mm : move.start_mm) - move.arc.centre_mm;
  return SenseOf(move.arc) * LeftOf(spoke.normalized());
}

double RadiusAt(const CornerMove& move, bool is_end) {
  return ((is_end ? move.end_mm : move.start_mm) - move.arc.centre_mm).norm();
}

double LengthOf(const CornerMove& move, bool is_end) {
  return move.is_arc ? std::abs(move.arc.sweep_rad) * RadiusAt(move, is_end) : (move.end_mm - move.start_mm).norm();
}

// Where centres of circles of that radius stand that touch a move at its left (side 1) or right (-1): a line, or a
// circle about the move's own centre.
struct Locus {
  bool is_circle = false;
  Vector2d at_mm = Vector2d::Zero(), along = Vector2d::Zero();  // of a line; of a circle its centre
  double radius_mm = 0;
};

Locus LocusOf(const CornerMove& move, bool is_end, double side, double radius_mm) {
  const Vector2d tangent = TangentAt(move, is_end), corner = is_end ? move.end_mm : move.start_mm;
  if (!move.is_arc) return {false, corner + side * radius_mm * LeftOf(tangent), tangent, 0};
  return {true, move.arc.centre_mm, Vector2d::Zero(), RadiusAt(move, is_end) - side * SenseOf(move.arc) * radius_mm};
}

std::vector<Vector2d> Meet(const Locus& a, const Locus& b) {
  if (!a.is_circle && !b.is_circle) {
    const double sine = CrossOf(a.along, b.along);
    if (sine == 0) return {};
    return {a.at_mm + a.along * (CrossOf(b.at_mm - a.at_mm, b.along) / sine)};
  }
  if (a.is_circle && b.is_circle) {
    const Vector2d apart = b.at_mm - a.at_mm;
    const double distance = apart.norm();
    if (distance == 0) return {};
    const double along =
        (distance * distance + a.radius_mm * a.radius_mm - b.radius_mm * b.radius_mm) / (2.0 * distance);
    const double square = a.radius_mm * a.radius_mm - along * along;
    if (square < 0) return {};
    const Vector2d unit = apart / distance, foot = a.at_mm + along * unit, aside = std::sqrt(square) * LeftOf(unit);
    return {foot + aside, foot - aside};
  }
  const Locus &circle = a.is_circle ? a : b, &line = a.is_circle ? b : a;
  const Vector2d foot = line.at_mm + line.along * (circle.at_mm - line.at_mm).dot(line.along);
  const double square = circle.radius_mm * circle.radius_mm - (foot - circle.at_mm).squaredNorm();
  if (square < 0) return {};
  return {foot + std::sqrt(square) * line.along, foot - std::sqrt(square) * line.along};
}

// Where the circle about `centre_mm` touches the move, and how much of the move lies between there and the corner.
Vector2d TouchOf(const CornerMove& move, bool is_end, const Vector2d& centre_mm, double* taken_mm) {
  const Vector2d corner = is_end ? move.end_mm : move.start_mm, tangent = TangentAt(move, is_end);
  if (!move.is_arc) {
    const double along = (centre_mm - corner).dot(tangent);
    *taken_mm = is_end ? -along : along;
    return corner + along * tangent;
  }
  const double radius = RadiusAt(move, is_end);
  const Vector2d spoke = (centre_mm - move.arc.centre_mm).normalized(), at = corner - move.arc.centre_mm;
  double turn = SenseOf(move.arc) * (is_end ? -1.0 : 1.0) * std::atan2(CrossOf(at, spoke), at.dot(spoke));
  if (turn < -kSameLengthMm / radius) turn += 2.0 * std::numbers::pi;
  *taken_mm = turn * radius;
  return move.arc.centre_mm + radius * spoke;
}

absl::Status TurnsBack(double turn_rad) {
  return absl::InvalidArgumentError(
      absl::StrFormat("the contour turns back by %.1f deg there", std::abs(turn_rad) * base::kDegPerRad));
}

absl::Status Fits(const CornerMove& from, const CornerMove& to, double size_mm, double of_from_mm, double of_to_mm,
                  CornerPath* path) {
  const double from_mm = LengthOf(from, true), to_mm = LengthOf(to, false);
  path->left_of_from_mm = from_mm - of_from_mm;
  path->left_of_to_mm = to_mm - of_to_mm;
  const double cosine = std::cos(0.5 * TurnAtCorner(from, to));
  path->reach_mm = size_mm / (cosine * cosine);
  const bool is_in_front = path->left_of_from_mm < -kSameLengthMm;
  if (!is_in_front && path->left_of_to_mm >= -kSameLengthMm) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("it takes %.4f mm of the move %s it, which has %.4f mm", is_in_front ? of_from_mm : of_to_mm,
                      is_in_front ? "in front of" : "behind", is_in_front ? from_mm : to_mm));
}

}  // namespace

double TurnAtCorner(const CornerMove& from, const CornerMove& to) {
  const Vector2d in = TangentAt(from, true), out = TangentAt(to, false);
  return std::atan2(CrossOf(in, out), in.dot(out));
}

absl::StatusOr<CornerPath> RoundCorner(const CornerMove& from, const CornerMove& to, double radius_mm) {
  const double turn = TurnAtCorner(from, to);
  CornerPath path;
  path.is_none = radius_mm * (1.0 / std::max(std::cos(0.5 * turn), 1e-9) - 1.0) < kNothingMm;
  if (path.is_none) return path;
  if (std::abs(turn) > kMostCornerRad) return TurnsBack(turn);
  const double side = turn > 0 ? 1.0 : -1.0;
  const Locus first = LocusOf(from, true, side, radius_mm), second = LocusOf(to, false, side, radius_mm);
  for (const Locus& locus : {first, second}) {
    if (locus.is_circle && locus.radius_mm <= kSameLengthMm)
      return absl::InvalidArgumentError(
          absl::StrFormat("it does not fit into the arc of radius %.4f mm beside it", locus.radius_mm + radius_mm));
  }
  absl::Status problem = absl::InvalidArgumentError("no arc of that radius touches both moves");
  double least_mm = 0;
  bool is_found = false;
  for (const Vector2d& centre : Meet(first, second)) {
    CornerPath next;
    double of_from_mm = 0, of_to_mm = 0;
    next.from_mm = TouchOf(from, true, centre, &of_from_mm);
    next.to_mm = TouchOf(to, false, centre, &of_to_mm);
    if (of_from_mm < -kSameLengthMm || of_to_mm < -kSameLengthMm) continue;
    if (is_found && of_from_mm + of_to_mm >= least_mm) continue;
    next.is_arc = true;
    next.centre_mm = centre;
    next.is_counterclockwise = turn > 0;
    least_mm = of_from_mm + of_to_mm;
    is_found = true;
    problem = Fits(from, to, radius_mm, of_from_mm, of_to_mm, &next);
    path = next;
  }
  if (!problem.ok()) return problem;
  return path;
}

absl::StatusOr<CornerPath> ChamferCorner(const CornerMove& from, const CornerMove& to, double size_mm, bool is_length) {
  if (from.is_arc || to.is_arc) return absl::InvalidArgumentError("a chamfer beside an arc");
  const double turn = TurnAtCorner(from, to);
  CornerPath path;
  if (std::abs(turn) > kMostCornerRad) return TurnsBack(turn);
  const double leg_mm = is_length ? 0.5 * size_mm / std::cos(0.5 * turn) : size_mm;
  path.is_none = leg_mm * std::abs(std::sin(0.5 * turn)) < kNothingMm;
  if (path.is_none) return path;
  path.from_mm = from.end_mm - leg_mm * TangentAt(from, true);
  path.to_mm = to.start_mm + leg_mm * TangentAt(to, false);
  if (absl::Status problem = Fits(from, to, size_mm, leg_mm, leg_mm, &path); !problem.ok()) return problem;
  return path;
}

}  // namespace axiscal::nc
