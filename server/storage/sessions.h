// Rows of `session`, `session_header`, `session_column`. What each function returns: database.h.
#ifndef AXISCAL_SERVER_STORAGE_SESSIONS_H_
#define AXISCAL_SERVER_STORAGE_SESSIONS_H_

#include <optional>
#include <vector>

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// `damaged`: sessions of that request that do not count.
absl::StatusOr<SessionRecord> CreateSession(Connection& connection, const Moment& now, const NewSession& session,
                                            const std::vector<SessionId>& damaged);
// DATA_LOSS SESSION_DAMAGED unless machine, header and columns are those that the session was created with.
absl::Status CheckSessionBody(Connection& connection, const SessionRecord& session);
// DATA_LOSS SESSION_DAMAGED where its columns are lost; in lists such a session has none.
absl::StatusOr<SessionRecord> GetSession(Connection& connection, SessionId id);
absl::StatusOr<std::vector<ColumnSpec>> GetSessionColumns(Connection& connection, SessionId id);
absl::StatusOr<Page<SessionRecord>> ListSessions(Connection& connection, const SessionFilter& filter,
                                                 const PageRequest& request, const Visible& visible);
absl::StatusOr<SessionRecord> FinishSession(Connection& connection, UtcTime now, SessionId id,
                                            const SessionTotals& totals);
absl::StatusOr<SessionRecord> AbortSession(Connection& connection, UtcTime now, SessionId id);
absl::StatusOr<int> ExpireSessions(Connection& connection, const Moment& now, std::chrono::microseconds idle);

struct ExpiredReadings {
  int count = 0;                   // sessions that are EXPIRED now
  std::optional<SessionId> after;  // where to go on; nothing: all were looked at
};
// Of the complete sessions behind `after`, some at a time, those of at least this age of up time become EXPIRED, unless
// a calibration stands on them or a job of their machine has not ended. Their chunks stay until DropExpiredChunks().
absl::StatusOr<ExpiredReadings> ExpireReadings(Connection& connection, const Moment& now, std::chrono::microseconds age,
                                               SessionId after);
// Removes some chunks of EXPIRED sessions, the last ones first; how many, 0 when there are none.
absl::StatusOr<int> DropExpiredChunks(Connection& connection);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_SESSIONS_H_
