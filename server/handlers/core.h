// What every handler gets: the service's parts, and who calls. Handlers convert, call one function, convert back; they
// hold no state and know no gRPC.
#ifndef AXISCAL_SERVER_HANDLERS_CORE_H_
#define AXISCAL_SERVER_HANDLERS_CORE_H_

#include <google/protobuf/message.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/records/diagnosis.h"
#include "server/access/forwarded.h"
#include "server/access/gate.h"
#include "server/access/known_peers.h"
#include "server/handlers/budget.h"
#include "server/handlers/calibration_fit.h"
#include "server/handlers/call_rates.h"
#include "server/handlers/held_calls.h"
#include "server/handlers/open_calls.h"
#include "server/handlers/volumetric_cache.h"
#include "server/jobs/job_runner.h"
#include "server/metrics/metrics.h"
#include "server/storage/database.h"
#include "server/watch/event_board.h"

namespace axiscal::webhooks {
class Sender;
}

namespace axiscal::handlers {

struct Limits {
  HeldLimits held;
  int window_chunks = 8;                         // chunks of one stream under way to the disk
  int64_t max_session_readings = 50'000'000;     // of one session: 14 hours at 1 kHz
  int64_t max_program_bytes = int64_t{1} << 30;  // of one program
  std::string backup_folder = {};                // where backups stay; empty: nowhere
  int measured_machines = 0;                     // that metrics name, those with most open events
  std::string database_file = {};                // empty: the database is a server's, and has no file here
};

// Ten times as many as a dashboard that is looked at by many makes, a tenth of what one core serves.
inline constexpr int kDefaultCallsPerSecond = 1000;

struct Call;

// Lives as long as the server. Safe from any thread.
struct Core {
  storage::Database& database;
  jobs::JobRunner& jobs;
  access::Gate gate{database, false};
  Limits limits;
  int workers = 0;
  std::atomic<int> open_calls = 0;
  HeldCalls held{};
  CallRates rates{kDefaultCallsPerSecond};
  CallRates told_refusals{1};  // of those that are refused for calling too often, so many stand in the log
  // Bytes of logs that are reduced, and what is made of them; room for the longest log of one caller.
  Budget reducing{((int64_t{1} << 30) / Budget::kMostOfOne + 1) * (Budget::kMostOfOne + 1)};
  OpenCalls open{};
  access::ForwardedCalls forwarded{};
  access::KnownPeers known{};
  // Told of each call that was denied.
  std::function<void(const Call& call, const std::string& method, const absl::Status& status)> denied =
      [](const auto&...) {};
  std::atomic<bool> draining = false;
  std::atomic<bool> is_backing_up = false;
  // The login of a caller on this machine, by its gRPC peer.
  std::function<std::string(const std::string& peer)> login_of = [](const std::string&) { return "unknown"; };
  // Told of changes of events, for those who watch them.
  std::shared_ptr<watch::EventBoard> events = std::make_shared<watch::EventBoard>();
  // Counts calls, jobs and readings.
  std::shared_ptr<metrics::Metrics> metrics =
      std::make_shared<metrics::Metrics>("", std::vector<metrics::Method>(), std::vector<std::string>());
  // The files of TLS and when their certificates end.
  std::function<std::vector<std::pair<std::string, base::UtcTime>>()> certificates = [] {
    return std::vector<std::pair<std::string, base::UtcTime>>();
  };
  // Files beside the database that nobody else on the machine may read: keys.
  std::vector<std::string> private_files = {};
  // Sets how much is written to the log, where it is given; what holds now.
  std::function<records::LogLevel(std::optional<records::LogLevel> level)> log_level = [](const auto&) {
    return records::LogLevel::kInfo;
  };
  // Told of machines of which something has changed that events follow from (server/watch).
  std::function<void(const MachineId& machine)> look_soon = [](const auto&) {};
  // Told of machines on which a session is complete, or of which a person has said something of a routine; and of
  // routines that were changed (server/routines).
  std::function<void(const MachineId& machine)> run_soon = [](const auto&) {};
  std::function<void()> run_all_soon = [] {};
  // What calibrations' sessions read without and with their errors.
  std::shared_ptr<CalibrationFits> fits = std::make_shared<CalibrationFits>();
  std::shared_ptr<VolumetricCache> volumetric = std::make_shared<VolumetricCache>();
  // Absent where no webhooks are sent.
  webhooks::Sender* webhook_sender = nullptr;
};

// One call.
struct Call {
  std::string user;                                           // the principal's name, or "local:LOGIN"
  std::vector<records::Grant> grants = {};                    // its roles
  storage::Visible visible = {};                              // what lists may show it
  std::string peer = {};                                      // from where: the address without its port
  std::string trace = {};                                     // its traceparent; empty: none that is one
  std::string counted_as = {};                                // the principal whose streams are counted; empty: none
  std::function<bool()> is_cancelled = [] { return false; };  // the caller has left, or its time is over
  std::function<void()> cut_off = [] {};                      // ends a stream from another thread
  // Whether the caller may have what the first message of a stream names. Of other calls it was asked before.
  std::function<absl::Status(const google::protobuf::Message&)> admit = [](const auto&) { return absl::OkStatus(); };

  // The caller as the store writes it down.
  storage::Caller By(const std::string& request_id = "") const { return {user, request_id, peer}; }
};

// W3C Trace Context: metadata, or a field of HTTP, that names the call of which this one is a part. Of such texts
// alone: "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01".
inline constexpr char kTraceKey[] = "traceparent";
bool IsTraceParent(const std::string& text);

// The caller with the reason that it gives; FIELD_INVALID "reason" of more than 200 bytes.
absl::StatusOr<storage::Caller> ByWithReason(const Call& call, const std::string& reason);

// UNAVAILABLE DRAINING while the server stops: for calls that begin new work.
absl::Status RequireAccepting(const Core& core);

// Page sizes and tokens as the API has them. INVALID_ARGUMENT PAGE_INVALID when negative.
absl::StatusOr<records::PageRequest> PageFrom(int page_size, const std::string& page_token);

// INVALID_ARGUMENT RANGE_INVALID, with the field, where it ends before it begins.
absl::Status RequireSpan(const records::TimeSpan& span);

// The page, and those behind it as long as they hold nothing: what a list is held to may fit none of the rows that one
// page looks at. `list` gives the page of a PageRequest.
template <typename List>
auto FirstWithRows(const Call& call, records::PageRequest page, const List& list) -> decltype(list(page)) {
  while (true) {
    auto rows = list(page);
    if (!rows.ok() || !rows->rows.empty() || rows->next_token.empty() || call.is_cancelled()) return rows;
    page.token = rows->next_token;
  }
}

// 1 to 64 printable characters.
constexpr size_t kMaxRequestIdBytes = 64;
absl::Status RequireRequestId(const std::string& request_id);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_CORE_H_
