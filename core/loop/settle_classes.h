// The class of each effect, once all are known: what the fit sessions cannot tell from it beside the others.
#ifndef AXISCAL_CORE_LOOP_SETTLE_CLASSES_H_
#define AXISCAL_CORE_LOOP_SETTLE_CLASSES_H_

#include "core/identify/identify.h"
#include "core/loop/extension.h"

namespace axiscal::loop {

// Adds to each effect's class what explains as much in its place: some members are alike only while the other effects
// are refitted with them, and those were not known when the effect was added. Removes members whose full refit in its
// place is worse by more than kToldApart: a strong effect is worth thousands in chi-square, so with a correlation of
// 0.98 a member can still fit far worse. `fit`: of the extension. CANCELLED.
absl::Status SettleClasses(const identify::Fit& fit, const SearchOptions& search, const identify::Options& options,
                           Extension* extension);

// Chi-square: twice what a new effect needs, six sigma.
inline constexpr double kToldApart = 36.0;

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_SETTLE_CLASSES_H_
