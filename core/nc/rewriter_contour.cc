// Contours that the control offsets by the cutter's radius (G41, G42; RL, RR). Words are corrected as those of the
// part's contour. The cutter's centre stands a radius beside it, where errors differ a little: with p the contour and
// n its normal, the centre is told p' + r n', and should be told p + r n + d(p + r n), d the correction. What of the
// difference stands across the centre's path is left at the part: along it, in Z too, the tool comes by anyway.
#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/nc/rewriter_impl.h"

namespace axiscal::nc {
namespace {

// Along a piece, where what is left is looked at: at both ends, and between them every so often. Errors that come again
// with each turn of a screw (some 10 mm) and turns of short arcs are then seen within some per cent.
constexpr double kLookMm = 1.0;
constexpr int kLeastLooks = 12, kMostLooks = 1000;
constexpr char kBesideIt[] = "the cutter's centre stands beside the contour, where errors differ";
constexpr char kHeldThere[] =
    "the move has no part in X and Y, and with a correction there the control would offset the cutter";

double Mm(Ticks ticks) { return static_cast<double>(ticks) / kTicksPerUnit; }

}  // namespace

std::string Rewriter::Impl::TakeContour() {
  contour_role = ContourRole::kNone;
  if (contour_state == ContourState::kOff && step.cutter_side == 0) return "";
  if (step.cutter_side == 0) {
    contour_state = contour_state == ContourState::kStarting ? ContourState::kOff : ContourState::kEnding;
    if (contour_state == ContourState::kOff) return "";
  } else if (contour_state == ContourState::kOff) {
    contour_state = ContourState::kStarting;
  }
  bool is_in_plane = step.is_arc;
  for (const int axis : {interpreter.frame().xyz()[0], interpreter.frame().xyz()[1]}) {
    is_in_plane |=
        step.start.is_known(axis) ? step.start.ticks[axis] != step.end.ticks[axis] : step.word_of_axis[axis] >= 0;
  }
  if (corrector().uses_sense() && (is_in_plane || step.cutter_side != 0))
    return "under cutter compensation lost motion cannot be taken up: a move for it would be one of the contour";
  if (!is_in_plane) {
    contour_role = ContourRole::kHeld;
  } else if (contour_state == ContourState::kStarting || contour_state == ContourState::kEnding) {
    const bool begins = contour_state == ContourState::kStarting;
    contour_role = begins ? ContourRole::kEntry : ContourRole::kExit;
    if (step.is_arc) return begins ? "cutter compensation begins with an arc" : "cutter compensation ends with an arc";
  } else {
    contour_role = ContourRole::kPiece;
  }
  return "";
}

void Rewriter::Impl::WriteHeld() {
  Piece held = piece;
  for (const int axis : {interpreter.frame().xyz()[0], interpreter.frame().xyz()[1]})
    held.targets[axis] = writer.commanded().ticks[axis];
  const double departure_mm = MoveDeparture();
  const size_t begin = out.size();
  writer.WriteBlock(now.text, now.size, block, step, held, 1.0, &out);
  CheckLength(begin);
  if (!is_mark_written && !IsWrittenAsItWas(begin)) WriteMark(begin);
  job.Account(now, piece, writer.commanded(), departure_mm);
  job.Contoured(now, LeftAt(piece, writer.commanded()) + departure_mm, RoundingMm(), !step.is_rapid, kHeldThere);
  if (passes()) writer.Arrive(step);
}

void Rewriter::Impl::FollowContour(const AxisTicks& from, double first, const Piece& written) {
  const int x = interpreter.frame().xyz()[0], y = interpreter.frame().xyz()[1];
  switch (contour_role) {
    case ContourRole::kNone:
    case ContourRole::kHeld:
      return;
    case ContourRole::kEntry:
      contour.Begin(step.cutter_side == 1 ? 1 : -1, Mm(step.cutter_radius));
      contour_state = ContourState::kOn;
      return;
    case ContourRole::kExit:
      contour.End();
      contour_state = ContourState::kOff;
      return;
    case ContourRole::kPiece:
      break;
  }
  ContourPiece nominal, as_written;
  const auto at = [&](double fraction) -> Eigen::Vector2d {
    return Eigen::Vector2d(Mm(step.start.ticks[x]), Mm(step.start.ticks[y])) +
           fraction * Eigen::Vector2d(Mm(step.end.ticks[x] - step.start.ticks[x]),
                                      Mm(step.end.ticks[y] - step.start.ticks[y]));
  };
  nominal.is_arc = step.is_arc;
  nominal.arc = step.arc;
  nominal.arc.start_rad += first * step.arc.sweep_rad;
  nominal.arc.sweep_rad *= written.end_fraction - first;
  nominal.start_mm = step.is_arc ? nominal.arc.At(0.0) : at(first);
  nominal.end_mm = step.is_arc ? nominal.arc.At(1.0) : at(written.end_fraction);
  const AxisTicks& to = writer.commanded().ticks;
  as_written.is_arc = written.is_arc;
  as_written.arc = written.arc;
  as_written.start_mm = Eigen::Vector2d(Mm(from[x]), Mm(from[y]));
  as_written.end_mm = Eigen::Vector2d(Mm(to[x]), Mm(to[y]));
  if (const std::string reason = contour.Add(nominal, as_written); !reason.empty())
    return job.Refused(now, "along the contour of cutter compensation " + reason, false);
  const absl::StatusOr<double> left_mm = LeftAlong(nominal, as_written, from, first, written);
  if (!left_mm.ok()) return job.Refused(now, std::string(left_mm.status().message()), false);
  job.Contoured(now, *left_mm, RoundingMm(), !step.is_rapid, kBesideIt);
}

absl::StatusOr<double> Rewriter::Impl::LeftAlong(const ContourPiece& nominal, const ContourPiece& as_written,
                                                 const AxisTicks& from, double first, const Piece& written) {
  const std::array<int, 3>& xyz = interpreter.frame().xyz();
  const int x = xyz[0], y = xyz[1], z = xyz[2];
  Step centre = step;
  centre.is_arc = false;
  const int looks = std::clamp(static_cast<int>(std::ceil(nominal.Length() / kLookMm)), kLeastLooks, kMostLooks);
  // Of the centre's path: Z in mm for each mm in X and Y.
  const double slope =
      Mm(step.end.ticks[z] - step.start.ticks[z]) * (written.end_fraction - first) / contour.OffsetLength(nominal);
  double worst_mm = 0;
  for (int look = 0; look <= looks; ++look) {
    const double t = static_cast<double>(look) / looks, fraction = first + t * (written.end_fraction - first);
    const Eigen::Vector2d tangent = nominal.Tangent(t), normal = contour.Normal(tangent), at_mm = nominal.At(t);
    const Eigen::Vector2d centre_mm = at_mm + contour.radius_mm() * normal;
    centre.end.ticks[x] = std::llround(centre_mm.x() * kTicksPerUnit);
    centre.end.ticks[y] = std::llround(centre_mm.y() * kTicksPerUnit);
    centre.end.ticks[z] =
        step.start.ticks[z] + std::llround(fraction * static_cast<double>(step.end.ticks[z] - step.start.ticks[z]));
    Piece wanted;
    RETURN_IF_ERROR(corrector().CorrectEnd(centre, WordGrain(), &wanted));
    const Eigen::Vector2d asked_mm(Mm(wanted.targets[x] - wanted.nominal[x]),
                                   Mm(wanted.targets[y] - wanted.nominal[y]));
    const Eigen::Vector2d told_mm = as_written.At(t) - at_mm, turned = as_written.Tangent(t);
    const double across_mm = (told_mm - asked_mm).dot(normal) + contour.radius_mm() * (turned.dot(tangent) - 1.0);
    const double along_mm = (told_mm - asked_mm + contour.radius_mm() * contour.Normal(turned)).dot(tangent);
    const double told_z_mm = Mm(from[z]) + t * Mm(writer.commanded().ticks[z] - from[z]) - Mm(centre.end.ticks[z]);
    const double high_mm = told_z_mm - Mm(wanted.targets[z] - wanted.nominal[z]);
    worst_mm = std::max(worst_mm, std::hypot(across_mm, (high_mm - slope * along_mm) / std::hypot(1.0, slope)));
  }
  return worst_mm;
}

}  // namespace axiscal::nc
