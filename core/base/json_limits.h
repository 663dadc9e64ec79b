// What is asked of every JSON text that users bring; its readers are in strict_json.h.
#ifndef AXISCAL_CORE_BASE_JSON_LIMITS_H_
#define AXISCAL_CORE_BASE_JSON_LIMITS_H_

#include <string>

#include "core/base/status.h"

namespace axiscal::base {

inline constexpr size_t kMaxJsonBytes = 4 << 20;
inline constexpr int kMaxJsonDepth = 16;

// OK for text that ParseStrictJson reads; its error otherwise.
absl::Status CheckJson(const std::string& text);

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_JSON_LIMITS_H_
