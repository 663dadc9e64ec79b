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
#include "core/base/utf8.h"
#include "proto/convert/job_params.h"
#include "server/call_guard.h"
#include "server/call_heads.h"
#include "server/denials.h"
#include "server/handlers/get_metrics.h"
#include "server/handlers/get_server_info.h"
#include "server/http/http_server.h"
#include "server/jobs/close_loop_job.h"
#include "server/jobs/compensate_job.h"
#include "server/jobs/identify_job.h"
#include "server/jobs/job_runner.h"
#include "server/jobs/tool_setter_job.h"
#include "server/listener.h"
#include "server/local_login.h"
#include "server/log.h"
#include "server/routines/keeper.h"
#include "server/service.h"
#include "server/storage/file_mode.h"
#include "server/storage/postgres_database.h"
#include "server/storage/postgres_url.h"
#include "server/storage/sqlite_database.h"
#include "server/strangers.h"
#include "server/tls.h"
#include "server/watch/watcher.h"
#include "server/webhooks/sender.h"

namespace axiscal::server {
namespace {

constexpr int kKeepaliveMs = 20'000, kKeepaliveTimeoutMs = 10'000;
// How often the end of the last call is looked for, and how long connections may take to hear of the end.
constexpr std::chrono::milliseconds kLookAgain(5), kGoodbye(100);
// How often uploads that were left are looked for. A crash loses so much of the time that counts for them.
constexpr std::chrono::minutes kHousekeeping(10);
// How soon a balancer hears that a store which others share does not answer: it takes some seconds itself.
constexpr std::chrono::seconds kAsksStore(2);
// Clients may ask so often whether we are there; more often they are sent away.
constexpr int kMinPingIntervalMs = 10'000;
// Of one answer to a call within this process, by HTTP or embedded: reports are longer than what callers may send.
constexpr int kMaxAnswerBytes = 256 << 20;
// Of one connection at a time; a client that makes more waits for a place.
constexpr int kMaxCallsOfConnection = 1000;
// Of gRPC's threads beside those that have a call: they wait for the next one.
constexpr int kThreadsOfGrpc = 100;
// How often it is looked whether calls flood in that no handler hears of, and how many of them are a flood: more than
// people and dashboards that change their mind, or clients whose deadlines are over, take back. Until it is looked, all
// that come are in memory, 20 KB each.
constexpr std::chrono::milliseconds kFloodLook(10);
constexpr int64_t kMostUnheard = 20;
// After one it is looked for its connections so long: their calls wait in gRPC, and are counted when they have a
// thread.
constexpr std::chrono::seconds kFloodLasts(5);
// Who has brought so much and shown no identity is no caller that has just come: TLS and a first call take a fifth.
constexpr int64_t kMuchOfAStranger = 32 << 10;
// How often it is looked how many connections strangers have.
constexpr std::chrono::milliseconds kStrangersLook(500);
// What strangers are told is short: who leaves more of it than a hundred answers takes none, and what he is told stays
// in gRPC's memory.
constexpr int64_t kUntakenByAStranger = 16 << 10;
// Beyond so many peers that are known, 100 bytes each, those whose connections are gone are forgotten.
constexpr size_t kManyKnown = 65'536;
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

// "axiscal.shop" of "axiscal.shop:7480".
std::string HostOf(const std::string& address) {
  const size_t colon = address.rfind(':');
  return address.rfind("unix", 0) == 0 || colon == std::string::npos ? "" : address.substr(0, colon);
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
  if (!job.request_id.empty()) fields.push_back({"request", job.request_id});
  if (!job.trace.empty()) fields.push_back({"trace", job.trace});
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

void SetChannelArguments(const ServerOptions& options, int calls, grpc::ServerBuilder& builder) {
  // The bandwidth probe lets gRPC read megabytes ahead of us per stream; a fixed window bounds memory and latency.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, options.window_bytes);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveMs);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepaliveTimeoutMs);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, kMinPingIntervalMs);
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, kHandshakeMs);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, static_cast<int>(options.connection_idle.count()));
  builder.SetMaxReceiveMessageSize(handlers::kMaxMessageBytes);
  // What callers have half sent waits in gRPC's memory, where no handler sees it: 4 MB of each of any number of calls.
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMaxCallsOfConnection);
  grpc::ResourceQuota memory("axiscald");
  memory.Resize(static_cast<size_t>(options.waiting_bytes));
  // Each call has a thread as soon as its message is there. Without a limit a flood becomes as many threads as the
  // system has: beyond it gRPC refuses calls (RESOURCE_EXHAUSTED) until some have ended.
  memory.SetMaxThreads(calls + kThreadsOfGrpc);
  builder.SetResourceQuota(memory);
  // gRPC holds the compressed size against that limit, and 1 MB of gzip makes 1 GB of zeros. Readings and programs gain
  // little from it on the wire.
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
}

// The store that `database` names, a file or a URL of PostgreSQL, and what it tells goes into the log.
absl::StatusOr<std::unique_ptr<storage::Database>> OpenStore(const std::string& database) {
  const auto rescued = [](const records::JobRecord& job) {
    LogJob({jobs::JobEvent::What::kLost, job, jobs::OutcomeOf(job), {}});
  };
  const auto damaged = [](const absl::Status& status) {
    const std::string reason = base::ErrorReason(status);
    Log(LogLevel::kWarning, "damaged",
        {{"reason", reason},
         {"text", std::string(status.message())},
         {"then", reason == "HISTORY_DAMAGED" ? "histories leave it out; axiscald check names all, a backup has it"
                                              : "it is being sent again, and stored anew"}});
  };
  if (storage::IsPostgresUrl(database)) {
    storage::PostgresOptions options;
    options.url = database;
    options.rescued = rescued;
    options.damaged = damaged;
    return storage::OpenPostgres(options);
  }
  storage::SqliteOptions options;
  options.path = database;
  options.rescued = rescued;
  options.damaged = damaged;
  ASSIGN_OR_RETURN(std::unique_ptr<storage::Database> store, storage::OpenSqlite(options));
  if (const std::vector<std::string> files = storage::OpenToOthers(database); !files.empty()) {
    Log(LogLevel::kWarning, "readable_by_others",
        {{"files", absl::StrJoin(files, ", ")}, {"text", "everybody on this machine may read them: chmod 600"}});
  }
  return store;
}

}  // namespace

absl::Status Validate(const ServerOptions& options) {
  const auto refuse = [](const std::string& text) { return absl::InvalidArgumentError(text); };
  if (options.database_path.empty()) return refuse("database_path is empty, must name a file or a database");
  if (options.workers < 1 || options.workers > kMaxWorkers) {
    return refuse(absl::StrCat("workers = ", options.workers, ", must be 1 to ", kMaxWorkers, ": each uses one core"));
  }
  if (options.max_uploads < 1 || options.max_uploads > kMaxUploads) {
    return refuse(absl::StrCat("max_uploads = ", options.max_uploads, ", must be 1 to ", kMaxUploads));
  }
  if (options.streams_per_principal < 1 || options.streams_per_principal > kMaxUploads) {
    return refuse(
        absl::StrCat("streams_per_principal = ", options.streams_per_principal, ", must be 1 to ", kMaxUploads));
  }
  if (options.calls_per_second < 1 || options.calls_per_second > kMaxCallsPerSecond) {
    return refuse(absl::StrCat("calls_per_second = ", options.calls_per_second, ", must be 1 to ", kMaxCallsPerSecond));
  }
  for (const auto& [name, jobs] :
       {std::pair("jobs_per_principal", options.jobs_per_principal), {"jobs_per_machine", options.jobs_per_machine}}) {
    if (jobs < 1 || jobs > kMaxJobs) return refuse(absl::StrCat(name, " = ", jobs, ", must be 1 to ", kMaxJobs));
  }
  if (options.session_readings < 1 || options.program_bytes < 1)
    return refuse("session_readings and program_bytes must be > 0");
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
  if (options.waiting_bytes < kMinWaitingBytes)
    return refuse(absl::StrCat("waiting_bytes = ", options.waiting_bytes, ", must be >= ", kMinWaitingBytes));
  if (options.strangers < 1) return refuse(absl::StrCat("strangers = ", options.strangers, ", must be > 0"));
  // Of one there would be nothing left for the others (handlers::Budget), so that nobody got it.
  if (options.http_bytes < 2 || options.http_requests < 2)
    return refuse(absl::StrCat("http_bytes = ", options.http_bytes, ", http_requests = ", options.http_requests,
                               ", both must be > 1"));
  if (options.session_expiry.count() < 1) return refuse("session_expiry must be > 0");
  if (options.drain.count() < 0) return refuse(absl::StrCat("drain = ", options.drain.count(), " ms, must be >= 0"));
  return absl::OkStatus();
}

class Server::Impl {
 public:
  Impl(const ServerOptions& options, std::unique_ptr<storage::Database> database)
      : options_(options),
        database_(std::move(database)),
        watcher_(*database_, events_, WatcherOptions()),
        runner_(*database_, RunnerOptions(options)),
        keeper_gate_(*database_, Asks(options)),
        keeper_(*database_, runner_, keeper_gate_, KeeperOptions()),
        core_{.database = *database_,
              .jobs = runner_,
              .gate = {*database_, Asks(options)},
              .limits = {.held = {.max_uploads = options.max_uploads,
                                  .max_rewrites = options.workers,
                                  .max_of_one = options.streams_per_principal,
                                  .silence = options.silence},
                         .max_session_readings = options.session_readings,
                         .max_program_bytes = options.program_bytes,
                         .backup_folder = options.backup_folder,
                         .measured_machines = options.metrics_machines,
                         .database_file = storage::IsPostgresUrl(options.database_path) ? "" : options.database_path},
              .workers = options.workers,
              .rates = handlers::CallRates(options.calls_per_second),
              .events = events_,
              .metrics = metrics_,
              .look_soon = [this](const MachineId& machine) { LookSoon(machine, true, false); },
              .run_soon = [this](const MachineId& machine) { LookSoon(machine, false, true); },
              .run_all_soon =
                  [this] {
                    keeper_.LookAtAllSoon();
                    if (!database_->IsCaretaker()) database_->TellOthers(std::nullopt);
                  }} {
    // Monte Carlo of a hundred thousand runs.
    runner_.Register(records::kIdentify, {jobs::IdentifyJob(*database_), std::chrono::hours(1)});
    runner_.Register(records::kCompensate, {jobs::CompensateJob(*database_)});
    runner_.Register(records::kToolSetter, {jobs::ToolSetterJob(*database_), std::chrono::minutes(10)});
    // Thousands of candidates, and a full refit after each effect.
    runner_.Register(records::kCloseLoop, {jobs::CloseLoopJob(*database_), std::chrono::hours(1)});
    if (options.webhook_posts) {
      sender_ = std::make_unique<webhooks::Sender>(*database_, events_, SenderOptions(*options.webhook_posts));
      core_.webhook_sender = sender_.get();
    }
  }

  absl::Status Start() {
    ChoosePlugins();
    const int calls = GuardCalls(core_.limits.held);
    grpc::ServerBuilder builder;
    SetChannelArguments(options_, calls, builder);
    if (!options_.listen_address.empty()) {
      ASSIGN_OR_RETURN(listener_, Listener::Open(options_.listen_address));
      if (!listener_->is_local_only() && !options_.tls.is_set()) return Unprotected(options_.listen_address);
      std::shared_ptr<grpc::ServerCredentials> credentials =
          core_.gate.asks() ? heads_.PlainCredentials() : grpc::InsecureServerCredentials();
      if (options_.tls.is_set()) {
        ASSIGN_OR_RETURN(tls_, Tls::Create(options_.tls, LogTls));
        credentials = Tls::Credentials(tls_, heads_);
      }
      port_ = listener_->port();
      connections_ = builder.experimental().AddExternalConnectionAcceptor(
          grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD, credentials);
    }
    std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> interceptors;
    interceptors.push_back(CallHeads::HealthCounter());
    builder.experimental().SetInterceptorCreators(std::move(interceptors));
    if (!options_.http_address.empty()) RETURN_IF_ERROR(OpenHttp());
    services_ = MakeServices(core_);
    for (const std::unique_ptr<grpc::Service>& service : services_) builder.RegisterService(service.get());
    server_ = builder.BuildAndStart();
    if (server_ == nullptr) {
      return base::Error(absl::StatusCode::kUnavailable, "gRPC does not start", {"LISTEN_FAILED", {}});
    }
    core_.denied = [this](const handlers::Call& call, const std::string& method, const absl::Status& status) {
      denials_.Add(call.user, call.peer, method, status);
    };
    core_.login_of = [this](const std::string& peer) { return LoginOf(peer); };
    core_.certificates = [this] {
      std::vector<std::pair<std::string, base::UtcTime>> ends;
      if (tls_ == nullptr) return ends;
      for (const Certificate& certificate : tls_->certificates()) ends.emplace_back(certificate.file, certificate.ends);
      return ends;
    };
    if (options_.tls.is_set()) core_.private_files = {options_.tls.key};
    core_.log_level = [](std::optional<records::LogLevel> level) {
      if (level) SetLogLevel(*level);
      return GetLogLevel();
    };
    if (listener_ != nullptr) StartListening();
    if (http_listener_ != nullptr) StartHttp();
    if (core_.gate.asks()) {
      asker_ = std::thread([this] { AskAgain(); });
      flood_watch_ = std::thread([this] { WatchFloods(); });
      if (port_ != 0) strangers_watch_ = std::thread([this] { WatchStrangers(); });
    }
    database_->Follow([this](const storage::News& news) { Hear(news); });
    runner_.Start();
    watcher_.Start();
    keeper_.Start();
    if (sender_ != nullptr) sender_->Start();
    housekeeper_ = std::thread([this] { KeepHouse(); });
    if (database_->is_shared()) readiness_ = std::thread([this] { FollowStore(); });
    return absl::OkStatus();
  }

  ~Impl() { Shutdown(); }

  void Shutdown() {
    const base::MutexLock lock(shutdown_mutex_);
    if (server_ == nullptr) return;
    Log(LogLevel::kInfo, "drain", {});
    StopFollowingStore();
    server_->GetHealthCheckService()->SetServingStatus(false);
    core_.draining = true;
    const base::SteadyTime deadline = base::SystemClock().SteadyNow() + options_.drain;
    keeper_.Stop();
    // Jobs first: those who watch them see how they end.
    runner_.Drain(options_.drain);
    watcher_.Stop();
    if (sender_ != nullptr) sender_->Stop();
    // What one process alone has to do, another one does from now on.
    database_->StopFollowing();
    while (core_.open_calls > 0 && base::SystemClock().SteadyNow() < deadline) std::this_thread::sleep_for(kLookAgain);
    if (listener_ != nullptr) listener_->Stop();
    if (http_listener_ != nullptr) http_listener_->Stop();
    // What is still open is cut off; its callers resume elsewhere or later. Without calls a connection alone would hold
    // the shutdown up to its deadline: an idle client hears of the end only when it calls again.
    server_->Shutdown(std::chrono::system_clock::now() + kGoodbye);
    http_.reset();
    server_.reset();
    StopHousekeeper();
    WriteDenials(true);
    Log(LogLevel::kInfo, "stopped", {});
  }

  const ServerOptions options_;
  int port_ = 0, http_port_ = 0;
  std::unique_ptr<storage::Database> database_;
  const std::shared_ptr<metrics::Metrics> metrics_ = std::make_shared<metrics::Metrics>(
      AXISCAL_VERSION, handlers::CountedMethods(),
      std::vector<std::string>{records::kIdentify, records::kCompensate, records::kToolSetter, records::kCloseLoop});
  const std::shared_ptr<watch::EventBoard> events_ = std::make_shared<watch::EventBoard>();
  watch::Watcher watcher_;
  jobs::JobRunner runner_;
  const access::Gate keeper_gate_;
  routines::Keeper keeper_;
  std::unique_ptr<webhooks::Sender> sender_;  // where webhooks are sent
  handlers::Core core_;
  std::vector<std::unique_ptr<grpc::Service>> services_;
  std::unique_ptr<Listener> listener_, http_listener_;
  PeerUsers peer_users_{[this](const std::string& peer) { return UserOfPeer(peer, port_); }};
  CallHeads heads_{[this](const access::Credentials& shown) { return core_.gate.Identify(shown).status(); }};
  std::shared_ptr<Tls> tls_, http_tls_;  // each port asks by itself what is new
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> connections_;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<http::HttpServer> http_;
  base::Mutex shutdown_mutex_;

 private:
  // At the machine, or at its routines, by whoever does that.
  void LookSoon(const MachineId& machine, bool looks, bool runs) {
    if (!database_->IsCaretaker()) return database_->TellOthers(machine);
    if (looks) watcher_.LookSoon(machine);
    if (runs) keeper_.LookSoon(machine);
  }

  // What other processes on the same store have done, and this one.
  void Hear(const storage::News& news) {
    if (news.jobs) runner_.LookAgain();
    if (news.events) events_->Tell();
    if (news.routines) keeper_.LookAtAllSoon();
    if (news.machine && database_->IsCaretaker()) LookSoon(*news.machine, true, true);
  }

  void StartListening() {
    listener_->Start(
        [this](int listening, int connection) {
          peer_users_.Connected(connection);
          core_.known.Forget(PeerOf(connection));
          grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
          parameters.listener_fd = listening;
          parameters.fd = connection;
          connections_->HandleNewConnection(&parameters);
        },
        TellRefused);
  }

  static void TellRefused(int64_t refused) {
    Log(LogLevel::kWarning, "connections_refused",
        {{"so_far", absl::StrCat(refused)}, {"text", "too few descriptors: close idle clients or raise the limit"}});
  }

  absl::Status OpenHttp() {
    ASSIGN_OR_RETURN(http_listener_, Listener::Open(options_.http_address));
    if (!http_listener_->is_local_only() && !options_.tls.is_set()) return Unprotected(options_.http_address);
    if (options_.tls.is_set()) {
      ASSIGN_OR_RETURN(http_tls_, Tls::Create(options_.tls, LogTls));
    }
    http_port_ = http_listener_->port();
    return absl::OkStatus();
  }

  void StartHttp() {
    http::HttpOptions http;
    http.own_host = HostOf(options_.http_address);
    http.silence = options_.silence;
    http.idle = options_.connection_idle;
    http.strangers = options_.strangers;
    http.max_bytes = options_.http_bytes;
    http.max_requests = options_.http_requests;
    http.end_of_certificate = EndOfCertificate;
    if (http_tls_ != nullptr) {
      http.new_tls = [tls = http_tls_]() -> std::optional<http::TlsText> {
        const std::optional<TlsMaterial> material = tls->TakeNew();
        if (!material) return std::nullopt;
        return http::TlsText{material->certificate_pem, material->key_pem, material->client_ca_pem};
      };
    }
    http.login_of = [port = http_port_](int connection, const std::string& peer) {
      const std::optional<uid_t> user = port == 0 ? UserOfUnixPeer(connection) : UserOfPeer(peer, port);
      return user ? LoginOfUser(*user) : std::string("unknown");
    };
    http.tell_refused = [](const http::Request& request, const http::Answer& answer) {
      Log(LogLevel::kWarning, "http_refused",
          {{"method", base::ToUtf8(request.method)},
           {"path", base::ToUtf8(request.path)},
           {"peer", request.peer.address},
           {"status", absl::StrCat(answer.status)},
           {"text", answer.body}});
    };
    grpc::ChannelArguments arguments;
    arguments.SetMaxReceiveMessageSize(kMaxAnswerBytes);
    http_ = std::make_unique<http::HttpServer>(http, core_, server_->InProcessChannel(arguments));
    http_listener_->Start([this](int, int connection) { http_->Take(connection); }, TellRefused);
  }

  // Drops what uploaders have left, now and every kHousekeeping.
  void KeepHouse() {
    const base::MutexLock lock(housekeeper_mutex_);
    while (!stop_housekeeper_) {
      LogExpired("sessions", database_->ExpireSessions(options_.session_expiry));
      WarnOfCertificates();
      LogExpired("programs", database_->ExpirePrograms(options_.session_expiry));
      if (options_.keep_readings.count() > 0) LogExpired("readings", database_->ExpireReadings(options_.keep_readings));
      ExpireAudit();
      const base::SteadyTime next = base::SystemClock().SteadyNow() + kHousekeeping;
      while (!stop_housekeeper_ && base::SystemClock().SteadyNow() < next) {
        wake_housekeeper_.WaitUntil(housekeeper_mutex_, next);
      }
    }
  }

  // Some at a time, so that other writes go on between.
  void ExpireAudit() {
    if (options_.keep_audit.count() == 0) return;
    absl::StatusOr<int> count = 1;
    for (int total = 0; count.ok() && *count > 0; total += *count) {
      count = database_->ExpireAudit(options_.keep_audit);
      if (!count.ok() || *count == 0) LogExpired("audit", count.ok() ? total : count);
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
      CancelRefusedJobs();
      WriteDenials(false);
      if (count > 0)
        Log(LogLevel::kWarning, "cut_off",
            {{"calls", absl::StrCat(count)}, {"text", "their callers may no longer make them"}});
      housekeeper_mutex_.Lock();
    }
  }

  // Ends connections of strangers while calls come that no handler hears of: gRPC has those without bound, and does not
  // say from where they come.
  void WatchFloods() {
    const base::MutexLock lock(housekeeper_mutex_);
    int64_t before = UnheardCalls() + heads_.refused();
    base::SteadyTime flood_until = base::SystemClock().SteadyNow();
    while (!stop_housekeeper_) {
      const base::SteadyTime next = base::SystemClock().SteadyNow() + kFloodLook;
      while (!stop_housekeeper_ && base::SystemClock().SteadyNow() < next) {
        wake_housekeeper_.WaitUntil(housekeeper_mutex_, next);
      }
      const int64_t now = UnheardCalls() + heads_.refused();
      if (now - before >= kMostUnheard) flood_until = base::SystemClock().SteadyNow() + kFloodLasts;
      if (!stop_housekeeper_ && base::SystemClock().SteadyNow() < flood_until) {
        housekeeper_mutex_.Unlock();
        EndStrangers(now - before);
        housekeeper_mutex_.Lock();
      }
      before = now;
    }
  }
  void EndStrangers(int64_t calls) {
    const int count = EndConnections(port_, [this](const std::string& peer, const Traffic& traffic) {
      return traffic.brought >= kMuchOfAStranger && !core_.known.Has(peer);
    });
    if (count == 0 || !core_.told_refusals.Take("flood").ok()) return;
    Log(LogLevel::kWarning, "flood",
        {{"calls", absl::StrCat(calls)},
         {"connections", absl::StrCat(count)},
         {"text", "calls that no handler heard of: connections that brought much and showed no identity were ended"}});
  }

  // Ends the first connections of strangers where there are too many.
  void WatchStrangers() {
    Strangers strangers(port_, static_cast<size_t>(options_.strangers),
                        [this](const std::string& peer) { return core_.known.Has(peer); });
    const base::MutexLock lock(housekeeper_mutex_);
    while (!stop_housekeeper_) {
      const base::SteadyTime next = base::SystemClock().SteadyNow() + kStrangersLook;
      while (!stop_housekeeper_ && base::SystemClock().SteadyNow() < next) {
        wake_housekeeper_.WaitUntil(housekeeper_mutex_, next);
      }
      if (stop_housekeeper_) return;
      housekeeper_mutex_.Unlock();
      core_.known.ForgetGone(kManyKnown, [this] { return PeersTo(port_); });
      const std::set<std::string> peers = strangers.TooMany();
      int untaken = 0, count = 0;
      EndConnections(port_, [&](const std::string& peer, const Traffic& traffic) {
        if (core_.known.Has(peer)) return false;  // he may have called since
        const bool is_beyond = peers.contains(peer), takes_nothing = traffic.untaken >= kUntakenByAStranger;
        count += is_beyond ? 1 : 0;
        untaken += takes_nothing && !is_beyond ? 1 : 0;
        return is_beyond || takes_nothing;
      });
      if (untaken > 0 && core_.told_refusals.Take("untaken").ok()) {
        Log(LogLevel::kWarning, "strangers",
            {{"connections", absl::StrCat(untaken)},
             {"text", "they had shown no identity and took nothing of what they were told: they were ended"}});
      }
      if (count > 0 && core_.told_refusals.Take("strangers").ok()) {
        Log(LogLevel::kWarning, "strangers",
            {{"connections", absl::StrCat(count)},
             {"text",
              "more connections than are allowed had shown no identity: the first of the host that has most were "
              "ended"}});
      }
      housekeeper_mutex_.Lock();
    }
  }

  // Jobs whose creators may no longer create them.
  void CancelRefusedJobs() {
    for (const records::JobState state : {records::JobState::kRunning, records::JobState::kQueued}) {
      records::PageRequest page{1000, ""};
      do {
        const auto jobs = database_->ListJobs({{}, state, ""}, page);
        if (!jobs.ok()) return Log(LogLevel::kWarning, "ask_again", {{"text", std::string(jobs.status().message())}});
        for (const records::JobRecord& job : jobs->rows) CancelIfRefused(job);
        page.token = jobs->next_token;
      } while (!page.token.empty());
    }
  }
  void CancelIfRefused(const records::JobRecord& job) {
    if (job.cancel_requested) return;
    std::vector<storage::Resource> named;
    if (job.machine) named.push_back({storage::ResourceKind::kMachine, job.machine->text(), 0});
    const absl::Status may = core_.gate.MayStill(job.created_by, "Jobs.CreateJob", named);
    if (!absl::IsNotFound(may) && !absl::IsPermissionDenied(may) && !absl::IsUnauthenticated(may)) return;
    const absl::Status cancelled = runner_.Cancel(job.id, {"axiscald", ""}).status();
    Log(LogLevel::kWarning, "cut_off",
        {{"job", absl::StrCat(job.id.number())},
         {"text", cancelled.ok() ? "its creator, " + job.created_by + ", may no longer create it"
                                 : std::string(cancelled.message())}});
  }

  void WriteDenials(bool all) {
    const absl::Status written = denials_.Write(*database_, all);
    if (!written.ok()) Log(LogLevel::kWarning, "audit", {{"text", std::string(written.message())}});
  }

  // Of a caller within this process, or on this machine.
  std::string LoginOf(const std::string& peer) {
    if (listener_ == nullptr) return LoginOfProcess();
    if (listener_->port() != 0) {
      const std::optional<uid_t> user = peer_users_.UserOf(peer);
      return user ? LoginOfUser(*user) : "unknown";
    }
    // The connections of a unix socket have no names: as long as one user alone has connected, it is he.
    const std::set<uid_t> users = listener_->users();
    return users.size() == 1
               ? LoginOfUser(*users.begin())
               : "one-of-" + absl::StrJoin(users, "-", [](std::string* out, uid_t user) { *out += LoginOfUser(user); });
  }

  void WarnOfCertificates() {
    if (tls_ == nullptr) return;
    for (const std::string& sentence : end_warnings_.Due(tls_->certificates(), base::SystemClock().UtcNow()))
      Log(LogLevel::kWarning, "certificate_ends", {{"text", sentence}});
  }

  static void LogExpired(const std::string& what, const absl::StatusOr<int>& count) {
    if (!count.ok()) {
      Log(LogLevel::kWarning, "expire", {{"text", std::string(count.status().message())}});
    } else if (*count > 0) {
      Log(LogLevel::kInfo, "expire", {{what, absl::StrCat(*count)}});
    }
  }

  // Ready is who can read the store: a balancer sends calls to others meanwhile.
  void FollowStore() {
    bool was_ready = true;
    const base::MutexLock lock(readiness_mutex_);
    while (!stop_readiness_) {
      readiness_mutex_.Unlock();
      const absl::Status answer = database_->JobVersions({}).status();
      readiness_mutex_.Lock();
      if (stop_readiness_) return;
      if (answer.ok() != was_ready) {
        was_ready = answer.ok();
        Log(was_ready ? LogLevel::kInfo : LogLevel::kError, was_ready ? "ready" : "not_ready",
            {{"error", was_ready ? "" : answer.ToString()}});
        server_->GetHealthCheckService()->SetServingStatus(was_ready);
      }
      wake_readiness_.WaitUntil(readiness_mutex_, base::SystemClock().SteadyNow() + kAsksStore);
    }
  }

  void StopFollowingStore() {
    {
      const base::MutexLock lock(readiness_mutex_);
      stop_readiness_ = true;
      wake_readiness_.NotifyAll();
    }
    if (readiness_.joinable()) readiness_.join();
  }

  void StopHousekeeper() {
    {
      const base::MutexLock lock(housekeeper_mutex_);
      stop_housekeeper_ = true;
      wake_housekeeper_.NotifyAll();
    }
    if (housekeeper_.joinable()) housekeeper_.join();
    if (asker_.joinable()) asker_.join();
    if (flood_watch_.joinable()) flood_watch_.join();
    if (strangers_watch_.joinable()) strangers_watch_.join();
  }

  base::Mutex housekeeper_mutex_;
  base::CondVar wake_housekeeper_;
  bool stop_housekeeper_ AXISCAL_GUARDED_BY(housekeeper_mutex_) = false;
  EndWarnings end_warnings_;  // the housekeeper's alone
  base::Mutex readiness_mutex_;
  base::CondVar wake_readiness_;
  bool stop_readiness_ AXISCAL_GUARDED_BY(readiness_mutex_) = false;
  std::thread readiness_;
  std::thread housekeeper_;
  std::thread asker_;
  std::thread flood_watch_;
  std::thread strangers_watch_;
  Denials denials_;

  watch::WatcherOptions WatcherOptions() {
    watch::WatcherOptions watcher;
    watcher.version = AXISCAL_VERSION;
    watcher.is_mine = [this] { return database_->IsCaretaker(); };
    watcher.tell = [](const MachineId& machine, const absl::Status& status) {
      Log(LogLevel::kWarning, "look_failed",
          {{"machine", machine.text()},
           {"reason", base::ErrorReason(status)},
           {"text", std::string(status.message())},
           {"then", "its events stay as they are; it is looked at again"}});
    };
    return watcher;
  }
  webhooks::SenderOptions SenderOptions(const webhooks::PosterOptions& post) {
    webhooks::SenderOptions sender;
    sender.post = post;
    sender.is_mine = [this] { return database_->IsCaretaker(); };
    sender.count = [metrics = metrics_](const std::string& outcome) { metrics->LetterSent(outcome); };
    sender.tell = [](const records::WebhookRecord& webhook, const std::string& error, bool is_dead) {
      Log(LogLevel::kWarning, "webhook_failed",
          {{"webhook", webhook.content.name},
           {"tries", absl::StrCat(webhook.tries + 1)},
           {"text", error},
           {"then", is_dead ? "it is a dead letter: axiscal admin webhook dead" : "it is tried again"}});
    };
    return sender;
  }
  routines::KeeperOptions KeeperOptions() {
    routines::KeeperOptions keeper;
    keeper.tell = [](const MachineId& machine, const std::string& routine, const absl::Status& status) {
      Log(LogLevel::kWarning, "routine_held_up",
          {{"machine", machine.text()},
           {"routine", routine},
           {"reason", base::ErrorReason(status)},
           {"text", std::string(status.message())},
           {"then", "it is tried again"}});
    };
    keeper.ended = [this](const records::RoutineRun& run) {
      Log(run.state == records::RunState::kFailed ? LogLevel::kWarning : LogLevel::kInfo, "routine_end",
          {{"routine", run.routine},
           {"machine", run.machine.text()},
           {"run", absl::StrCat(run.id.number())},
           {"outcome", records::NameOf(run.state)},
           {"text", run.text}});
      LookSoon(run.machine, true, false);
    };
    keeper.is_mine = [this] { return database_->IsCaretaker(); };
    return keeper;
  }
  jobs::JobRunnerOptions RunnerOptions(const ServerOptions& options) {
    jobs::JobRunnerOptions runner;
    runner.workers = options.workers;
    runner.max_of_principal = options.jobs_per_principal;
    runner.max_of_machine = options.jobs_per_machine;
    runner.tell = [this](const jobs::JobEvent& event) {
      LogJob(event);
      if (event.what != jobs::JobEvent::What::kStarted) metrics_->JobEnded(event.job.kind, event.outcome, event.took);
      const bool has_changed = event.job.machine && event.job.state == records::JobState::kSucceeded;
      const bool has_ended = event.job.machine && records::IsTerminal(event.job.state);
      if (has_ended) LookSoon(*event.job.machine, has_changed, true);
    };
    return runner;
  }
};

absl::StatusOr<std::unique_ptr<Server>> Server::Start(const ServerOptions& options) {
  RETURN_IF_ERROR(Validate(options));
  ASSIGN_OR_RETURN(std::unique_ptr<storage::Database> database, OpenStore(options.database_path));
  auto impl = std::make_unique<Impl>(options, std::move(database));
  RETURN_IF_ERROR(impl->Start());
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Server::~Server() = default;

std::shared_ptr<grpc::Channel> Server::InProcessChannel() {
  DEMAND(impl_->server_ != nullptr);
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMaxAnswerBytes);
  return impl_->server_->InProcessChannel(arguments);
}

int Server::port() const { return impl_->port_; }
int Server::http_port() const { return impl_->http_port_; }
absl::Status Server::Check() {
  records::PageRequest one;
  one.size = 1;
  RETURN_IF_ERROR(impl_->database_->ListMachines(one).status());
  RETURN_IF_ERROR(impl_->database_->NextJobWait().status());
  return impl_->database_->TryReadAnew();
}
void Server::Shutdown() { impl_->Shutdown(); }

}  // namespace axiscal::server
