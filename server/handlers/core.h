// What every handler gets: the service's parts, and who calls. Handlers convert, call one function, convert back; they
// hold no state and know no gRPC.
#ifndef AXISCAL_SERVER_HANDLERS_CORE_H_
#define AXISCAL_SERVER_HANDLERS_CORE_H_

#include <atomic>
#include <chrono>
#include <functional>
#include <string>

#include "core/base/status.h"
#include "server/handlers/held_calls.h"
#include "server/jobs/job_runner.h"
#include "server/storage/database.h"

namespace axiscal::handlers {

struct Limits {
  HeldLimits held;
  int window_chunks = 8;  // chunks of one stream under way to the disk
};

// Lives as long as the server. Safe from any thread.
struct Core {
  storage::Database& database;
  jobs::JobRunner& jobs;
  Limits limits;
  int workers = 0;
  std::atomic<int> open_calls = 0;
  HeldCalls held{};
  std::atomic<bool> draining = false;
};

// One call.
struct Call {
  std::string user;                                           // as the caller says
  std::function<bool()> is_cancelled = [] { return false; };  // the caller has left, or its time is over
  std::function<void()> cut_off = [] {};                      // ends a stream from another thread
};

// UNAVAILABLE DRAINING while the server stops: for calls that begin new work.
absl::Status RequireAccepting(const Core& core);

// Page sizes and tokens as the API has them. INVALID_ARGUMENT PAGE_INVALID when negative.
absl::StatusOr<records::PageRequest> PageFrom(int page_size, const std::string& page_token);

// 1 to 64 printable characters.
absl::Status RequireRequestId(const std::string& request_id);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_CORE_H_
