// JSON as users write it by hand: RFC 8259 with nothing hidden. Duplicate keys are refused (most parsers keep the last
// one in silence) and syntax errors name line and column.
#ifndef AXISCAL_CORE_BASE_STRICT_JSON_H_
#define AXISCAL_CORE_BASE_STRICT_JSON_H_

#include <nlohmann/json.hpp>
#include <string>

#include "core/base/json_limits.h"
#include "core/base/status.h"

namespace axiscal::base {

// The document, members in the order of the text. INVALID_ARGUMENT: "line 3, column 7: ..." at a syntax error, "'X' is
// there twice" at a duplicate key, or the limit (`max_bytes`, kMaxJsonDepth) that is exceeded. Throws nothing.
absl::StatusOr<nlohmann::ordered_json> ParseStrictJson(const std::string& text, size_t max_bytes = kMaxJsonBytes);

// The value as it would be written, cut after 60 characters: for messages.
std::string ShortJson(const nlohmann::ordered_json& value);

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_STRICT_JSON_H_
