#include "core/instruments/clock.h"

#include <algorithm>

namespace axiscal::instruments {

std::optional<std::pair<std::string, std::string>> FindOverlap(const std::vector<MeasuringRun>& runs) {
  std::vector<const MeasuringRun*> in_order;
  for (const MeasuringRun& run : runs) {
    if (run.has_time && run.path_readings == nullptr && !run.time_s.empty()) in_order.push_back(&run);
  }
  std::stable_sort(in_order.begin(), in_order.end(),
                   [](const MeasuringRun* a, const MeasuringRun* b) { return a->time_s.front() < b->time_s.front(); });
  for (size_t i = 1; i < in_order.size(); ++i) {
    if (in_order[i]->time_s.front() < in_order[i - 1]->time_s.back())
      return std::pair(in_order[i - 1]->session, in_order[i]->session);
  }
  return std::nullopt;
}

}  // namespace axiscal::instruments
