// Serves the API by HTTP/1.1 on connections that a listener hands it (docs/http.md). Connections wait without a thread;
// each request under way has one. HTTP is spoken by Boost.Beast's parser, TLS by OpenSSL through Boost.Asio.
#ifndef AXISCAL_SERVER_HTTP_HTTP_SERVER_H_
#define AXISCAL_SERVER_HTTP_HTTP_SERVER_H_

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "server/handlers/core.h"
#include "server/http/exchange.h"

namespace grpc {
class Channel;
}

namespace axiscal::http {

// PEM texts.
struct TlsText {
  std::string certificate, key, client_ca;  // client_ca is empty where callers are asked for no certificate
};

struct HttpOptions {
  // A name for this machine that the field Host may have, beside loopback names, where nobody is asked who he is.
  std::string own_host;
  // Null: no TLS. What holds for the next connection; nothing: as it was when it was asked for last.
  std::function<std::optional<TlsText>()> new_tls;
  // When a certificate ends, from its PEM text.
  std::function<std::optional<base::UtcTime>(const std::string& pem)> end_of_certificate;
  // The login of whoever holds the other end of a connection; asked where nobody is asked who he is.
  std::function<std::string(int connection, const std::string& peer)> login_of;
  // Told of each request that is answered without a call: who, what, and how.
  std::function<void(const Request& request, const Answer& answer)> tell_refused;
  // A caller that sends nothing of a body, or takes nothing of an answer, for so long is cut off. > 0.
  std::chrono::milliseconds silence = std::chrono::minutes(5);
  // A connection without a request is closed after so long. > 0.
  std::chrono::milliseconds idle = std::chrono::minutes(5);
  // Connections at a time that have shown no identity, where callers must: one more closes the first of the host that
  // has most. > 0.
  int strangers = 2000;
  // Requests under way at a time; more get UNAVAILABLE. Bytes of all bodies, files and messages at a time; more get
  // RESOURCE_EXHAUSTED. Both are shared fairly between callers (handlers::Budget).
  int max_requests = 3000;
  int64_t max_bytes = int64_t{1} << 30;
};

// Safe from any thread.
class HttpServer {
 public:
  // `core` must outlive it; `channel` leads to its handlers.
  HttpServer(const HttpOptions& options, handlers::Core& core, std::shared_ptr<grpc::Channel> channel);
  // Shuts down.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  // Owns the descriptor from then on. Not after Shutdown().
  void Take(int connection);
  // Cuts all connections off and waits for the requests under way. The channel's server must be shut down before, or
  // they last as long as their calls. Repeating is harmless.
  void Shutdown();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace axiscal::http

#endif  // AXISCAL_SERVER_HTTP_HTTP_SERVER_H_
