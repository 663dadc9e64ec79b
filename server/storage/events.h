// What is expected of machines, events and the order of all that happened to them. Only the watcher (server/watch)
// raises and clears; people acknowledge and shelve.
#ifndef AXISCAL_SERVER_STORAGE_EVENTS_H_
#define AXISCAL_SERVER_STORAGE_EVENTS_H_

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// Something of which events of the machine follow has changed: it is looked at again. With the change, in one
// transaction.
absl::Status NoteChange(Connection& connection, int64_t machine_key);

// As Database has them.
absl::StatusOr<ExpectationsRecord> GetExpectations(Connection& connection, const MachineId& machine);
absl::StatusOr<ExpectationsRecord> SetExpectations(Connection& connection, UtcTime now, const Expectations& expected,
                                                   int64_t expected_etag, const Caller& caller);
absl::StatusOr<std::vector<std::pair<MachineId, int64_t>>> MachinesWithEvents(Connection& connection, int most);
absl::StatusOr<Event> GetEvent(Connection& connection, EventId id);
absl::StatusOr<Page<Event>> ListEvents(Connection& connection, const EventFilter& filter, const PageRequest& request,
                                       const Visible& visible);
absl::StatusOr<std::vector<Event>> StandingEvents(Connection& connection, const MachineId& machine);
absl::StatusOr<Event> AcknowledgeEvent(Connection& connection, UtcTime now, EventId id, const std::string& note,
                                       const Caller& caller);
absl::StatusOr<Event> ShelveEvent(Connection& connection, UtcTime now, EventId id, std::optional<UtcTime> until,
                                  const std::string& note, const Caller& caller);
absl::StatusOr<bool> HasEventToBringBack(Connection& connection, UtcTime now);
absl::StatusOr<int> BringBackEvents(Connection& connection, UtcTime now);
absl::StatusOr<int> ChangeEvents(Connection& connection, UtcTime now, const EventChanges& changes);
absl::StatusOr<EventChangePage> ReadEventChanges(Connection& connection, int64_t after,
                                                 const std::optional<MachineId>& machine, const Visible& visible);
// That one; NOT_FOUND CHANGE_NOT_FOUND.
absl::StatusOr<EventChange> GetEventChange(Connection& connection, int64_t id);
absl::StatusOr<int64_t> LastEventChange(Connection& connection);
absl::StatusOr<LookStand> GetLookStand(Connection& connection, const MachineId& machine);
absl::StatusOr<std::vector<MachineId>> MachinesToLookAt(Connection& connection, const std::string& version);
absl::StatusOr<std::optional<UtcTime>> NewestSession(Connection& connection, const MachineId& machine,
                                                     const std::string& name);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_EVENTS_H_
