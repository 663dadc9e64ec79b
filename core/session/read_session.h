// The strict reader of session files (docs/formats.md). A file is read whole or refused: there is no partial session.
#ifndef AXISCAL_CORE_SESSION_READ_SESSION_H_
#define AXISCAL_CORE_SESSION_READ_SESSION_H_

#include <istream>
#include <string>

#include "core/base/status.h"
#include "core/session/session.h"

namespace axiscal::session {

// `name` stands in front of every message: "fit/00-BX.csv: line 12, column 3 (Y_mm): '1,5', expected ...".
// INVALID_ARGUMENT at anything that is not a session file: see instrument_format.h for the keys, columns and limits,
// line_reader.h for sizes. A last line without line end is refused too: a cut number cannot be told from a whole one.
// A UTF-8 byte-order mark is passed over.
absl::StatusOr<Session> ReadSession(std::istream& in, const std::string& name);
absl::StatusOr<Session> ReadSessionText(const std::string& text, const std::string& name);

// NOT_FOUND when there is no such file; a file beyond kMaxSessionBytes is refused before it is read.
absl::StatusOr<Session> ReadSessionFile(const std::string& path);

// The plan of a session, as `axiscal plan` writes it, or a measured session to be measured again: readings may be empty
// or missing, and are left out of the result, which is header, planned columns and axis positions. Errors as above.
absl::StatusOr<Session> ReadPlanText(const std::string& text, const std::string& name);
absl::StatusOr<Session> ReadPlanFile(const std::string& path);

}  // namespace axiscal::session

#endif  // AXISCAL_CORE_SESSION_READ_SESSION_H_
