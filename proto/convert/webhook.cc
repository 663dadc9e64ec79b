#include "proto/convert/webhook.h"

#include "proto/convert/access.h"
#include "proto/convert/field.h"
#include "proto/convert/time.h"

namespace axiscal::convert {
namespace {

constexpr size_t kMostWebhookNoteBytes = 1000;

}  // namespace

v1::Webhook ToProto(const records::Webhook& webhook) {
  v1::Webhook message;
  message.set_name(webhook.name);
  message.set_url(webhook.url);
  *message.mutable_scope() = ToProto(webhook.scope);
  message.set_disabled(!webhook.is_enabled);
  message.set_note(webhook.note);
  return message;
}

v1::Webhook ToProto(const records::WebhookRecord& record) {
  v1::Webhook message = ToProto(record.content);
  message.set_etag(record.etag);
  message.set_up_to_change_id(record.after_change);
  message.set_tries(record.tries);
  SET_OPTIONAL_UTC(message, next_try_utc_us, record.next_try_at);
  message.set_last_error(record.last_error);
  SET_OPTIONAL_UTC(message, last_sent_utc_us, record.last_sent_at);
  message.set_dead_letters(record.dead_letters);
  message.set_created_by(record.created_by);
  message.set_created_utc_us(base::ToUtcUs(record.created_at));
  message.set_changed_by(record.changed_by);
  message.set_changed_utc_us(base::ToUtcUs(record.changed_at));
  return message;
}

absl::StatusOr<records::Webhook> FromProto(const v1::Webhook& message) {
  records::Webhook webhook;
  RETURN_IF_ERROR(RequireAccessName("name", message.name()));
  webhook.name = message.name();
  webhook.url = message.url();
  ASSIGN_OR_RETURN(webhook.scope, FromProto(message.scope()));
  webhook.is_enabled = !message.disabled();
  RETURN_IF_ERROR(RequireText("note", message.note(), 0, kMostWebhookNoteBytes));
  webhook.note = message.note();
  return webhook;
}

absl::StatusOr<records::WebhookRecord> RecordFromProto(const v1::Webhook& message) {
  records::WebhookRecord record;
  ASSIGN_OR_RETURN(record.content, FromProto(message));
  record.etag = message.etag();
  record.after_change = message.up_to_change_id();
  record.tries = message.tries();
  record.next_try_at = OPTIONAL_UTC(message, next_try_utc_us);
  record.last_error = message.last_error();
  record.last_sent_at = OPTIONAL_UTC(message, last_sent_utc_us);
  record.dead_letters = message.dead_letters();
  record.created_by = message.created_by();
  record.created_at = base::FromUtcUs(message.created_utc_us());
  record.changed_by = message.changed_by();
  record.changed_at = base::FromUtcUs(message.changed_utc_us());
  return record;
}

v1::DeadLetter ToProto(const records::DeadLetter& letter) {
  v1::DeadLetter message;
  message.set_change_id(letter.change);
  message.set_event_id(letter.event.number());
  message.set_machine_id(letter.machine.text());
  message.set_tries(letter.tries);
  message.set_error(letter.error);
  message.set_tried_utc_us(base::ToUtcUs(letter.at));
  message.set_is_wanted(letter.is_wanted);
  return message;
}

absl::StatusOr<records::DeadLetter> FromProto(const v1::DeadLetter& message) {
  RETURN_IF_ERROR(RequirePositive("change_id", message.change_id()));
  return records::DeadLetter{message.change_id(),
                             EventId(message.event_id()),
                             MachineId(message.machine_id()),
                             message.tries(),
                             message.error(),
                             base::FromUtcUs(message.tried_utc_us()),
                             message.is_wanted()};
}

}  // namespace axiscal::convert
