// Events.WatchEvents: every change of events once and in order, from where the caller stands.
#ifndef AXISCAL_SERVER_HANDLERS_WATCH_EVENTS_H_
#define AXISCAL_SERVER_HANDLERS_WATCH_EVENTS_H_

#include <functional>

#include "axiscal/v1/events_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

// `send` returns false when the caller has left. Goes on until then; UNAVAILABLE DRAINING when the server stops first.
absl::Status WatchEvents(Core& core, const Call& call, const v1::WatchEventsRequest& request,
                         const std::function<bool(const v1::WatchEventsResponse&)>& send);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_WATCH_EVENTS_H_
