// What is expected of machines, and events: Events.GetExpectations, SetExpectations, ListEvents, AcknowledgeEvent,
// ShelveEvent (docs/events.md).
#ifndef AXISCAL_SERVER_HANDLERS_EVENTS_H_
#define AXISCAL_SERVER_HANDLERS_EVENTS_H_

#include "axiscal/v1/events_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::GetExpectationsResponse> GetExpectations(Core& core, const Call& call,
                                                            const v1::GetExpectationsRequest& request);
// FIELD_INVALID also for a tolerance of an error that no calibration of the machine has, where it has any: nobody
// would ever hear of it.
absl::StatusOr<v1::SetExpectationsResponse> SetExpectations(Core& core, const Call& call,
                                                            const v1::SetExpectationsRequest& request);
absl::StatusOr<v1::ListEventsResponse> ListEvents(Core& core, const Call& call, const v1::ListEventsRequest& request);
absl::StatusOr<v1::AcknowledgeEventResponse> AcknowledgeEvent(Core& core, const Call& call,
                                                              const v1::AcknowledgeEventRequest& request);
absl::StatusOr<v1::ShelveEventResponse> ShelveEvent(Core& core, const Call& call,
                                                    const v1::ShelveEventRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_EVENTS_H_
