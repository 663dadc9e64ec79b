// Strong effects leave thousands in chi-square: another that is 0.98 alike then still fits far worse, and this data
// does tell the two apart.
#ifndef AXISCAL_CORE_LOOP_TOLD_APART_H_
#define AXISCAL_CORE_LOOP_TOLD_APART_H_

#include "core/identify/identify.h"
#include "core/loop/extension.h"

namespace axiscal::loop {

// Takes from each effect's class the members whose full refit in its place is worse by more than kToldApart: with them
// the model would be significantly inadequate. `fit`: of the extension. CANCELLED.
absl::Status DropToldApart(const identify::Fit& fit, const identify::Options& options, Extension* extension);

// Chi-square: twice what a new effect needs, six sigma.
inline constexpr double kToldApart = 36.0;

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_TOLD_APART_H_
