#include "client/client_impl.h"
#include "core/base/error_detail.h"
#include "proto/convert/time.h"

namespace axiscal::client {

absl::StatusOr<records::ExpectationsRecord> Client::GetExpectations(const MachineId& machine) {
  v1::GetExpectationsRequest request;
  request.set_machine_id(machine.text());
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::GetExpectationsResponse>(
                                            *impl_->events, &v1::Events::Stub::GetExpectations, request));
  records::ExpectationsRecord record;
  ASSIGN_OR_RETURN(record.content, convert::FromProto(response.expectations()));
  record.content.machine = machine;
  record.etag = response.etag();
  record.changed_by = response.changed_by();
  record.changed_at = OPTIONAL_UTC(response, changed_utc_us);
  return record;
}

absl::StatusOr<records::ExpectationsRecord> Client::SetExpectations(const records::Expectations& expected,
                                                                    int64_t etag) {
  v1::SetExpectationsRequest request;
  request.set_machine_id(expected.machine.text());
  *request.mutable_expectations() = convert::ToProto(expected);
  request.set_etag(etag);
  RETURN_IF_ERROR(
      impl_->Call<v1::SetExpectationsResponse>(*impl_->events, &v1::Events::Stub::SetExpectations, request).status());
  return GetExpectations(expected.machine);
}

absl::StatusOr<Page<records::Event>> Client::ListEvents(const records::EventFilter& filter, const PageRequest& page) {
  auto request = PageOf<v1::ListEventsRequest>(page);
  if (filter.machine) request.set_machine_id(filter.machine->text());
  request.set_open_only(filter.is_open_only);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ListEventsResponse>(*impl_->events, &v1::Events::Stub::ListEvents, request));
  return ReadPage<records::Event>(response.events(), response.next_page_token());
}

absl::Status Client::WatchEvents(const std::optional<MachineId>& machine, std::optional<int64_t> after,
                                 const std::function<bool(const records::EventNews&)>& on_news) {
  const Connection& connection = impl_->connection;
  Backoff backoff(connection.options());
  base::SteadyTime give_up = base::SystemClock().SteadyNow() + connection.options().give_up_after;
  while (true) {
    v1::WatchEventsRequest request;
    if (machine) request.set_machine_id(machine->text());
    if (after) request.set_after_change_id(*after);
    const auto context = connection.NewStreamContext();
    const auto reader = impl_->events->WatchEvents(context.get(), request);
    v1::WatchEventsResponse message;
    absl::Status taken;
    bool goes_on = true;
    while (goes_on && reader->Read(&message)) {
      records::EventNews news{message.up_to_change_id(), {}};
      if (message.has_change()) {
        absl::StatusOr<records::EventChange> change = convert::FromProto(message.change());
        if (change.ok()) {
          news.change = *std::move(change);
        } else {
          taken = change.status();
        }
      }
      goes_on = taken.ok() && on_news(news);
      if (taken.ok()) after = news.up_to;
      give_up = base::SystemClock().SteadyNow() + connection.options().give_up_after;
      backoff = Backoff(connection.options());
    }
    if (!goes_on) context->TryCancel();
    const absl::Status status = connection.FromGrpc(reader->Finish());
    if (!goes_on) return taken;
    // The stream has a deadline, as all have: a watch goes on behind it. A server cuts it off when the caller's roles
    // have changed: the next attempt hears what it may see now.
    if (!status.ok() && !absl::IsCancelled(status) && !IsBroken(status)) return status;
    if (!backoff.Wait(give_up)) return status;
  }
}

absl::StatusOr<records::Event> Client::AcknowledgeEvent(EventId id, const std::string& note) {
  v1::AcknowledgeEventRequest request;
  request.set_event_id(id.number());
  request.set_note(note);
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::AcknowledgeEventResponse>(
                                            *impl_->events, &v1::Events::Stub::AcknowledgeEvent, request));
  return convert::FromProto(response.event());
}

absl::StatusOr<records::Event> Client::ShelveEvent(EventId id, const std::optional<base::UtcTime>& until,
                                                   const std::string& note) {
  v1::ShelveEventRequest request;
  request.set_event_id(id.number());
  SET_OPTIONAL_UTC(request, until_utc_us, until);
  request.set_note(note);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ShelveEventResponse>(*impl_->events, &v1::Events::Stub::ShelveEvent, request));
  return convert::FromProto(response.event());
}

}  // namespace axiscal::client
