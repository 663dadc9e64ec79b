// One connection that speaks HTTP/1.1, from its first byte to its last.
#ifndef AXISCAL_SERVER_HTTP_CONNECTION_H_
#define AXISCAL_SERVER_HTTP_CONNECTION_H_

// awaitable.hpp of Boost 1.74 uses std::exchange without its header.
// clang-format off
#include <utility>
#include <boost/asio/awaitable.hpp>
// clang-format on
#include <atomic>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/base/mutex.h"
#include "server/http/exchange.h"
#include "server/http/gateway.h"
#include "server/http/http_server.h"

namespace axiscal::http {

namespace asio = boost::asio;

// What all connections of a server share; outlives them.
struct ConnectionContext {
  HttpOptions options;
  Gateway& gateway;
  // Runs `work` of that caller on a thread of its own; false where there are too many, of all or of this one.
  std::function<bool(const std::string& who, std::function<void()> work)> start;
};

// Lives as long as something of it is under way. All but Start(), Close(), is_known() and the Exchange run on its
// strand.
class Connection final : public std::enable_shared_from_this<Connection> {
 public:
  using Socket = asio::generic::stream_protocol::socket;

  Connection(ConnectionContext& context, Socket socket, std::shared_ptr<asio::ssl::context> tls, Peer peer);
  void Start();
  void Close();
  // Whether a request over it has shown who calls. From any thread, as Start() and Close().
  bool is_known() const { return is_known_; }
  const std::string& address() const { return address_; }  // of the peer, as gRPC writes it

 private:
  using Parser = boost::beast::http::request_parser<boost::beast::http::string_body>;
  class RequestExchange;

  // What is given by reference lives in the caller's frame, which waits. No coroutine takes an object by value, and
  // none is called with one that is made in the same expression: GCC 12 destroys such an object twice.
  asio::awaitable<void> Run();
  asio::awaitable<bool> Shake();
  // One request with its answer; whether another may follow.
  asio::awaitable<bool> ServeOne();
  asio::awaitable<bool> ReadHead(Parser& parser);
  asio::awaitable<bool> ReadBody(Parser& parser, const BodyRule& rule, handlers::Share& held, Request& request);
  asio::awaitable<bool> Fill();  // more bytes into buffer_; false at the connection's end
  asio::awaitable<bool> WriteAll(const std::string& bytes);
  asio::awaitable<bool> Refuse(const Request& request, const Answer& answer, bool may_stay);
  asio::awaitable<void> Linger();
  asio::awaitable<void> Watch();
  asio::awaitable<void> WaitForSignal();
  void Signal() { signal_.cancel(); }
  void SetDeadline(std::chrono::milliseconds after);
  void NoDeadline();
  void CloseNow();

  ConnectionContext& context_;
  asio::any_io_executor strand_;
  Socket socket_;
  const std::shared_ptr<asio::ssl::context> tls_context_;
  std::optional<asio::ssl::stream<Socket&>> tls_;
  asio::steady_timer deadline_;  // closes the connection
  asio::steady_timer signal_;    // something below has changed
  boost::beast::flat_buffer buffer_;
  const std::string address_;
  Peer peer_;
  std::atomic<bool> is_known_ = false;
  bool is_watching_ = false, has_left_ = false;
  std::shared_ptr<RequestExchange> exchange_;  // of the request under way
};

}  // namespace axiscal::http

#endif  // AXISCAL_SERVER_HTTP_CONNECTION_H_
