#include "proto/convert/session.h"

#include <set>

#include "proto/convert/field.h"
#include "proto/convert/time.h"

namespace axiscal::convert {

v1::SessionSchema ToProto(const records::SessionSchema& schema) {
  v1::SessionSchema message;
  for (const session::HeaderEntry& entry : schema.header) {
    v1::HeaderEntry* const out = message.add_header();
    out->set_key(entry.key);
    out->set_value(entry.value);
  }
  for (const records::ColumnSpec& column : schema.columns) {
    v1::ColumnSchema* const out = message.add_columns();
    out->set_name(column.name);
    out->set_kind(column.is_text ? v1::COLUMN_KIND_TEXT : v1::COLUMN_KIND_NUMBER);
  }
  return message;
}

absl::StatusOr<records::SessionSchema> FromProto(const v1::SessionSchema& message) {
  records::SessionSchema schema;
  for (int i = 0; i < message.header_size(); ++i) {
    const v1::HeaderEntry& entry = message.header(i);
    RETURN_IF_ERROR(RequireText(absl::StrCat("header[", i, "].key"), entry.key(), 1, 255));
    schema.header.push_back({entry.key(), entry.value()});
  }
  if (message.columns_size() < 1 || message.columns_size() > kMaxColumns) {
    return FieldError("columns", absl::StrCat(message.columns_size(), " columns, must be 1 to ", kMaxColumns));
  }
  std::set<std::string> names;
  for (int i = 0; i < message.columns_size(); ++i) {
    const v1::ColumnSchema& column = message.columns(i);
    const std::string field = absl::StrCat("columns[", i, "]");
    RETURN_IF_ERROR(RequireText(field + ".name", column.name(), 1, 255));
    if (!names.insert(column.name()).second) return FieldError(field + ".name", "'" + column.name() + "' stands twice");
    if (column.kind() != v1::COLUMN_KIND_NUMBER && column.kind() != v1::COLUMN_KIND_TEXT) {
      return FieldError(field + ".kind", "must be NUMBER or TEXT");
    }
    schema.columns.push_back({column.name(), column.kind() == v1::COLUMN_KIND_TEXT});
  }
  return schema;
}

v1::SessionState ToProto(records::SessionState state) {
  switch (state) {
    case records::SessionState::kOpen:
      return v1::SESSION_STATE_OPEN;
    case records::SessionState::kComplete:
      return v1::SESSION_STATE_COMPLETE;
    case records::SessionState::kAborted:
      return v1::SESSION_STATE_ABORTED;
    case records::SessionState::kExpired:
      return v1::SESSION_STATE_EXPIRED;
  }
  return v1::SESSION_STATE_UNSPECIFIED;
}

absl::StatusOr<records::SessionState> FromProto(v1::SessionState state) {
  switch (state) {
    case v1::SESSION_STATE_OPEN:
      return records::SessionState::kOpen;
    case v1::SESSION_STATE_COMPLETE:
      return records::SessionState::kComplete;
    case v1::SESSION_STATE_ABORTED:
      return records::SessionState::kAborted;
    case v1::SESSION_STATE_EXPIRED:
      return records::SessionState::kExpired;
    default:
      return FieldError("state", absl::StrCat(static_cast<int>(state), ", must be OPEN, COMPLETE, ABORTED or EXPIRED"));
  }
}

v1::SessionRemark ToProto(const records::SessionRemark& remark) {
  v1::SessionRemark message;
  message.set_note(remark.note);
  for (const std::string& label : remark.labels) message.add_labels(label);
  message.set_is_rejected(remark.is_rejected);
  message.set_reason(remark.reason);
  message.set_etag(remark.etag);
  message.set_changed_by(remark.changed_by);
  message.set_changed_utc_us(base::ToUtcUs(remark.changed_at));
  return message;
}

records::SessionRemark FromProto(const v1::SessionRemark& message) {
  return {message.note(),
          {message.labels().begin(), message.labels().end()},
          message.is_rejected(),
          message.reason(),
          message.etag(),
          message.changed_by(),
          base::FromUtcUs(message.changed_utc_us())};
}

v1::Session ToProto(const records::SessionRecord& record) {
  v1::Session message;
  message.set_session_id(record.id.number());
  message.set_machine_id(record.machine.text());
  message.set_name(record.name);
  message.set_instrument(record.instrument);
  message.set_state(ToProto(record.state));
  message.set_next_seq(record.next_seq);
  message.set_readings(record.reading_count);
  message.set_created_utc_us(base::ToUtcUs(record.created_at));
  SET_OPTIONAL_UTC(message, closed_utc_us, record.closed_at);
  SET_OPTIONAL_UTC(message, measured_utc_us, record.measured_at);
  message.set_last_seen_utc_us(base::ToUtcUs(record.last_seen_at));
  message.set_created_by(record.created_by);
  message.set_sha256(record.hash);
  if (record.remark) *message.mutable_remark() = ToProto(*record.remark);
  return message;
}

absl::StatusOr<records::SessionRecord> FromProto(const v1::Session& message) {
  RETURN_IF_ERROR(RequirePositive("session_id", message.session_id()));
  RETURN_IF_ERROR(RequireText("machine_id", message.machine_id(), 1, 255));
  RETURN_IF_ERROR(RequireNotNegative("next_seq", message.next_seq()));
  RETURN_IF_ERROR(RequireNotNegative("readings", message.readings()));
  records::SessionRecord record;
  ASSIGN_OR_RETURN(record.state, FromProto(message.state()));
  record.id = SessionId(message.session_id());
  record.machine = MachineId(message.machine_id());
  record.name = message.name();
  record.instrument = message.instrument();
  record.next_seq = message.next_seq();
  record.reading_count = message.readings();
  record.created_at = base::FromUtcUs(message.created_utc_us());
  record.closed_at = OPTIONAL_UTC(message, closed_utc_us);
  record.measured_at = OPTIONAL_UTC(message, measured_utc_us);
  record.last_seen_at = base::FromUtcUs(message.last_seen_utc_us());
  record.created_by = message.created_by();
  record.hash = message.sha256();
  if (message.has_remark()) record.remark = FromProto(message.remark());
  return record;
}

v1::SessionTotals ToProto(const records::SessionTotals& totals) {
  v1::SessionTotals message;
  message.set_chunks(totals.chunk_count);
  message.set_readings(totals.reading_count);
  message.set_sha256(totals.hash);
  return message;
}

absl::StatusOr<records::SessionTotals> FromProto(const v1::SessionTotals& message) {
  RETURN_IF_ERROR(RequireNotNegative("chunks", message.chunks()));
  RETURN_IF_ERROR(RequireNotNegative("readings", message.readings()));
  RETURN_IF_ERROR(RequireSha256("sha256", message.sha256()));
  return records::SessionTotals{message.chunks(), message.readings(), message.sha256()};
}

}  // namespace axiscal::convert
