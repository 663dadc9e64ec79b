// Orders of a harmonic that the measured positions cannot tell apart: sampled every 10 deg, order 45 reads like
// order 9.
#ifndef AXISCAL_CORE_LOOP_ALIASES_H_
#define AXISCAL_CORE_LOOP_ALIASES_H_

#include <vector>

namespace axiscal::loop {

// The orders above `order` up to `highest` whose cosine and sine at `positions` (rad, unsorted, repeats allowed) equal
// those of `order` or their mirror image, nearly enough. Empty without positions.
std::vector<int> AliasOrders(std::vector<double> positions, int order, int highest);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_ALIASES_H_
