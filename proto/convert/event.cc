#include "proto/convert/event.h"

#include <set>

#include "proto/convert/calibration.h"
#include "proto/convert/field.h"
#include "proto/convert/time.h"

namespace axiscal::convert {
namespace {

// As many errors as drift follows (core/drift/calibration.h); more sessions nobody measures regularly.
constexpr int kMostTolerances = 64, kMostSessions = 64;
constexpr int kMostDays = 3650, kMostHours = 87'600;  // ten years

absl::Status RequireBetween(const std::string& field, int64_t value, int64_t least, int64_t most) {
  if (value >= least && value <= most) return absl::OkStatus();
  return FieldError(field, absl::StrCat(value, ", must be ", least, " to ", most));
}

}  // namespace

v1::Expectations ToProto(const records::Expectations& expected) {
  v1::Expectations message;
  for (const records::DriftLimit& limit : expected.tolerances) {
    v1::DriftLimit& added = *message.add_tolerances();
    added.set_symbol(limit.symbol);
    added.set_low(limit.low);
    added.set_high(limit.high);
  }
  if (expected.calibration_days) message.set_calibration_days(*expected.calibration_days);
  for (const records::ExpectedSession& session : expected.sessions) {
    v1::ExpectedSession& added = *message.add_sessions();
    added.set_name(session.name);
    added.set_every_hours(session.every_hours);
  }
  message.set_counts_candidates(expected.counts_candidates);
  return message;
}

absl::StatusOr<records::Expectations> FromProto(const v1::Expectations& message) {
  records::Expectations expected;
  RETURN_IF_ERROR(RequireAtMost("tolerances", message.tolerances_size(), kMostTolerances));
  std::set<std::string> seen;
  for (int i = 0; i < message.tolerances_size(); ++i) {
    const v1::DriftLimit& limit = message.tolerances(i);
    const std::string field = absl::StrCat("tolerances[", i, "]");
    RETURN_IF_ERROR(RequireText(field + ".symbol", limit.symbol(), 1, 200));
    if (!seen.insert(limit.symbol()).second) return FieldError(field + ".symbol", limit.symbol() + " stands twice");
    RETURN_IF_ERROR(RequireFinite(field + ".low", limit.low()));
    RETURN_IF_ERROR(RequireFinite(field + ".high", limit.high()));
    if (!(limit.low() < limit.high())) return FieldError(field + ".low", "must be less than high");
    expected.tolerances.push_back({limit.symbol(), limit.low(), limit.high()});
  }
  if (message.has_calibration_days()) {
    RETURN_IF_ERROR(RequireBetween("calibration_days", message.calibration_days(), 1, kMostDays));
    expected.calibration_days = message.calibration_days();
  }
  RETURN_IF_ERROR(RequireAtMost("sessions", message.sessions_size(), kMostSessions));
  seen.clear();
  for (int i = 0; i < message.sessions_size(); ++i) {
    const v1::ExpectedSession& session = message.sessions(i);
    const std::string field = absl::StrCat("sessions[", i, "]");
    RETURN_IF_ERROR(RequireText(field + ".name", session.name(), 1, 255));
    if (!seen.insert(session.name()).second) return FieldError(field + ".name", session.name() + " stands twice");
    RETURN_IF_ERROR(RequireBetween(field + ".every_hours", session.every_hours(), 1, kMostHours));
    expected.sessions.push_back({session.name(), session.every_hours()});
  }
  expected.counts_candidates = message.counts_candidates();
  return expected;
}

v1::Event ToProto(const records::Event& event) {
  v1::Event message;
  const records::EventContent& content = event.content;
  message.set_event_id(event.id.number());
  message.set_machine_id(event.machine.text());
  message.set_kind(static_cast<v1::EventKind>(content.kind));
  message.set_subject(content.subject);
  message.set_text(content.text);
  message.set_advice(content.advice);
  for (const records::DriftAmount& amount : content.amounts) {
    v1::DriftAmount& added = *message.add_amounts();
    added.set_symbol(amount.symbol);
    added.set_unit(ToProto(amount.unit));
    added.set_size(amount.size);
    added.set_sigma(amount.sigma);
  }
  if (content.certainty) message.set_certainty(*content.certainty);
  if (content.calibration) message.set_calibration_id(content.calibration->number());
  SET_OPTIONAL_UTC(message, from_utc_us, content.from);
  SET_OPTIONAL_UTC(message, to_utc_us, content.to);
  message.set_raised_utc_us(base::ToUtcUs(event.raised_at));
  SET_OPTIONAL_UTC(message, cleared_utc_us, event.cleared_at);
  message.set_cleared_why(event.cleared_why);
  SET_OPTIONAL_UTC(message, acknowledged_utc_us, event.acknowledged_at);
  message.set_acknowledged_by(event.acknowledged_by);
  message.set_acknowledged_note(event.acknowledged_note);
  SET_OPTIONAL_UTC(message, shelved_until_utc_us, event.shelved_until);
  message.set_shelved_by(event.shelved_by);
  message.set_shelved_note(event.shelved_note);
  return message;
}

absl::StatusOr<records::Event> FromProto(const v1::Event& message) {
  records::Event event;
  records::EventContent& content = event.content;
  event.id = EventId(message.event_id());
  event.machine = MachineId(message.machine_id());
  content.kind = static_cast<records::EventKind>(message.kind());
  content.subject = message.subject();
  content.text = message.text();
  content.advice = message.advice();
  for (const v1::DriftAmount& amount : message.amounts()) {
    ASSIGN_OR_RETURN(const records::EstimateUnit unit, FromProto(amount.unit()));
    content.amounts.push_back({amount.symbol(), unit, amount.size(), amount.sigma()});
  }
  if (message.has_certainty()) content.certainty = message.certainty();
  if (message.has_calibration_id()) content.calibration = CalibrationId(message.calibration_id());
  content.from = OPTIONAL_UTC(message, from_utc_us);
  content.to = OPTIONAL_UTC(message, to_utc_us);
  event.raised_at = base::FromUtcUs(message.raised_utc_us());
  event.cleared_at = OPTIONAL_UTC(message, cleared_utc_us);
  event.cleared_why = message.cleared_why();
  event.acknowledged_at = OPTIONAL_UTC(message, acknowledged_utc_us);
  event.acknowledged_by = message.acknowledged_by();
  event.acknowledged_note = message.acknowledged_note();
  event.shelved_until = OPTIONAL_UTC(message, shelved_until_utc_us);
  event.shelved_by = message.shelved_by();
  event.shelved_note = message.shelved_note();
  return event;
}

v1::EventChange ToProto(const records::EventChange& change) {
  v1::EventChange message;
  message.set_change_id(change.id);
  message.set_what(static_cast<v1::EventChangeKind>(change.what));
  message.set_at_utc_us(base::ToUtcUs(change.at));
  message.set_by(change.by);
  message.set_note(change.note);
  *message.mutable_event() = ToProto(change.event);
  return message;
}

absl::StatusOr<records::EventChange> FromProto(const v1::EventChange& message) {
  records::EventChange change;
  RETURN_IF_ERROR(RequirePositive("change_id", message.change_id()));
  change.id = message.change_id();
  change.what = static_cast<records::EventChangeKind>(message.what());
  change.at = base::FromUtcUs(message.at_utc_us());
  change.by = message.by();
  change.note = message.note();
  ASSIGN_OR_RETURN(change.event, FromProto(message.event()));
  return change;
}

}  // namespace axiscal::convert
