#include "server/watch/plan.h"

#include <algorithm>

namespace axiscal::watch {
namespace {

using records::Event;
using records::EventContent;
using records::EventKind;

bool IsOf(const Event& event, const EventContent& content) {
  if (event.content.kind != content.kind) return false;
  if (content.kind != EventKind::kStep)
    return event.content.subject == content.subject && !event.cleared_at.has_value();
  return *event.content.from < *content.to && *content.from < *event.content.to;
}

bool IsSame(const EventContent& a, const EventContent& b) {
  return a.text == b.text && a.advice == b.advice && a.calibration == b.calibration && a.certainty == b.certainty &&
         std::equal(a.amounts.begin(), a.amounts.end(), b.amounts.begin(), b.amounts.end(),
                    [](const auto& x, const auto& y) {
                      return x.symbol == y.symbol && x.size == y.size && x.sigma == y.sigma;
                    });
}

}  // namespace

storage::EventChanges PlanChanges(const MachineId& machine, const std::set<EventKind>& kinds,
                                  const std::vector<Event>& standing, const std::vector<Condition>& conditions) {
  storage::EventChanges changes;
  changes.machine = machine;
  std::set<EventId> kept;
  for (const Condition& condition : conditions) {
    const auto event = std::find_if(standing.begin(), standing.end(),
                                    [&](const Event& known) { return IsOf(known, condition.content); });
    if (event == standing.end()) {
      if (condition.raises) changes.raised.push_back(condition.content);
      continue;
    }
    if (!kept.insert(event->id).second || event->cleared_at) continue;
    EventContent content = condition.content;
    if (content.kind == EventKind::kStep) {
      content.from = event->content.from;
      content.to = event->content.to;
    }
    if (!IsSame(content, event->content)) changes.updated.push_back({event->id, std::move(content)});
  }
  for (const Event& event : standing) {
    if (event.cleared_at || kept.contains(event.id) || !kinds.contains(event.content.kind)) continue;
    changes.cleared.push_back({event.id, WhyCleared(event.content.kind)});
  }
  return changes;
}

}  // namespace axiscal::watch
