#include "server/http/http_server.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/strand.hpp>
#include <map>
#include <system_error>
#include <thread>
#include <vector>

#include "server/access/crowd.h"
#include "server/access/forwarded.h"
#include "server/http/connection.h"

namespace axiscal::http {
namespace {

// They move bytes and encrypt; requests have threads of their own.
constexpr int kThreads = 2;

std::string PeerText(const sockaddr_storage& address) {
  char text[INET6_ADDRSTRLEN] = "";
  if (address.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(address);
    inet_ntop(AF_INET, &v4.sin_addr, text, sizeof(text));
    return absl::StrCat("ipv4:", text, ":", ntohs(v4.sin_port));
  }
  if (address.ss_family == AF_INET6) {
    const auto& v6 = reinterpret_cast<const sockaddr_in6&>(address);
    inet_ntop(AF_INET6, &v6.sin6_addr, text, sizeof(text));
    return absl::StrCat("ipv6:[", text, "]:", ntohs(v6.sin6_port));
  }
  return "unix:";
}

// Null where OpenSSL does not take the texts.
std::shared_ptr<asio::ssl::context> ContextOf(const TlsText& text) {
  auto context = std::make_shared<asio::ssl::context>(asio::ssl::context::tls_server);
  boost::system::error_code error;
  SSL_CTX* const native = context->native_handle();
  SSL_CTX_set_min_proto_version(native, TLS1_2_VERSION);
  // A connection that is resumed would keep what held for the one before.
  SSL_CTX_set_session_cache_mode(native, SSL_SESS_CACHE_OFF);
  SSL_CTX_set_options(native, SSL_OP_NO_TICKET | SSL_OP_NO_RENEGOTIATION);
  context->use_certificate_chain(asio::buffer(text.certificate), error);
  if (!error) context->use_private_key(asio::buffer(text.key), asio::ssl::context::pem, error);
  if (!error && !text.client_ca.empty()) {
    context->add_certificate_authority(asio::buffer(text.client_ca), error);
    // Who shows none is let in, and says who he is with each call.
    if (!error) context->set_verify_mode(asio::ssl::verify_peer, error);
  }
  return error ? nullptr : context;
}

}  // namespace

class HttpServer::Impl {
 public:
  Impl(const HttpOptions& options, handlers::Core& core, std::shared_ptr<grpc::Channel> channel)
      : core_(core),
        gateway_(core, std::move(channel), options.own_host, options.max_bytes),
        room_(options.max_requests),
        context_{
            options, gateway_,
            [this](const std::string& who, std::function<void()> work) { return StartRequest(who, std::move(work)); }},
        guard_(asio::make_work_guard(io_)) {
    for (int i = 0; i < kThreads; ++i) threads_.emplace_back([this] { io_.run(); });
  }
  ~Impl() { Shutdown(); }

  void Take(int descriptor) {
    sockaddr_storage address = {};
    socklen_t size = sizeof(address);
    const std::shared_ptr<asio::ssl::context> tls = NewTls();
    if (getpeername(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0 ||
        (context_.options.new_tls && tls == nullptr)) {
      close(descriptor);
      return;
    }
    Peer peer;
    peer.address = PeerText(address);
    peer.is_tls = tls != nullptr;
    peer.is_unix = address.ss_family == AF_UNIX;
    if (!core_.gate.asks()) peer.login = context_.options.login_of(descriptor, peer.address);
    Connection::Socket socket(asio::any_io_executor(asio::make_strand(io_)));
    boost::system::error_code error;
    socket.assign(asio::generic::stream_protocol(address.ss_family, 0), descriptor, error);
    if (error) {
      close(descriptor);
      return;
    }
    const auto connection = std::make_shared<Connection>(context_, std::move(socket), tls, std::move(peer));
    {
      const base::MutexLock lock(mutex_);
      std::erase_if(connections_, [](const std::weak_ptr<Connection>& one) { return one.expired(); });
      connections_.push_back(connection);
      if (core_.gate.asks()) CloseFirstStranger();
    }
    connection->Start();
  }

  void Shutdown() {
    {
      const base::MutexLock lock(mutex_);
      is_stopping_ = true;
      for (const std::weak_ptr<Connection>& one : connections_) {
        if (const std::shared_ptr<Connection> connection = one.lock()) connection->Close();
      }
      while (requests_ > 0) changed_.Wait(mutex_);
    }
    guard_.reset();
    io_.stop();
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }

 private:
  // The context for the next connection; null without TLS.
  std::shared_ptr<asio::ssl::context> NewTls() {
    if (!context_.options.new_tls) return nullptr;
    const base::MutexLock lock(mutex_);
    if (const std::optional<TlsText> text = context_.options.new_tls()) {
      if (const std::shared_ptr<asio::ssl::context> made = ContextOf(*text)) tls_ = made;
    }
    return tls_;
  }

  void CloseFirstStranger() AXISCAL_REQUIRES(mutex_) {
    std::vector<std::string> hosts;
    std::vector<decltype(connections_.begin())> strangers;
    for (auto one = connections_.begin(); one != connections_.end(); ++one) {
      const std::shared_ptr<Connection> connection = one->lock();
      if (connection == nullptr || connection->is_known()) continue;
      hosts.push_back(access::PeerHost(connection->address()));
      strangers.push_back(one);
    }
    for (const size_t place : access::BeyondTheMost(hosts, static_cast<size_t>(context_.options.strangers))) {
      if (const std::shared_ptr<Connection> connection = strangers[place]->lock()) connection->Close();
      strangers[place]->reset();  // what is left of it goes by itself
    }
  }

  bool StartRequest(const std::string& who, std::function<void()> work) {
    {
      const base::MutexLock lock(mutex_);
      if (is_stopping_ || !room_.Take(who, 1)) return false;
      ++requests_;
    }
    try {
      std::thread([this, who, work = std::move(work)]() mutable {
        work();
        work = nullptr;
        EndRequest(who);
      }).detach();
    } catch (const std::system_error&) {
      EndRequest(who);
      return false;
    }
    return true;
  }

  void EndRequest(const std::string& who) {
    room_.Give(who, 1);
    const base::MutexLock lock(mutex_);
    --requests_;
    changed_.NotifyAll();
  }

  handlers::Core& core_;
  Gateway gateway_;
  handlers::Budget room_;  // for requests
  ConnectionContext context_;
  base::Mutex mutex_;
  base::CondVar changed_;
  std::vector<std::weak_ptr<Connection>> connections_ AXISCAL_GUARDED_BY(mutex_);
  std::shared_ptr<asio::ssl::context> tls_ AXISCAL_GUARDED_BY(mutex_);
  int requests_ AXISCAL_GUARDED_BY(mutex_) = 0;
  bool is_stopping_ AXISCAL_GUARDED_BY(mutex_) = false;
  // Last, as what is still under way on it uses all of the above.
  asio::io_context io_;
  asio::executor_work_guard<asio::io_context::executor_type> guard_;
  std::vector<std::thread> threads_;
};

HttpServer::HttpServer(const HttpOptions& options, handlers::Core& core, std::shared_ptr<grpc::Channel> channel)
    : impl_(std::make_unique<Impl>(options, core, std::move(channel))) {}
HttpServer::~HttpServer() = default;

void HttpServer::Take(int connection) { impl_->Take(connection); }
void HttpServer::Shutdown() { impl_->Shutdown(); }

}  // namespace axiscal::http
