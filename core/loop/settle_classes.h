// The class of each effect, once all are known: what the fit sessions cannot tell from it beside the others.
#ifndef AXISCAL_CORE_LOOP_SETTLE_CLASSES_H_
#define AXISCAL_CORE_LOOP_SETTLE_CLASSES_H_

#include "core/identify/identify.h"
#include "core/loop/extension.h"

namespace axiscal::loop {

// Adds to each effect's class what explains as much in its place: when it was added the others were not there, and what
// is alike only once they change with it was none of its class then. Takes from it the members whose full refit in its
// place is worse by more than kToldApart: strong effects leave thousands in chi-square, another that is 0.98 alike then
// still fits far worse, and with it the model would be significantly inadequate. `fit`: of the extension. CANCELLED.
absl::Status SettleClasses(const identify::Fit& fit, const SearchOptions& search, const identify::Options& options,
                           Extension* extension);

// Chi-square: twice what a new effect needs, six sigma.
inline constexpr double kToldApart = 36.0;

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_SETTLE_CLASSES_H_
