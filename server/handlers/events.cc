#include "server/handlers/events.h"

#include "proto/convert/event.h"
#include "proto/convert/field.h"
#include "proto/convert/time.h"
#include "server/handlers/known_errors.h"

namespace axiscal::handlers {
namespace {

constexpr size_t kMaxNoteBytes = 1000;

}  // namespace

absl::StatusOr<v1::GetExpectationsResponse> GetExpectations(Core& core, const Call&,
                                                            const v1::GetExpectationsRequest& request) {
  RETURN_IF_ERROR(convert::RequireText("machine_id", request.machine_id(), 1, 255));
  ASSIGN_OR_RETURN(const records::ExpectationsRecord record,
                   core.database.GetExpectations(MachineId(request.machine_id())));
  v1::GetExpectationsResponse response;
  *response.mutable_expectations() = convert::ToProto(record.content);
  response.set_etag(record.etag);
  response.set_changed_by(record.changed_by);
  SET_OPTIONAL_UTC(response, changed_utc_us, record.changed_at);
  return response;
}

absl::StatusOr<v1::SetExpectationsResponse> SetExpectations(Core& core, const Call& call,
                                                            const v1::SetExpectationsRequest& request) {
  RETURN_IF_ERROR(convert::RequireText("machine_id", request.machine_id(), 1, 255));
  RETURN_IF_ERROR(convert::RequireMessage("expectations", request.has_expectations()));
  RETURN_IF_ERROR(convert::RequireNotNegative("etag", request.etag()));
  absl::StatusOr<records::Expectations> expected = convert::FromProto(request.expectations());
  if (!expected.ok()) return convert::InField("expectations", expected.status());
  expected->machine = MachineId(request.machine_id());
  ASSIGN_OR_RETURN(const KnownErrors known, KnownErrors::Of(core.database, expected->machine));
  for (size_t i = 0; i < expected->tolerances.size(); ++i) {
    RETURN_IF_ERROR(
        known.Require(absl::StrCat("expectations.tolerances[", i, "].symbol"), expected->tolerances[i].symbol));
  }
  ASSIGN_OR_RETURN(const records::ExpectationsRecord record,
                   core.database.SetExpectations(*expected, request.etag(), call.By()));
  core.look_soon(expected->machine);
  v1::SetExpectationsResponse response;
  *response.mutable_expectations() = convert::ToProto(record.content);
  response.set_etag(record.etag);
  return response;
}

absl::StatusOr<v1::ListEventsResponse> ListEvents(Core& core, const Call& call, const v1::ListEventsRequest& request) {
  ASSIGN_OR_RETURN(const records::PageRequest page, PageFrom(request.page_size(), request.page_token()));
  records::EventFilter filter;
  if (!request.machine_id().empty()) filter.machine = MachineId(request.machine_id());
  filter.is_open_only = request.open_only();
  ASSIGN_OR_RETURN(const records::Page<records::Event> events, core.database.ListEvents(filter, page, call.visible));
  v1::ListEventsResponse response;
  for (const records::Event& event : events.rows) *response.add_events() = convert::ToProto(event);
  response.set_next_page_token(events.next_token);
  return response;
}

absl::StatusOr<v1::AcknowledgeEventResponse> AcknowledgeEvent(Core& core, const Call& call,
                                                              const v1::AcknowledgeEventRequest& request) {
  RETURN_IF_ERROR(convert::RequireText("note", request.note(), 1, kMaxNoteBytes));
  ASSIGN_OR_RETURN(const records::Event event,
                   core.database.AcknowledgeEvent(EventId(request.event_id()), request.note(), call.By()));
  core.events->Tell();
  v1::AcknowledgeEventResponse response;
  *response.mutable_event() = convert::ToProto(event);
  return response;
}

absl::StatusOr<v1::ShelveEventResponse> ShelveEvent(Core& core, const Call& call,
                                                    const v1::ShelveEventRequest& request) {
  RETURN_IF_ERROR(convert::RequireText("note", request.note(), 0, kMaxNoteBytes));
  ASSIGN_OR_RETURN(const records::Event event,
                   core.database.ShelveEvent(EventId(request.event_id()), OPTIONAL_UTC(request, until_utc_us),
                                             request.note(), call.By()));
  core.events->Tell();
  v1::ShelveEventResponse response;
  *response.mutable_event() = convert::ToProto(event);
  return response;
}

}  // namespace axiscal::handlers
