// Sessions that the work offset was set anew between, seen from what the loop found: nobody said so (docs/formats.md,
// "datum"), and effects were found for what are constants of the commanded positions.
#ifndef AXISCAL_CORE_LOOP_MOVED_DATUM_H_
#define AXISCAL_CORE_LOOP_MOVED_DATUM_H_

#include <vector>

#include "core/loop/extension.h"

namespace axiscal::loop {

// identify::FindMovedDatum of the last fit. Where that finds nothing, of fits without the effects, all and one by one:
// the constants that explain nine tenths of what the effects did (reports::DatumMoved::in_place_of). `fit` is of
// `extension`. CANCELLED.
absl::StatusOr<std::vector<reports::WarningFacts>> ProposeDatum(const identify::Fit& fit, const Extension& extension,
                                                                const identify::Options& options);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_MOVED_DATUM_H_
