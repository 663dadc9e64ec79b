#include "server/server.h"

#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <optional>
#include <set>
#include <thread>

#include "absl/strings/str_join.h"
#include "core/base/clock.h"
#include "core/base/demand.h"
#include "core/base/error_detail.h"
#include "core/base/mutex.h"
#include "proto/convert/job_params.h"
#include "server/call_guard.h"
#include "server/handlers/get_server_info.h"
#include "server/jobs/close_loop_job.h"
#include "server/jobs/compensate_job.h"
#include "server/jobs/identify_job.h"
#include "server/jobs/job_runner.h"
#include "server/jobs/tool_setter_job.h"
#include "server/listener.h"
#include "server/local_login.h"
#include "server/log.h"
#include "server/service.h"
#include "server/storage/file_mode.h"
#include "server/storage/sqlite_database.h"
#include "server/tls.h"

namespace axiscal::server {
namespace {

constexpr int kKeepaliveMs = 20'000, kKeepaliveTimeoutMs = 10'000;
// How often the end of the last call is looked for, and how long connections may take to hear of the end.
constexpr std::chrono::milliseconds kLookAgain(5), kGoodbye(100);
// How often uploads that were left are looked for. A crash loses so much of the time that counts for them.
constexpr std::chrono::minutes kHousekeeping(10);
// Clients may ask so often whether we are there; more often they are sent away.
constexpr int kMinPingIntervalMs = 10'000;
// Within so long a new connection must have begun to speak HTTP/2.
constexpr int kHandshakeMs = 20'000;

// Health is a plugin of the process, to be chosen before the first server is built. Server reflection is one, too, and
// on in every process that links its library: this one does not, as it would tell anybody the API.
void ChoosePlugins() {
  static const bool chosen = [] {
    grpc::EnableDefaultHealthCheckService(true);
    return true;
  }();
  static_cast<void>(chosen);
}

bool Asks(const ServerOptions& options) { return options.asks_identity || options.tls.is_set(); }

LogLevel LevelOf(const std::string& outcome) {
  if (outcome == "DEAD") return LogLevel::kError;
  return outcome.empty() || outcome == "SUCCEEDED" || outcome == "CANCELLED" || outcome == "PARKED"
             ? LogLevel::kInfo
             : LogLevel::kWarning;
}

void LogJob(const jobs::JobEvent& event) {
  const records::JobRecord& job = event.job;
  LogFields fields = {{"job", absl::StrCat(job.id.number())},
                      {"kind", job.kind},
                      {"machine", job.machine ? job.machine->text() : ""},
                      {"attempt", absl::StrCat(job.attempt)}};
  const bool is_over = event.what != jobs::JobEvent::What::kStarted;
  if (is_over) fields.push_back({"outcome", event.outcome});
  if (event.took) fields.push_back({"ms", absl::StrFormat("%.3f", static_cast<double>(event.took->count()) / 1e3)});
  if (is_over && job.error && job.state != records::JobState::kSucceeded) {
    fields.push_back({"reason", job.error->reason});
    fields.push_back({"text", job.error->message});
  }
  const bool is_lost = event.what == jobs::JobEvent::What::kLost;
  Log(LevelOf(event.outcome), !is_over ? "job_start" : is_lost ? "job_lost" : "job_end", fields);
}

void LogTls(const absl::Status& taken) {
  if (taken.ok()) {
    Log(LogLevel::kInfo, "tls_reloaded", {{"text", "new certificate, key and authorities hold for new connections"}});
  } else {
    Log(LogLevel::kWarning, "tls_kept",
        {{"text", std::string(taken.message())}, {"then", "what was in use stays in use until all files fit"}});
  }
}

void SetChannelArguments(const ServerOptions& options, grpc::ServerBuilder& builder) {
  // The bandwidth probe lets gRPC read megabytes ahead of us per stream; a fixed window bounds memory and latency.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, options.window_bytes);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveMs);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepaliveTimeoutMs);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, kMinPingIntervalMs);
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, kHandshakeMs);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, static_cast<int>(options.connection_idle.count()));
  builder.SetMaxReceiveMessageSize(handlers::kMaxMessageBytes);
  // gRPC holds the compressed size against that limit, and 1 MB of gzip makes 1 GB of zeros. Readings and programs gain
  // little from it on the wire.
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
}

}  // namespace

absl::Status Validate(const ServerOptions& options) {
  const auto refuse = [](const std::string& text) { return absl::InvalidArgumentError(text); };
  if (options.database_path.empty()) return refuse("database_path is empty, must name a file");
  if (options.workers < 1 || options.workers > kMaxWorkers) {
    return refuse(absl::StrCat("workers = ", options.workers, ", must be 1 to ", kMaxWorkers, ": each uses one core"));
  }
  if (options.max_uploads < 1 || options.max_uploads > kMaxUploads) {
    return refuse(absl::StrCat("max_uploads = ", options.max_uploads, ", must be 1 to ", kMaxUploads));
  }
  const std::chrono::milliseconds longest = std::chrono::hours(24);
  for (const auto& [name, time] :
       {std::pair("silence", options.silence), {"connection_idle", options.connection_idle}}) {
    if (time.count() >= 1 && time <= longest) continue;
    return refuse(absl::StrCat(name, " = ", time.count(), " ms, must be 1 to ", longest.count()));
  }
  if (options.window_bytes < kMinWindowBytes || options.window_bytes > kMaxWindowBytes) {
    return refuse(
        absl::StrCat("window_bytes = ", options.window_bytes, ", must be ", kMinWindowBytes, " to ", kMaxWindowBytes));
  }
  if (options.session_expiry.count() < 1) return refuse("session_expiry must be > 0");
  if (options.drain.count() < 0) return refuse(absl::StrCat("drain = ", options.drain.count(), " ms, must be >= 0"));
  return absl::OkStatus();
}

class Server::Impl {
 public:
  Impl(const ServerOptions& options, std::unique_ptr<storage::Database> database)
      : options_(options),
        database_(std::move(database)),
        runner_(*database_, RunnerOptions(options)),
        core_{.database = *database_,
              .jobs = runner_,
              .gate = {*database_, Asks(options)},
              .limits = {.held = {.max_uploads = options.max_uploads,
                                  .max_rewrites = options.workers,
                                  .silence = options.silence}},
              .workers = options.workers} {
    // Monte Carlo of a hundred thousand runs.
    runner_.Register(records::kIdentify, {jobs::IdentifyJob(*database_), std::chrono::hours(1)});
    runner_.Register(records::kCompensate, {jobs::CompensateJob(*database_)});
    runner_.Register(records::kToolSetter, {jobs::ToolSetterJob(*database_), std::chrono::minutes(10)});
    // Thousands of candidates, and a full refit after each effect.
    runner_.Register(records::kCloseLoop, {jobs::CloseLoopJob(*database_), std::chrono::hours(1)});
  }

  absl::Status Start() {
    ChoosePlugins();
    GuardCalls(core_.limits.held);
    grpc::ServerBuilder builder;
    SetChannelArguments(options_, builder);
    if (!options_.listen_address.empty()) {
      ASSIGN_OR_RETURN(listener_, Listener::Open(options_.listen_address));
      if (!listener_->is_local_only() && !options_.tls.is_set()) return Unprotected(options_.listen_address);
      std::shared_ptr<grpc::ServerCredentials> credentials = grpc::InsecureServerCredentials();
      if (options_.tls.is_set()) {
        ASSIGN_OR_RETURN(tls_, Tls::Create(options_.tls, LogTls));
        credentials = Tls::Credentials(tls_);
      }
      port_ = listener_->port();
      connections_ = builder.experimental().AddExternalConnectionAcceptor(
          grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD, credentials);
    }
    services_ = MakeServices(core_);
    for (const std::unique_ptr<grpc::Service>& service : services_) builder.RegisterService(service.get());
    server_ = builder.BuildAndStart();
    if (server_ == nullptr) {
      return base::Error(absl::StatusCode::kUnavailable, "gRPC does not start", {"LISTEN_FAILED", {}});
    }
    core_.login_of = [this](const std::string& peer) { return LoginOf(peer); };
    if (listener_ != nullptr) StartListening();
    if (core_.gate.asks()) asker_ = std::thread([this] { AskAgain(); });
    runner_.Start();
    housekeeper_ = std::thread([this] { KeepHouse(); });
    return absl::OkStatus();
  }

  ~Impl() { Shutdown(); }

  void Shutdown() {
    const base::MutexLock lock(shutdown_mutex_);
    if (server_ == nullptr) return;
    Log(LogLevel::kInfo, "drain", {});
    server_->GetHealthCheckService()->SetServingStatus(false);
    core_.draining = true;
    const base::SteadyTime deadline = base::SystemClock().SteadyNow() + options_.drain;
    // Jobs first: those who watch them see how they end.
    runner_.Drain(options_.drain);
    while (core_.open_calls > 0 && base::SystemClock().SteadyNow() < deadline) std::this_thread::sleep_for(kLookAgain);
    if (listener_ != nullptr) listener_->Stop();
    // What is still open is cut off; its callers resume elsewhere or later. Without calls a connection alone would hold
    // the shutdown up to its deadline: an idle client hears of the end only when it calls again.
    server_->Shutdown(std::chrono::system_clock::now() + kGoodbye);
    server_.reset();
    StopHousekeeper();
    Log(LogLevel::kInfo, "stopped", {});
  }

  const ServerOptions options_;
  int port_ = 0;
  std::unique_ptr<storage::Database> database_;
  jobs::JobRunner runner_;
  handlers::Core core_;
  std::vector<std::unique_ptr<grpc::Service>> services_;
  std::unique_ptr<Listener> listener_;
  std::shared_ptr<Tls> tls_;
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> connections_;
  std::unique_ptr<grpc::Server> server_;
  base::Mutex shutdown_mutex_;

 private:
  void StartListening() {
    listener_->Start(
        [this](int listening, int connection) {
          grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
          parameters.listener_fd = listening;
          parameters.fd = connection;
          connections_->HandleNewConnection(&parameters);
        },
        [](int64_t refused) {
          Log(LogLevel::kWarning, "connections_refused",
              {{"so_far", absl::StrCat(refused)},
               {"text", "too few descriptors: close idle clients or raise the limit"}});
        });
  }

  // Drops what uploaders have left, now and every kHousekeeping.
  void KeepHouse() {
    const base::MutexLock lock(housekeeper_mutex_);
    while (!stop_housekeeper_) {
      LogExpired("sessions", database_->ExpireSessions(options_.session_expiry));
      WarnOfCertificates();
      LogExpired("programs", database_->ExpirePrograms(options_.session_expiry));
      const base::SteadyTime next = base::SystemClock().SteadyNow() + kHousekeeping;
      while (!stop_housekeeper_ && base::SystemClock().SteadyNow() < next) {
        wake_housekeeper_.WaitUntil(housekeeper_mutex_, next);
      }
    }
  }

  // Cuts off open calls of principals that were revoked or have lost a role.
  void AskAgain() {
    const base::MutexLock lock(housekeeper_mutex_);
    while (!stop_housekeeper_) {
      const base::SteadyTime next = base::SystemClock().SteadyNow() + options_.ask_again;
      while (!stop_housekeeper_ && base::SystemClock().SteadyNow() < next) {
        wake_housekeeper_.WaitUntil(housekeeper_mutex_, next);
      }
      if (stop_housekeeper_) return;
      housekeeper_mutex_.Unlock();
      const int count = core_.open.CutOffRefused();
      if (count > 0)
        Log(LogLevel::kWarning, "cut_off",
            {{"calls", absl::StrCat(count)}, {"text", "their callers may no longer make them"}});
      housekeeper_mutex_.Lock();
    }
  }

  // Of a caller within this process, or on this machine.
  std::string LoginOf(const std::string& peer) const {
    if (listener_ == nullptr) return LoginOfProcess();
    if (listener_->port() != 0) {
      const std::optional<uid_t> user = UserOfPeer(peer, listener_->port());
      return user ? LoginOfUser(*user) : "unknown";
    }
    // The connections of a unix socket have no names: as long as one user alone has connected, it is he.
    const std::set<uid_t> users = listener_->users();
    return users.size() == 1
               ? LoginOfUser(*users.begin())
               : "one-of-" + absl::StrJoin(users, "-", [](std::string* out, uid_t user) { *out += LoginOfUser(user); });
  }

  // Once a day for each.
  void WarnOfCertificates() {
    const base::UtcTime now = base::SystemClock().UtcNow();
    if (tls_ == nullptr || (warned_at_ && now - *warned_at_ < std::chrono::days(1))) return;
    for (const std::string& sentence : EndingSoon(tls_->certificates(), now, kWarnAhead)) {
      warned_at_ = now;
      Log(LogLevel::kWarning, "certificate_ends", {{"text", sentence}});
    }
  }

  static void LogExpired(const std::string& what, const absl::StatusOr<int>& count) {
    if (!count.ok()) {
      Log(LogLevel::kWarning, "expire", {{"text", std::string(count.status().message())}});
    } else if (*count > 0) {
      Log(LogLevel::kInfo, "expire", {{what, absl::StrCat(*count)}});
    }
  }

  void StopHousekeeper() {
    {
      const base::MutexLock lock(housekeeper_mutex_);
      stop_housekeeper_ = true;
      wake_housekeeper_.NotifyAll();
    }
    if (housekeeper_.joinable()) housekeeper_.join();
    if (asker_.joinable()) asker_.join();
  }

  base::Mutex housekeeper_mutex_;
  base::CondVar wake_housekeeper_;
  bool stop_housekeeper_ AXISCAL_GUARDED_BY(housekeeper_mutex_) = false;
  std::optional<base::UtcTime> warned_at_;  // of certificates; the housekeeper's alone
  std::thread housekeeper_;
  std::thread asker_;

  static jobs::JobRunnerOptions RunnerOptions(const ServerOptions& options) {
    jobs::JobRunnerOptions runner;
    runner.workers = options.workers;
    runner.tell = LogJob;
    return runner;
  }
};

absl::StatusOr<std::unique_ptr<Server>> Server::Start(const ServerOptions& options) {
  RETURN_IF_ERROR(Validate(options));
  storage::SqliteOptions sqlite;
  sqlite.path = options.database_path;
  sqlite.rescued = [](const records::JobRecord& job) {
    LogJob({jobs::JobEvent::What::kLost, job, jobs::OutcomeOf(job), {}});
  };
  sqlite.damaged = [](const absl::Status& status) {
    Log(LogLevel::kWarning, "damaged",
        {{"reason", base::ErrorReason(status)},
         {"text", std::string(status.message())},
         {"then", "it is being sent again, and stored anew"}});
  };
  ASSIGN_OR_RETURN(std::unique_ptr<storage::Database> database, storage::OpenSqlite(sqlite));
  if (const std::vector<std::string> files = storage::OpenToOthers(options.database_path); !files.empty()) {
    Log(LogLevel::kWarning, "readable_by_others",
        {{"files", absl::StrJoin(files, ", ")}, {"text", "everybody on this machine may read them: chmod 600"}});
  }
  auto impl = std::make_unique<Impl>(options, std::move(database));
  RETURN_IF_ERROR(impl->Start());
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Server::~Server() = default;

std::shared_ptr<grpc::Channel> Server::InProcessChannel() {
  DEMAND(impl_->server_ != nullptr);
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(handlers::kMaxMessageBytes);
  return impl_->server_->InProcessChannel(arguments);
}

int Server::port() const { return impl_->port_; }
void Server::Shutdown() { impl_->Shutdown(); }

}  // namespace axiscal::server
