// Figures of a positioning test of one linear axis: targets P_i, each approached n times in one direction or in both.
// With x_ij = actual - target (mm) in the axis' positive direction, arrows for the direction of approach:
//   mean            m_i(up), m_i(down);   m_i = (m_i(up) + m_i(down)) / 2
//   reversal        B_i = m_i(up) - m_i(down);   B = max |B_i|;   mean reversal = mean of B_i
//   repeatability   s_i: standard deviation of the approaches (n - 1);   R_i(up) = 4 s_i(up), R(up) = max over i;
//                   R_i = max(2 s_i(up) + 2 s_i(down) + |B_i|, R_i(up), R_i(down));   R = max over i
//   systematic      E(up) = max m_i(up) - min m_i(up);   E = max of all means of either direction - min of them
//   mean            M = max m_i - min m_i
//   accuracy        A(up) = max (m_i(up) + 2 s_i(up)) - min (m_i(up) - 2 s_i(up));   A: the same over both directions
// A constant added to all x changes none of them but m. Names and formulas as ISO 230-2 has them: *assumed*, the text
// of the standard is not at hand (docs/figures.md).
#ifndef AXISCAL_CORE_FIGURES_POSITIONING_H_
#define AXISCAL_CORE_FIGURES_POSITIONING_H_

#include <optional>
#include <vector>

namespace axiscal::figures {

struct Approach {
  double target = 0.0;        // mm; deg of a rotary axis, whose deviations are mm per metre
  double deviation_mm = 0.0;  // actual - target
  double sense = 0.0;         // of the approach: +1 or -1
};

struct Direction {
  int approaches = 0;
  double mean_mm = 0.0;
  std::optional<double> deviation_mm;  // standard deviation; none of one approach
};

struct Target {
  double target = 0.0;
  std::optional<Direction> up, down;
};

// Absent: not tested in that direction or in both, or approached once only where a repeatability counts.
struct Unidirectional {
  std::optional<double> accuracy_mm, repeatability_mm, systematic_mm;  // A, R, E
};

struct Positioning {
  std::vector<Target> targets;  // by position
  int fewest_approaches = 0;    // of a target in a direction in which it was approached
  // Targets that were approached once from a side while others were repeated (the first reading, a place to turn
  // round) count as not approached from there; how many.
  int approached_once = 0;
  Unidirectional up, down;
  // Over the targets that were approached in both directions.
  std::optional<double> accuracy_mm, repeatability_mm, systematic_mm, mean_mm, reversal_mm, mean_reversal_mm;
};

// Approaches within `same` of each other are of one target. Unidirectional figures are over all targets of that
// direction.
Positioning PositioningOf(std::vector<Approach> approaches, double same = 1e-3);

}  // namespace axiscal::figures

#endif  // AXISCAL_CORE_FIGURES_POSITIONING_H_
