// What is expected of a machine, and the events that tell people where it is not so (docs/events.md).
#ifndef AXISCAL_CORE_RECORDS_EVENT_H_
#define AXISCAL_CORE_RECORDS_EVENT_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/ids.h"
#include "core/records/drift.h"

namespace axiscal::records {

struct ExpectedSession {
  std::string name;     // of the session, as its file says
  int every_hours = 0;  // one at least so often, > 0
};

// What a machine shall hold. It is no part of machine.json: calibrations are fitted with a description, and a tolerance
// that changes must not make another one of it.
struct Expectations {
  MachineId machine;
  std::vector<DriftLimit> tolerances;   // of its errors, each once, in um or urad
  std::optional<int> calibration_days;  // the calibration in use was measured at most so many days ago, > 0
  std::vector<ExpectedSession> sessions;
  // The newest candidate counts for sessions of which no calibration was ever approved.
  bool counts_candidates = false;
};

struct ExpectationsRecord {
  Expectations content;
  int64_t etag = 0;  // 0: none were ever set
  std::string changed_by;
  std::optional<base::UtcTime> changed_at;
};

// Never renumber. docs/events.md says when each is raised and cleared.
enum class EventKind {
  kOutOfTolerance = 1,
  kLimitForecast = 2,
  kStep = 3,
  kSuspect = 4,
  kUnstable = 5,
  kWear = 6,
  kScatter = 7,
  kCalibrationOld = 8,
  kSessionMissed = 9,
  kModelLacks = 10,
  kRoutineFailed = 11,
  kRoutineProposes = 12,
  kSessionRejected = 13,
  kUnlikeGroup = 14,
  kCellSilent = 15,
  kCellProblem = 16,
};
inline constexpr EventKind kAllEventKinds[] = {
    EventKind::kOutOfTolerance,  EventKind::kLimitForecast, EventKind::kStep,          EventKind::kSuspect,
    EventKind::kUnstable,        EventKind::kWear,          EventKind::kScatter,       EventKind::kCalibrationOld,
    EventKind::kSessionMissed,   EventKind::kModelLacks,    EventKind::kRoutineFailed, EventKind::kRoutineProposes,
    EventKind::kSessionRejected, EventKind::kUnlikeGroup,   EventKind::kCellSilent,    EventKind::kCellProblem};

// As people, the command line and docs/events.md call it: "out-of-tolerance".
const char* WordOf(EventKind kind);

// What an event says.
struct EventContent {
  EventKind kind = EventKind::kStep;
  std::string subject;  // the error ("EX0C"), session, routine or cell that it is about; empty: the machine
  std::string text;     // what is the case
  std::string advice;   // what to do about it
  std::vector<DriftAmount> amounts;  // errors with their sizes, the clearest first
  std::optional<double> certainty;   // 0 .. 1
  std::optional<CalibrationId> calibration;
  // Steps: the calibrations before and after it; forecasts: `to` is the date; missed sessions and old calibrations:
  // since when; others: unset.
  std::optional<base::UtcTime> from, to;
};

struct Event {
  EventId id;
  MachineId machine;
  EventContent content;
  base::UtcTime raised_at;
  std::optional<base::UtcTime> cleared_at;  // it is no longer so
  std::string cleared_why;
  std::optional<base::UtcTime> acknowledged_at;  // a person has seen it, and said a word
  std::string acknowledged_by, acknowledged_note;
  std::optional<base::UtcTime> shelved_until;  // a person does not want to hear of it until then
  std::string shelved_by, shelved_note;
};

// Never renumber.
enum class EventChangeKind {
  kRaised = 1,
  kUpdated = 2,  // still so, with other numbers
  kCleared = 3,
  kAcknowledged = 4,
  kShelved = 5,
  kBack = 6,  // the time on the shelf is over, or was ended
};

// As people, the command line and letters call it: "raised".
const char* WordOf(EventChangeKind what);

// One step in the life of an event; numbered without a gap in time: a later one has a greater id.
struct EventChange {
  int64_t id = 0;
  EventChangeKind what = EventChangeKind::kRaised;
  base::UtcTime at;
  std::string by;    // a principal; empty: the service itself
  std::string note;  // why it was cleared; the person's words
  Event event;       // as it is when this is read
};

struct EventFilter {
  std::optional<MachineId> machine;
  bool is_open_only = false;  // not cleared
};

// Of a stream: all changes up to `up_to` were handed out; the change, where there is one.
struct EventNews {
  int64_t up_to = 0;
  std::optional<EventChange> change;
};

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_EVENT_H_
