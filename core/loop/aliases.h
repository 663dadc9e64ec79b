// Frequencies that the measured positions cannot tell apart: sampled every 10 deg, order 45 reads like order 9.
#ifndef AXISCAL_CORE_LOOP_ALIASES_H_
#define AXISCAL_CORE_LOOP_ALIASES_H_

#include <Eigen/Core>
#include <vector>

namespace axiscal::loop {

// The orders above `order` up to `highest` whose cosine and sine at `positions` (rad, unsorted, repeats allowed) equal
// those of `order` or their mirror image, nearly enough. Empty without positions.
std::vector<int> AliasOrders(std::vector<double> positions, int order, int highest);

// A wave a cos(f q) + b sin(f q) that reads like another one.
struct Alias {
  double frequency = 0.0;
  // Of the other wave's cosine (first column) and sine: what its amplitudes are as those of this one.
  Eigen::Matrix2d of_amplitudes;
};

// Those of a wave of `frequency` at `positions`, up to the frequency `highest`, of whose squares there they miss
// less than `share`; no slower ones than half a period in the range of the positions.
std::vector<Alias> AliasesOf(std::vector<double> positions, double frequency, double highest, double share);

// The highest frequency (rad per unit of the positions) that the positions as a set tell from all lower ones: half the
// lowest at which they all stand at nearly the same point of a wave, and `limit` where that is lower or there is none.
// Of equidistant positions the Nyquist frequency; poses that are not equidistant, or steps of several sessions, tell
// more. 0 where positions tell no frequency.
double HighestFrequency(std::vector<double> positions, double limit);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_ALIASES_H_
