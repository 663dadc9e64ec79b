#include "server/storage/up_time.h"

namespace axiscal::storage {

absl::StatusOr<std::chrono::microseconds> ReadUpTime(Connection& connection) {
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT max(up_us, "
                                  "coalesce((SELECT max(last_seen_up_us) FROM session WHERE state = 1), 0), "
                                  "coalesce((SELECT max(last_seen_up_us) FROM program WHERE state = 1), 0), "
                                  "coalesce((SELECT max(waits_from_up_us) FROM job WHERE state = 1), 0)) "
                                  "FROM up_time WHERE id = 1"));
  RETURN_IF_ERROR(row.Step().status());
  return std::chrono::microseconds(row.Int(0));
}

absl::Status SaveUpTime(Connection& connection, std::chrono::microseconds up) {
  return connection.Run("UPDATE up_time SET up_us = ?1 WHERE id = 1", static_cast<int64_t>(up.count()));
}

}  // namespace axiscal::storage
