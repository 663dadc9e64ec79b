#include "server/jobs/job_context.h"

#include <algorithm>

namespace axiscal::jobs {

bool JobContext::cancelled() {
  if (stop_reason_.load() == StopReason::kNone && clock_.SteadyNow() >= deadline_) Stop(at_deadline_);
  return stop_reason_.load() != StopReason::kNone;
}

void JobContext::ReportProgress(const std::string& stage, double fraction, const std::string& detail) {
  publish_({stage, std::clamp(fraction, 0.0, 1.0), detail});
}

void JobContext::Stop(StopReason reason) {
  StopReason none = StopReason::kNone;
  stop_reason_.compare_exchange_strong(none, reason);
}

}  // namespace axiscal::jobs
