// How conversions refuse: INVALID_ARGUMENT, reason FIELD_INVALID, with the field's path as fact `field`, which becomes
// a google.rpc.BadRequest violation on the wire.
#ifndef AXISCAL_PROTO_CONVERT_FIELD_H_
#define AXISCAL_PROTO_CONVERT_FIELD_H_

#include <string>

#include "core/base/status.h"

namespace axiscal::convert {

// "tool_tip_mm: 2 numbers, must be 3".
absl::Status FieldError(const std::string& field, const std::string& rule);

// OK, or what is wrong.
absl::Status RequireFinite(const std::string& field, double value);
absl::Status RequirePositive(const std::string& field, int64_t value);
absl::Status RequireNotNegative(const std::string& field, int64_t value);
// `min` to `max` bytes of UTF-8, no control characters.
absl::Status RequireText(const std::string& field, const std::string& text, size_t min, size_t max);
// 64 lower-case hexadecimal digits.
absl::Status RequireSha256(const std::string& field, const std::string& text);
// records::IsAccessName(): names of principals, groups, routines, webhooks, labels.
absl::Status RequireAccessName(const std::string& field, const std::string& name);
// Of a repeated field: at most `max` entries.
absl::Status RequireAtMost(const std::string& field, int count, int max);
// OK when present.
absl::Status RequireMessage(const std::string& field, bool present);

// The same status with `parent.` before its field: "job.params.identify.session_ids[1]". Other statuses stay.
absl::Status InField(const std::string& parent, const absl::Status& status);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_FIELD_H_
