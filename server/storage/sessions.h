// Rows of `session`, `session_header`, `session_column`. What each function returns: database.h.
#ifndef AXISCAL_SERVER_STORAGE_SESSIONS_H_
#define AXISCAL_SERVER_STORAGE_SESSIONS_H_

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

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_SESSIONS_H_
