// Refines places, widths, frequencies and moments between those of the dictionary: a grid around the best one that
// shrinks; each point is a linear fit with everything else projected off.
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

// True for families that the dictionary samples: their members can be compared only after refinement.
bool IsGrid(Family family);

// The candidate, or where that explains more, the candidate at the place (frequency, length, time constant) of a
// leader of its family: the same effect on another joint looks alike only at the same place.
Candidate AtPlaceOf(const Signatures& signatures, const Candidate& candidate, const std::vector<Candidate>& leaders);

// The shape without a decay that takes the term's place where its decay is far longer than the sessions: a drift for a
// warming far slower than the sessions, a backlash for a spike longer than the travel. In such cases the data do not
// determine the final amplitude, the time constant and the decay length.
std::optional<Candidate> StraightFormOf(const identify::Problem& problem, const machine::ErrorTerm& term);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_REFINE_H_
