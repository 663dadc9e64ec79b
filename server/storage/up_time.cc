#include "server/storage/up_time.h"

namespace axiscal::storage {

absl::StatusOr<std::chrono::microseconds> ReadUpTime(Connection& connection) {
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT max(up_us) FROM (SELECT up_us FROM up_time WHERE id = 1 "
                                  "UNION ALL SELECT max(last_seen_up_us) FROM session WHERE state = 1 "
                                  "UNION ALL SELECT max(last_seen_up_us) FROM program WHERE state = 1 "
                                  "UNION ALL SELECT max(reported_at_up_us) FROM cell "
                                  "UNION ALL SELECT max(waits_from_up_us) FROM job WHERE state = 1) AS stamp"));
  RETURN_IF_ERROR(row.Step().status());
  return std::chrono::microseconds(row.Int(0));
}

absl::Status SaveUpTime(Connection& connection, std::chrono::microseconds up) {
  return connection.Run("UPDATE up_time SET up_us = ?1 WHERE id = 1 AND up_us < ?1", static_cast<int64_t>(up.count()));
}

absl::StatusOr<std::chrono::microseconds> KeepUpTime(Connection& connection, std::chrono::microseconds up) {
  RETURN_IF_ERROR(SaveUpTime(connection, up));
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT up_us FROM up_time WHERE id = 1"));
  RETURN_IF_ERROR(row.Step().status());
  return std::chrono::microseconds(row.Int(0));
}

absl::Status MarkAge(Connection& connection, std::chrono::microseconds up) {
  const int64_t now_us = up.count(), day_us = std::chrono::microseconds(std::chrono::days(1)).count();
  return connection.Run(
      "INSERT INTO age_mark (up_us, audit_id, session_id) SELECT ?1, "
      "coalesce((SELECT max(id) FROM audit), 0), "
      "coalesce((SELECT max(id) FROM session), 0) "
      "WHERE coalesce((SELECT max(up_us) FROM age_mark), ?2) <= ?2",
      now_us, now_us - day_us);
}

absl::StatusOr<AgeMark> MarkBefore(Connection& connection, const Moment& now, std::chrono::microseconds age) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT audit_id, session_id FROM age_mark WHERE up_us <= ?1 "
                                                 "ORDER BY up_us DESC LIMIT 1",
                                                 now.up_us - static_cast<int64_t>(age.count())));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  return found ? AgeMark{row.Int(0), row.Int(1)} : AgeMark{};
}

}  // namespace axiscal::storage
