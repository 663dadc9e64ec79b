// Dense series seen from further away. Neighbouring readings of a series become one row while no axis moves on by more
// than a four-hundredth of its range: what changes more slowly shows in their sums as in the readings themselves, at a
// fraction of the cost.
#ifndef AXISCAL_CORE_EFFECTS_THINNED_H_
#define AXISCAL_CORE_EFFECTS_THINNED_H_

#include <optional>
#include <vector>

#include "core/effects/linearised.h"
#include "core/loop/extension.h"

namespace axiscal::effects {

// y of each row: the sum of n whitened readings over the root of n, so that white noise of one sigma stays that. All
// columns are those of one reading, at the weight of the sum; whitening holds no memory any more. Rows of
// `bad_rows`, and those that remember them, are left out. Nothing where readings stand too far apart for half of the
// rows to be spared, or belong to paths.
std::optional<Linearised> Thinned(const Linearised& linearised, const std::vector<loop::BadRow>& bad_rows);

}  // namespace axiscal::effects

#endif  // AXISCAL_CORE_EFFECTS_THINNED_H_
