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
#include "server/half_sent_watch.h"
#include "server/handlers/get_metrics.h"
#include "server/handlers/get_server_info.h"
#include "server/housekeeper.h"
#include "server/http/http_server.h"
#include "server/jobs/close_loop_job.h"
#include "server/jobs/compensate_job.h"
#include "server/jobs/identify_job.h"
#include "server/jobs/job_runner.h"
#include "server/jobs/tool_setter_job.h"
#include "server/listener.h"
#include "server/local_login.h"
#include "server/log.h"
#include "server/log_job.h"
#include "server/open_store.h"
#include "server/rights_watch.h"
#include "server/routines/keeper.h"
#include "server/service.h"
#include "server/storage/postgres_url.h"
#include "server/stranger_watch.h"
#include "server/tls.h"
#include "server/watch/watcher.h"
#include "server/webhooks/sender.h"

namespace axiscal::server {
namespace {

constexpr int kKeepaliveMs = 20'000, kKeepaliveTimeoutMs = 10'000;
// How often the end of the last call is looked for, and how long connections may take to hear of the end.
constexpr std::chrono::milliseconds kLookAgain(5), kGoodbye(100);
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

}  // namespace

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
      std::shared_ptr<grpc::ServerCredentials> credentials = heads_.PlainCredentials();
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
    half_sent_watch_.emplace(port_, options_.waiting_bytes, heads_, core_.told_refusals).Start();
    if (core_.gate.asks()) {
      rights_watch_.Start();
      stranger_watch_.emplace(port_, options_.strangers, core_.known, heads_, core_.told_refusals).Start();
    }
    database_->Follow([this](const storage::News& news) { Hear(news); });
    runner_.Start();
    watcher_.Start();
    keeper_.Start();
    if (sender_ != nullptr) sender_->Start();
    housekeeper_.Start();
    if (database_->is_shared()) store_looks_.Start(Rounds::Begin::kAtOnce, kAsksStore, [this] { LookAtStore(); });
    return absl::OkStatus();
  }

  ~Impl() { Shutdown(); }

  void Shutdown() {
    const base::MutexLock lock(shutdown_mutex_);
    if (server_ == nullptr) return;
    Log(LogLevel::kInfo, "drain", {});
    store_looks_.Stop();
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
    housekeeper_.Stop();
    rights_watch_.Stop();
    stranger_watch_.reset();
    half_sent_watch_.reset();
    rights_watch_.WriteDenials(true);
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
          heads_.Forget(PeerOf(connection));
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

  // Ready is who can read the store: a balancer sends calls to others meanwhile.
  void LookAtStore() {
    const absl::Status answer = database_->JobVersions({}).status();
    if (answer.ok() == was_ready_) return;
    was_ready_ = answer.ok();
    Log(was_ready_ ? LogLevel::kInfo : LogLevel::kError, was_ready_ ? "ready" : "not_ready",
        {{"error", was_ready_ ? "" : answer.ToString()}});
    server_->GetHealthCheckService()->SetServingStatus(was_ready_);
  }

  bool was_ready_ = true;  // the thread's alone that looks at the store
  Rounds store_looks_;
  Denials denials_;
  std::optional<HalfSentWatch> half_sent_watch_;
  std::optional<StrangerWatch> stranger_watch_;
  RightsWatch rights_watch_{core_, denials_, options_.ask_again};
  Housekeeper housekeeper_{*database_, options_,
                           [this] { return tls_ == nullptr ? std::vector<Certificate>() : tls_->certificates(); }};

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
