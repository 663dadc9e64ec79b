// Rows of `session_remark` and `session_label`: what people say of sessions. What each function returns: database.h.
#ifndef AXISCAL_SERVER_STORAGE_SESSION_REMARKS_H_
#define AXISCAL_SERVER_STORAGE_SESSION_REMARKS_H_

#include <optional>
#include <string>
#include <vector>

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// Nothing where nobody has said anything.
absl::StatusOr<std::optional<records::SessionRemark>> ReadRemark(Connection& connection, SessionId id);
// Those of the calibration's sessions that were rejected, in its order.
absl::StatusOr<std::vector<SessionId>> RejectedSessionsOf(Connection& connection, CalibrationId calibration);

absl::StatusOr<SessionRecord> AnnotateSession(Connection& connection, UtcTime now, SessionId id,
                                              const std::string& note, const std::vector<std::string>& labels,
                                              int64_t expected_etag, const Caller& caller);
absl::StatusOr<RejectedSession> RejectSession(Connection& connection, UtcTime now, SessionId id, bool is_rejected,
                                              const std::string& reason, const Caller& caller);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_SESSION_REMARKS_H_
