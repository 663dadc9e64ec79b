#include "server/handlers/watch_events.h"

#include "core/base/clock.h"
#include "core/base/error_detail.h"
#include "proto/convert/event.h"
#include "proto/convert/field.h"

namespace axiscal::handlers {
namespace {

// How often a silent watch asks whether its caller is still there.
constexpr std::chrono::milliseconds kLooksAgainAfter(200);
// A stream on which nothing comes is cut by proxies; many do so after a minute.
constexpr std::chrono::seconds kSaysThatItLives(20);

}  // namespace

absl::Status WatchEvents(Core& core, const Call& call, const v1::WatchEventsRequest& request,
                         const std::function<bool(const v1::WatchEventsResponse&)>& send) {
  RETURN_IF_ERROR(convert::RequireNotNegative("after_change_id", request.after_change_id()));
  std::optional<MachineId> machine;
  if (!request.machine_id().empty()) machine = MachineId(request.machine_id());
  int64_t up_to = request.after_change_id();
  if (!request.has_after_change_id()) {
    ASSIGN_OR_RETURN(up_to, core.database.LastEventChange());
  }
  const absl::Status gone = base::Error(absl::StatusCode::kCancelled, "the caller has left", {"CALLER_GONE", {}});
  bool is_first = true;
  base::SteadyTime said_last = base::SystemClock().SteadyNow();
  while (!call.is_cancelled()) {
    if (core.draining) return base::Error(absl::StatusCode::kUnavailable, "the server is stopping", {"DRAINING", {}});
    const int64_t told = core.events->told();
    ASSIGN_OR_RETURN(const storage::EventChangePage page, core.database.ReadEventChanges(up_to, machine, call.visible));
    const base::SteadyTime now = base::SystemClock().SteadyNow();
    v1::WatchEventsResponse response;
    if (is_first || (page.changes.empty() && page.is_last && now - said_last >= kSaysThatItLives)) {
      response.set_up_to_change_id(page.changes.empty() ? page.up_to : up_to);
      if (!send(response)) return gone;
      is_first = false;
      said_last = now;
    }
    for (const records::EventChange& change : page.changes) {
      response.set_up_to_change_id(change.id);
      *response.mutable_change() = convert::ToProto(change);
      if (!send(response)) return gone;
      said_last = now;
    }
    up_to = page.up_to;
    if (!page.is_last) continue;
    const auto is_silent = [&] { return base::SystemClock().SteadyNow() - said_last < kSaysThatItLives; };
    while (core.events->told() == told && is_silent() && !core.draining && !call.is_cancelled())
      core.events->Wait(told, kLooksAgainAfter);
  }
  return gone;
}

}  // namespace axiscal::handlers
