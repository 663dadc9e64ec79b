// The functions behind the registry's lines.
#ifndef AXISCAL_CORE_PLAN_TESTS_INTERNAL_H_
#define AXISCAL_CORE_PLAN_TESTS_INTERNAL_H_

#include "core/plan/test.h"

namespace axiscal::plan {

std::vector<PlannedSession> BallbarPatterns(const Situation& situation);
std::vector<PlannedSession> BallbarTurns(const Situation& situation);
std::vector<PlannedSession> BallbarSwungTurns(const Situation& situation);
std::vector<PlannedSession> BallbarCircles(const Situation& situation);
std::vector<PlannedSession> BallbarLinked(const Situation& situation);
std::vector<PlannedSession> SphereProbing(const Situation& situation);
std::vector<PlannedSession> TouchSpheres(const Situation& situation);
std::vector<PlannedSession> TouchPlates(const Situation& situation);
std::vector<PlannedSession> TouchColumns(const Situation& situation);
std::vector<PlannedSession> TouchBlockPairs(const Situation& situation);
std::vector<PlannedSession> LengthLines(const Situation& situation);
std::vector<PlannedSession> StraightnessLines(const Situation& situation);
std::vector<PlannedSession> DirectionLines(const Situation& situation);
std::vector<PlannedSession> DirectionTurns(const Situation& situation);
std::vector<PlannedSession> DistanceGrids(const Situation& situation);
std::vector<PlannedSession> TrackerGrids(const Situation& situation);
std::vector<PlannedSession> TrackerReferences(const Situation& situation);
std::vector<PlannedSession> RtestGrids(const Situation& situation);
std::vector<PlannedSession> RtestApproaches(const Situation& situation);
std::vector<PlannedSession> OtherSense(const Situation& situation);
std::vector<PlannedSession> Later(const Situation& situation);
std::vector<PlannedSession> Warmer(const Situation& situation);
std::vector<PlannedSession> FartherTurned(const Situation& situation);
std::vector<PlannedSession> Finer(const Situation& situation);

// The twelve patterns presume a structure: whether the nominal machine keeps the bar at its length on this one.
bool KeepsTheBar(const machine::Machine& machine, const session::Session& session);

}  // namespace axiscal::plan

#endif  // AXISCAL_CORE_PLAN_TESTS_INTERNAL_H_
