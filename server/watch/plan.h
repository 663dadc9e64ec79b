// What becomes of a machine's events, given what is the case now: raised once, kept by hysteresis, cleared when nothing
// of the condition is left.
#ifndef AXISCAL_SERVER_WATCH_PLAN_H_
#define AXISCAL_SERVER_WATCH_PLAN_H_

#include <set>
#include <vector>

#include "server/storage/records.h"
#include "server/watch/conditions.h"

namespace axiscal::watch {

// `standing`: Database::StandingEvents(). Of events of other kinds than `kinds` nothing is said.
//   A step is the one that stands, or that a person has acknowledged, when their dates overlap; then it keeps its dates
//   and is not raised again. Other events are of one kind and subject.
//   An event is updated where its text or sizes are new.
storage::EventChanges PlanChanges(const MachineId& machine, const std::set<records::EventKind>& kinds,
                                  const std::vector<records::Event>& standing,
                                  const std::vector<Condition>& conditions);

}  // namespace axiscal::watch

#endif  // AXISCAL_SERVER_WATCH_PLAN_H_
