// What every handler gets: the service's parts, and who calls. Handlers convert, call one function, convert back; they
// hold no state and know no gRPC.
#ifndef AXISCAL_SERVER_HANDLERS_CORE_H_
#define AXISCAL_SERVER_HANDLERS_CORE_H_

#include <google/protobuf/message.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "server/access/gate.h"
#include "server/handlers/held_calls.h"
#include "server/handlers/open_calls.h"
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
  access::Gate gate{database, false};
  Limits limits;
  int workers = 0;
  std::atomic<int> open_calls = 0;
  HeldCalls held{};
  OpenCalls open{};
  std::atomic<bool> draining = false;
  // The login of a caller on this machine, by its gRPC peer.
  std::function<std::string(const std::string& peer)> login_of = [](const std::string&) { return "unknown"; };
};

// One call.
struct Call {
  std::string user;                                           // the principal's name, or "local:LOGIN"
  std::vector<records::Grant> grants = {};                    // its roles
  storage::Visible visible = {};                              // what lists may show it
  std::function<bool()> is_cancelled = [] { return false; };  // the caller has left, or its time is over
  std::function<void()> cut_off = [] {};                      // ends a stream from another thread
  // Whether the caller may have what the first message of a stream names. Of other calls it was asked before.
  std::function<absl::Status(const google::protobuf::Message&)> admit = [](const auto&) { return absl::OkStatus(); };
};

// UNAVAILABLE DRAINING while the server stops: for calls that begin new work.
absl::Status RequireAccepting(const Core& core);

// Page sizes and tokens as the API has them. INVALID_ARGUMENT PAGE_INVALID when negative.
absl::StatusOr<records::PageRequest> PageFrom(int page_size, const std::string& page_token);

// 1 to 64 printable characters.
absl::Status RequireRequestId(const std::string& request_id);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_CORE_H_
