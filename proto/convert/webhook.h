// Webhooks and dead letters on the wire; secrets stay out of them.
#ifndef AXISCAL_PROTO_CONVERT_WEBHOOK_H_
#define AXISCAL_PROTO_CONVERT_WEBHOOK_H_

#include "axiscal/v1/webhooks_service.pb.h"
#include "core/base/status.h"
#include "core/records/webhook.h"

namespace axiscal::convert {

v1::Webhook ToProto(const records::Webhook& webhook);
v1::Webhook ToProto(const records::WebhookRecord& record);
// What a person says of it. FIELD_INVALID with the field's path: a name that is none, no scope, a note that is too
// long. The URL is not looked at.
absl::StatusOr<records::Webhook> FromProto(const v1::Webhook& message);
// As a server sends it; without its id.
absl::StatusOr<records::WebhookRecord> RecordFromProto(const v1::Webhook& message);

v1::DeadLetter ToProto(const records::DeadLetter& letter);
absl::StatusOr<records::DeadLetter> FromProto(const v1::DeadLetter& message);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_WEBHOOK_H_
