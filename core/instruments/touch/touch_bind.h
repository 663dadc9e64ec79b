// Reads what a `touch` session touched and gates it as controllers do: the session is refused whole when it does not
// fit.
#ifndef AXISCAL_CORE_INSTRUMENTS_TOUCH_TOUCH_BIND_H_
#define AXISCAL_CORE_INSTRUMENTS_TOUCH_TOUCH_BIND_H_

#include <algorithm>

#include "core/instruments/run.h"

namespace axiscal::touch {

// The feature of a header line `sphere NAME: x y z radius` or `plane NAME: x y z nx ny nz`. INVALID_ARGUMENT naming the
// key and the rule.
absl::StatusOr<Feature> ParseFeature(const std::string& key, const std::string& value);

// Fills run->touches from the headers `stylus_radius_mm`, `sphere NAME`, `plane NAME` and the columns nx, ny, nz,
// feature, and from which side each linear axis came (run->stated_senses) by the approach where nothing else states it.
// INVALID_ARGUMENT naming key or reading and the rule: unknown or twice-named feature, an approach that is no
// unit vector (1e-3).
absl::Status BindTouches(const machine::Machine& machine, const session::Session& session,
                         instruments::MeasuringRun* run);

// INVALID_ARGUMENT naming reading, feature and what was expected when
// - a touch stands off its feature by more than kWrongFeatureMm or does not approach it from outside: it is of another
//   feature;
// - a sphere's radius, fitted to at least five touches at one rotary pose, misses sphere + stylus by more than the
//   header's `radius_gate_um`: the stylus radius or the sphere is another one;
// - more than a third of the touches of a feature at one rotary pose would be rejected.
// Single touches are rejected (run->touches.rejected, for the fit to leave out and the report to list) that
// - stand off the sphere of the other touches, at least five, by more than `radius_gate_um`;
// - differ from the other repeats of one touch (same feature, commands and approach) by more than `repeat_gate_um`: the
//   one that is off where there are three or more, both where there are two.
// Both gates are 20 um where the header is silent.
absl::Status GateTouches(const machine::Machine& machine, const session::Session& session,
                         instruments::MeasuringRun* run);

// Of the touches of one feature: more than a third, and more than two. What is wrong with so many is wrong with all.
inline bool AreTooMany(size_t bad, size_t touches) { return 3 * bad > std::max<size_t>(touches, 6); }

inline constexpr double kDefaultGateMm = 0.020;
// Far above mounting (5 mm is one sigma of the prior), below the distance between features.
inline constexpr double kWrongFeatureMm = 25.0;

}  // namespace axiscal::touch

#endif  // AXISCAL_CORE_INSTRUMENTS_TOUCH_TOUCH_BIND_H_
