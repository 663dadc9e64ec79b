// What a session's header states of lengths that grow with warmth and of certified values (session/stated_facts.h):
// what it adds to each reading, and what its uncertainty adds. With dT = T - 20 deg C, a the coefficient, all on the
// nominal machine with its set-up in its nominal place and to first order (a dT L = 100 um is then right to 0.01 um):
//   bar         - a dT (bar length)                                       a warm bar is long, and shows less
//   instrument  - a dT (length from the anchor; of a beam from the home position)     the same of a wire, a scale
//   artefact    - a dT (n . (p - c)), of a sphere n . (p - c) + radius: what n . p of a touched point grows about c,
//   the
//               features' middle (its place is a set-up offset)
//   scale X     + a dT q_X d(reading)/d(shift along X): the axis stands at the mark q, which is at q (1 + a dT); about
//               the axis' zero
//   workpiece   the same of all linear axes: what is cut to q while it is warm is q (1 - a dT) at 20 deg C. Figures
//   alone
// Certified values: bar_length takes the place of bar_length_mm; scale adds its share of the length.
#ifndef AXISCAL_CORE_INSTRUMENTS_STATED_H_
#define AXISCAL_CORE_INSTRUMENTS_STATED_H_

#include "core/instruments/run.h"

namespace axiscal::instruments {

// A certified length that is farther from bar_length_mm belongs to another bar.
inline constexpr double kCertifiedWithinMm = 1.0;

// Fills run->stated, run->stated_mm, run->certificates and run->started; sets bar length and its offset as a
// certificate says. Of a run that is bound otherwise. INVALID_ARGUMENT naming the session and the header where a
// temperature column is missing, an axis is none or no linear one, or a certified length is of another bar.
absl::Status BindStated(const session::Session& session, const machine::Machine& machine, MeasuringRun* run);
// Certificates and the session's start alone.
void BindCertificates(const session::Session& session, MeasuringRun* run);

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_STATED_H_
