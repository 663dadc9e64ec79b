// Session files (docs/formats.md) written so that they read back bit-equal: each number is the shortest decimal that
// reads back as the same double.
#ifndef AXISCAL_CORE_SESSION_WRITE_SESSION_H_
#define AXISCAL_CORE_SESSION_WRITE_SESSION_H_

#include <string>

#include "core/base/status.h"
#include "core/session/session.h"

namespace axiscal::session {

// The text of the file, LF line ends. INVALID_ARGUMENT when the session breaks a rule of session files (see Validate):
// so what is written can be read back.
absl::StatusOr<std::string> WriteSession(const Session& session);

// The same into a file, whole or not at all; see base::WriteFileAtomically.
absl::Status WriteSessionFile(const Session& session, const std::string& path);

}  // namespace axiscal::session

#endif  // AXISCAL_CORE_SESSION_WRITE_SESSION_H_
