// What is expected of machines, and events, on the wire.
#ifndef AXISCAL_PROTO_CONVERT_EVENT_H_
#define AXISCAL_PROTO_CONVERT_EVENT_H_

#include "axiscal/v1/events_service.pb.h"
#include "core/base/status.h"
#include "core/records/event.h"

namespace axiscal::convert {

v1::Expectations ToProto(const records::Expectations& expected);
// Without its machine. FIELD_INVALID with the field's path: an error or session without a name or there twice, a low
// that is not below its high, a number out of range, too many.
absl::StatusOr<records::Expectations> FromProto(const v1::Expectations& message);

v1::Event ToProto(const records::Event& event);
// FIELD_INVALID: a unit that is none. Kinds of newer servers are read as their number.
absl::StatusOr<records::Event> FromProto(const v1::Event& message);

v1::EventChange ToProto(const records::EventChange& change);
absl::StatusOr<records::EventChange> FromProto(const v1::EventChange& message);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_EVENT_H_
