// Between the dictionary's places, widths, frequencies and moments: a grid around the best that shrinks, each point a
// linear fit with everything else projected off.
#ifndef AXISCAL_CORE_LOOP_REFINE_H_
#define AXISCAL_CORE_LOOP_REFINE_H_

#include <optional>
#include <vector>

#include "core/loop/signatures.h"

namespace axiscal::loop {

// The best of the candidates by what it explains, with its linear amplitude. DEMANDs that there is one.
Candidate BestOf(const Signatures& signatures, const std::vector<Candidate>& candidates);

// A bump's place and width, a pitch's frequency, a decay length or time constant; others as they are. `range` is the
// measured range of the candidate's axis.
Candidate Refined(const Signatures& signatures, const Candidate& candidate, double range);

// A slip at the reading of its session that explains most, with the range of moments that explain as much within
// `indistinguishable` (chi-square units).
Candidate AtBestMoment(const Signatures& signatures, Candidate slip, double indistinguishable);

// The slip, and whether one of the tool instead of the table, or the other way round, explains as much within
// `indistinguishable` at its own best moment.
Candidate WithCarrierTold(const Signatures& signatures, Candidate slip, double indistinguishable);

// Families that the dictionary samples: their members compare only once they are refined.
bool IsGrid(Family family);

// The candidate, or where it explains more, the candidate at the place (frequency, length, time constant) of one of the
// leaders, of its family: what is one effect by other names, on other joints, is alike only there.
Candidate AtPlaceOf(const Signatures& signatures, const Candidate& candidate, const std::vector<Candidate>& leaders);

// The shape without a decay that a decay far longer than the sessions is. A warming that is far slower than they are
// long is a drift, a spike that outlasts the travel a backlash: the amplitude that the one would have in the end, its
// time constant and the other's length are made up.
std::optional<Candidate> StraightFormOf(const identify::Problem& problem, const machine::ErrorTerm& term);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_REFINE_H_
