// The rules of a session file (docs/formats.md) applied to a session in memory: what comes over the wire or out of a
// program is held to the same rules as a file, and messages name the place that it would have in the file.
#ifndef AXISCAL_CORE_SESSION_VALIDATE_H_
#define AXISCAL_CORE_SESSION_VALIDATE_H_

#include "core/base/status.h"
#include "core/session/session.h"

namespace axiscal::session {

// OK when the session could have been read from a file: header, columns, at least one reading, equal lengths, every
// cell within its rule, time that never runs back.
absl::Status Validate(const Session& session);

}  // namespace axiscal::session

#endif  // AXISCAL_CORE_SESSION_VALIDATE_H_
