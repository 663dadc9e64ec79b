// How long a server has had this file open, over all the times that one had: what expiry and waits are counted in. A
// wall clock may be set; a steady clock begins anew with the machine. Where several processes share a store, each
// counts by its own steady clock and goes by the one that is furthest (KeepUpTime()): the row says how far that was.
#ifndef AXISCAL_SERVER_STORAGE_UP_TIME_H_
#define AXISCAL_SERVER_STORAGE_UP_TIME_H_

#include <chrono>

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// Where counting goes on after the file is opened: what was saved, but behind no stamp of a row that is open or waits,
// so that after a crash, which saves nothing, none of them lies in the future.
absl::StatusOr<std::chrono::microseconds> ReadUpTime(Connection& connection);
// Never back: another process may be further.
absl::Status SaveUpTime(Connection& connection, std::chrono::microseconds up);
// Saves it, and gives what stands there then: `up`, or how far another process is.
absl::StatusOr<std::chrono::microseconds> KeepUpTime(Connection& connection, std::chrono::microseconds up);

// The newest rows at some time.
struct AgeMark {
  int64_t audit_id = 0, session_id = 0;  // 0: none
};
// Notes which rows are the newest now; once a day of up time. What retention removes goes by these marks.
absl::Status MarkAge(Connection& connection, std::chrono::microseconds up);
// Rows up to these were there `age` of up time ago, give or take a day: none is younger.
absl::StatusOr<AgeMark> MarkBefore(Connection& connection, const Moment& now, std::chrono::microseconds age);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_UP_TIME_H_
