// The rules of a session's header lines. Header entry i stands in line i + 1 of the session's file; messages say so.
#ifndef AXISCAL_CORE_SESSION_HEADER_RULES_H_
#define AXISCAL_CORE_SESSION_HEADER_RULES_H_

#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/session/instrument_format.h"
#include "core/session/session.h"

namespace axiscal::session {

inline constexpr size_t kMaxHeaderEntries = 1000;
inline constexpr size_t kMaxNameBytes = 100;

// The line, from 1, of header entry `index` (from 0).
inline size_t HeaderLine(size_t index) { return index + 1; }

// OK when every required key is there once with a value of its form, every entry is plain UTF-8, and optional keys have
// their form. Unknown keys pass. INVALID_ARGUMENT: "line 4: sigma_um: '0', expected ...".
absl::Status ValidateHeader(const std::vector<HeaderEntry>& header);

// The axes of `# datum: free X Z`. INVALID_ARGUMENT when `value` is anything else than "free" and names of axes, each
// once.
absl::StatusOr<std::vector<std::string>> ParseDatum(const std::string& value);

// The rule whose prefix `key` has ("plane top": plane), or nullptr.
const FeatureRule* FindFeatureRule(const InstrumentFormat& format, const std::string& key);

}  // namespace axiscal::session

#endif  // AXISCAL_CORE_SESSION_HEADER_RULES_H_
