// Sessions that disagree by a constant of their commanded positions: the work offset was set anew between them, and
// nobody said so (docs/formats.md, "datum").
#ifndef AXISCAL_CORE_IDENTIFY_DATUM_H_
#define AXISCAL_CORE_IDENTIFY_DATUM_H_

#include <vector>

#include "core/identify/identify.h"

namespace axiscal::identify {

// At most one warning (reports::DatumMoved): the set-ups whose linear axes, were they free of a constant, would take
// at least `least_share` of what chi-square is above its degrees of freedom, or of what set-ups are pulled from their
// places by, and by more than chance each. Score test of omitted parameters (Rao 1948) on the normal equations of
// `fit`; nothing is fitted again. One set-up stays what the others are compared with. Nothing where the readings
// scatter as stated, where no errors were fitted, and of set-ups whose datum is free already.
std::vector<reports::WarningFacts> FindMovedDatum(const Fit& fit, double least_share = 0.5);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_DATUM_H_
