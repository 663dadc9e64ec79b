// Figures of circular tests: radial deviations d(t) = actual - nominal radius along circles of two linear axes, one
// counter-clockwise, one clockwise, or either alone.
//   circular deviation   G: the least width of two concentric circles with the path between them: minimum over centres
//                        (a, b) of  max (d - a cos t - b sin t) - min (the same);   of each sense, and G_b of both
//                        senses in one envelope
//   radial deviation     F_max, F_min: the largest and the least of d about the least-squares centre; the nominal
//   radius
//                        counts, so they stand on the bar's length
//   mean radial deviation D: radius of the least-squares circle of both senses less the nominal one
// First order in d over the radius: a micrometre in a hundred millimetres. Names as ISO 230-4 has them: *assumed*, the
// text of the standard is not at hand (docs/figures.md).
#ifndef AXISCAL_CORE_FIGURES_CIRCULAR_H_
#define AXISCAL_CORE_FIGURES_CIRCULAR_H_

#include <optional>
#include <vector>

namespace axiscal::figures {

struct CirclePoint {
  double angle_rad = 0.0;  // from the first axis of the plane towards the second
  double deviation_mm = 0.0;
};

// The least width over all centres, and that about the least-squares centre, which is never less. At least 3 points.
struct Envelope {
  double width_mm = 0.0, about_least_squares_mm = 0.0;
  double max_mm = 0.0, min_mm = 0.0, mean_mm = 0.0;  // about the least-squares centre; mean: its radius less nominal
};
Envelope EnvelopeOf(const std::vector<CirclePoint>& circle);

// The share of a turn that the points span without a gap of more than 5 deg, up to 1.
double SpanOf(const std::vector<CirclePoint>& points);

struct Circular {
  std::optional<Envelope> ccw, cw;
  std::optional<Envelope> both;  // all points of both senses about one centre
};
Circular CircularOf(const std::vector<CirclePoint>& ccw, const std::vector<CirclePoint>& cw);

}  // namespace axiscal::figures

#endif  // AXISCAL_CORE_FIGURES_CIRCULAR_H_
