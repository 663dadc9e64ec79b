#include "server/http/connection.h"

#include <openssl/pem.h>
#include <openssl/x509.h>

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <future>
#include <limits>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "core/base/error_detail.h"
#include "server/http/errors.h"

namespace axiscal::http {
namespace {

using boost::system::error_code;

// A head (request line and fields) is no longer, and is there within so long after its first byte.
constexpr uint32_t kMostHeadBytes = 16 << 10;
constexpr std::chrono::seconds kHeadTime(20);
// How long a caller whose body was not read may go on sending it: without that it would lose the answer.
constexpr std::chrono::seconds kLingerTime(2);
// Of one read: a record of TLS.
constexpr size_t kReadBytes = 16 << 10;

std::string StatusLine(int status) {
  constexpr int kClientClosedRequest = 499;  // of the Connect protocol for "canceled"; no name in HTTP's registry
  if (status == kClientClosedRequest) return "HTTP/1.1 499 Client Closed Request\r\n";
  const auto reason = boost::beast::http::obsolete_reason(static_cast<boost::beast::http::status>(status));
  return absl::StrCat("HTTP/1.1 ", status, " ", std::string(reason), "\r\n");
}

std::string HttpDate() {
  char text[64];
  const std::time_t now = std::time(nullptr);
  std::tm utc = {};
  gmtime_r(&now, &utc);
  return {text, std::strftime(text, sizeof(text), "%a, %d %b %Y %H:%M:%S GMT", &utc)};
}

// `more`: how the body is told from what follows.
std::string HeadText(int status, const Fields& fields, const std::string& more, bool stays) {
  std::string text = StatusLine(status);
  const auto add = [&](const std::string& name, const std::string& value) {
    absl::StrAppend(&text, name, ": ", value, "\r\n");
  };
  add("Date", HttpDate());
  bool has_cache = false, has_policy = false;
  for (const auto& [name, value] : fields) {
    add(name, value);
    has_cache |= name == "Cache-Control";
    has_policy |= name == "Content-Security-Policy";
  }
  if (!has_cache) add("Cache-Control", "no-store");
  add("X-Content-Type-Options", "nosniff");
  // What is no page of ours (server/http/pages.h) is not shown as one.
  if (!has_policy) add("Content-Security-Policy", "default-src 'none'; frame-ancestors 'none'");
  if (!stays) add("Connection", "close");
  return text + more + "\r\n";
}

bool MayHaveBody(int status) { return status != 204 && status != 304; }

std::string WholeText(const Answer& answer, bool stays) {
  const std::string length =
      MayHaveBody(answer.status) ? absl::StrCat("Content-Length: ", answer.body.size(), "\r\n") : "";
  return HeadText(answer.status, answer.fields, length, stays) + answer.body;
}

Answer BadRequest(int status, const std::string& text) {
  Answer answer = ErrorAnswer(base::Error(absl::StatusCode::kInvalidArgument, text, {"MESSAGE_INVALID", {}}));
  answer.status = status;
  return answer;
}

template <typename Parser>
bool HasBody(const Parser& parser) {
  return parser.chunked() || parser.content_length().value_or(0) > 0;
}

template <typename Message>
bool FillRequest(const Message& message, Request& request) {
  request.method = std::string(message.method_string());
  for (const auto& field : message) {
    std::string& value = request.fields[absl::AsciiStrToLower(std::string(field.name_string()))];
    value += (value.empty() ? "" : ", ") + std::string(field.value());
  }
  return SplitTarget(std::string(message.target()), &request.path, &request.query);
}

// Of the caller's certificate, which TLS has verified.
void TakeCertificate(SSL* ssl, const HttpOptions& options, Peer& peer) {
  const std::unique_ptr<X509, decltype(&X509_free)> certificate(SSL_get1_peer_certificate(ssl), &X509_free);
  if (certificate == nullptr || SSL_get_verify_result(ssl) != X509_V_OK) return;
  X509_NAME* const subject = X509_get_subject_name(certificate.get());
  const int at = X509_NAME_get_index_by_NID(subject, NID_commonName, -1);
  unsigned char* name = nullptr;
  const int size = at < 0 ? -1 : ASN1_STRING_to_UTF8(&name, X509_NAME_ENTRY_get_data(X509_NAME_get_entry(subject, at)));
  if (size >= 0) peer.certificate_name = std::string(reinterpret_cast<const char*>(name), static_cast<size_t>(size));
  OPENSSL_free(name);
  const std::unique_ptr<BIO, decltype(&BIO_free_all)> text(BIO_new(BIO_s_mem()), &BIO_free_all);
  char* bytes = nullptr;
  if (text == nullptr || PEM_write_bio_X509(text.get(), certificate.get()) != 1) return;
  const long length = BIO_get_mem_data(text.get(), &bytes);
  peer.certificate_ends = options.end_of_certificate({bytes, static_cast<size_t>(length)});
}

}  // namespace

// The answer's way from the request's thread to the strand.
class Connection::RequestExchange final : public Exchange {
 public:
  RequestExchange(std::shared_ptr<Connection> connection, bool stays, bool has_chunks)
      : connection_(std::move(connection)), stays_(stays), has_chunks_(has_chunks) {}

  bool Send(Answer answer) override {
    is_whole_ = Put(WholeText(answer, stays_));
    return is_whole_;
  }
  bool Begin(int status, Fields fields, std::optional<int64_t> length) override {
    left_ = length;
    is_chunked_ = !length && has_chunks_;
    // Before HTTP/1.1 a body without a length ends with the connection.
    stays_ = stays_ && (length || is_chunked_);
    return Put(HeadText(status, fields,
                        length        ? absl::StrCat("Content-Length: ", *length, "\r\n")
                        : is_chunked_ ? "Transfer-Encoding: chunked\r\n"
                                      : "",
                        stays_));
  }
  bool Write(std::string part) override {
    if (part.empty()) return true;
    if (left_) *left_ -= static_cast<int64_t>(part.size());
    return Put(is_chunked_ ? absl::StrCat(absl::Hex(part.size()), "\r\n", part, "\r\n") : std::move(part));
  }
  bool End() override {
    is_whole_ = left_.value_or(0) == 0 && (!is_chunked_ || Put("0\r\n\r\n"));
    return is_whole_;
  }
  void OnLeave(std::function<void()> leave) override {
    const base::MutexLock lock(mutex_);
    leave_ = std::move(leave);
    if (has_left_ && leave_) leave_();
  }

  // From the strand.
  void Leave() {
    const base::MutexLock lock(mutex_);
    has_left_ = true;
    if (leave_) leave_();
  }
  // From the request's thread, when nothing more comes.
  void Done() {
    asio::post(connection_->strand_, [connection = connection_, this] {
      is_done_ = true;
      connection->Signal();
    });
  }
  bool is_done() const { return is_done_; }
  // Once it is done: whether another request may follow.
  bool may_stay() const { return is_whole_ && stays_; }

 private:
  bool Put(std::string bytes) {
    const auto written = std::make_shared<std::promise<bool>>();
    std::future<bool> result = written->get_future();
    asio::co_spawn(
        connection_->strand_,
        [connection = connection_, text = std::move(bytes), written]() -> asio::awaitable<void> {
          const bool is_good = co_await connection->WriteAll(text);
          written->set_value(is_good);
        },
        asio::detached);
    return result.get();
  }

  const std::shared_ptr<Connection> connection_;
  // Of the request's thread until Done().
  bool stays_, is_chunked_ = false, is_whole_ = false;
  const bool has_chunks_;
  std::optional<int64_t> left_;
  bool is_done_ = false;  // of the strand
  base::Mutex mutex_;
  bool has_left_ AXISCAL_GUARDED_BY(mutex_) = false;
  std::function<void()> leave_ AXISCAL_GUARDED_BY(mutex_);
};

Connection::Connection(ConnectionContext& context, Socket socket, std::shared_ptr<asio::ssl::context> tls, Peer peer)
    : context_(context),
      strand_(socket.get_executor()),
      socket_(std::move(socket)),
      tls_context_(std::move(tls)),
      deadline_(strand_),
      signal_(strand_),
      address_(peer.address),
      peer_(std::move(peer)) {
  if (tls_context_ != nullptr) tls_.emplace(socket_, *tls_context_);
}

void Connection::Start() {
  asio::co_spawn(
      strand_, [self = shared_from_this()] { return self->Run(); }, asio::detached);
}

void Connection::Close() {
  asio::post(strand_, [self = shared_from_this()] { self->CloseNow(); });
}

void Connection::CloseNow() {
  error_code ignored;
  deadline_.cancel();
  socket_.close(ignored);
  if (exchange_ != nullptr) exchange_->Leave();
}

void Connection::SetDeadline(std::chrono::milliseconds after) {
  deadline_.expires_after(after);
  deadline_.async_wait([self = shared_from_this()](const error_code& error) {
    // It may have been moved when this was under way already.
    if (!error && self->deadline_.expiry() <= std::chrono::steady_clock::now()) self->CloseNow();
  });
}

void Connection::NoDeadline() { deadline_.expires_at(std::chrono::steady_clock::time_point::max()); }

asio::awaitable<void> Connection::WaitForSignal() {
  error_code woken;
  signal_.expires_at(std::chrono::steady_clock::time_point::max());
  co_await signal_.async_wait(asio::redirect_error(asio::use_awaitable, woken));
}

asio::awaitable<bool> Connection::Fill() {
  error_code error;
  size_t count = 0;
  const auto room = buffer_.prepare(kReadBytes);
  if (tls_) {
    count = co_await tls_->async_read_some(room, asio::redirect_error(asio::use_awaitable, error));
  } else {
    count = co_await socket_.async_read_some(room, asio::redirect_error(asio::use_awaitable, error));
  }
  buffer_.commit(count);
  co_return !error && count > 0;
}

asio::awaitable<bool> Connection::WriteAll(const std::string& bytes) {
  error_code error;
  SetDeadline(context_.options.silence);
  if (tls_) {
    co_await asio::async_write(*tls_, asio::buffer(bytes), asio::redirect_error(asio::use_awaitable, error));
  } else {
    co_await asio::async_write(socket_, asio::buffer(bytes), asio::redirect_error(asio::use_awaitable, error));
  }
  NoDeadline();
  co_return !error;
}

asio::awaitable<void> Connection::Watch() {
  const bool is_there = co_await Fill();
  is_watching_ = false;
  if (!is_there) {
    has_left_ = true;
    if (exchange_ != nullptr) exchange_->Leave();
  }
  Signal();
}

asio::awaitable<void> Connection::Linger() {
  error_code ignored;
  socket_.shutdown(Socket::shutdown_send, ignored);
  SetDeadline(kLingerTime);
  while (is_watching_) co_await WaitForSignal();
  bool is_there = !has_left_;
  while (is_there) {
    buffer_.consume(buffer_.size());
    is_there = co_await Fill();
  }
}

asio::awaitable<bool> Connection::Refuse(const Request& request, const Answer& answer, bool may_stay) {
  const std::optional<Answer> too_often = context_.gateway.Count(request);
  const Answer& told = too_often ? *too_often : answer;
  if (!too_often || context_.gateway.TellsOfTooOften()) context_.options.tell_refused(request, told);
  const std::string text = WholeText(told, may_stay);
  const bool is_written = co_await WriteAll(text);
  if (is_written && !may_stay) co_await Linger();
  co_return is_written&& may_stay;
}

asio::awaitable<bool> Connection::ReadHead(Parser& parser) {
  SetDeadline(kHeadTime);
  error_code error;
  while (true) {
    // With nothing to read the parser would take it for the end.
    if (buffer_.size() > 0) buffer_.consume(parser.put(buffer_.data(), error));
    if (parser.is_header_done()) co_return true;
    if (error && error != boost::beast::http::error::need_more) break;
    const bool is_there = co_await Fill();
    if (!is_there) co_return false;
  }
  Request unread;
  unread.peer = peer_;
  Answer answer = BadRequest(400, "this is no HTTP/1.1: " + error.message());
  if (error == boost::beast::http::error::header_limit)
    answer = BadRequest(431, absl::StrCat("a head of more than ", kMostHeadBytes, " bytes"));
  co_await Refuse(unread, answer, false);
  co_return false;
}

asio::awaitable<bool> Connection::ReadBody(Parser& parser, const BodyRule& rule, handlers::Share& held,
                                           Request& request) {
  request.is_too_large = request.content_length.value_or(0) > rule.most_bytes;
  if (request.is_too_large || !HasBody(parser)) co_return true;
  if (absl::AsciiStrToLower(request.Field("expect")) == "100-continue") {
    const std::string go_on = "HTTP/1.1 100 Continue\r\n\r\n";
    const bool is_written = co_await WriteAll(go_on);
    if (!is_written) co_return false;
  }
  parser.eager(true);
  error_code error;
  while (true) {
    if (buffer_.size() > 0) buffer_.consume(parser.put(buffer_.data(), error));
    const int64_t size = static_cast<int64_t>(parser.get().body().size());
    request.is_too_large = size > rule.most_bytes;
    if (parser.is_done() || request.is_too_large) break;
    if (error && error != boost::beast::http::error::need_more) {
      const Answer answer = BadRequest(400, "the body is no HTTP/1.1: " + error.message());
      co_await Refuse(request, answer, false);
      co_return false;
    }
    const absl::Status grown = held.GrowTo(size);
    if (!grown.ok()) {
      const Answer answer = ErrorAnswer(grown);
      co_await Refuse(request, answer, false);
      co_return false;
    }
    SetDeadline(context_.options.silence);
    const bool is_there = co_await Fill();
    if (!is_there) co_return false;
  }
  NoDeadline();
  if (!request.is_too_large) request.body = std::move(parser.get().body());
  co_return true;
}

asio::awaitable<bool> Connection::ServeOne() {
  Parser parser;
  parser.header_limit(kMostHeadBytes);
  // BodyRule is what limits it; "none" is less than any length for Boost 1.74.
  parser.body_limit(std::numeric_limits<uint64_t>::max());
  const bool has_head = co_await ReadHead(parser);
  if (!has_head) co_return false;
  const auto request = std::make_shared<Request>();
  request->peer = peer_;
  if (const auto length = parser.content_length()) {
    request->content_length = static_cast<int64_t>(std::min<uint64_t>(*length, std::numeric_limits<int64_t>::max()));
  }
  const bool is_new = parser.get().version() == 11;
  const bool stays = parser.keep_alive();
  if (!FillRequest(parser.get(), *request) || (is_new && request->fields.count("host") == 0)) {
    const Answer answer = BadRequest(400, "a request needs a target that begins with / and a Host");
    co_await Refuse(*request, answer, false);
    co_return false;
  }
  // Of a body in a coding that is not known the end is not known either (RFC 9112, section 6.1): what it holds would be
  // read as further requests.
  if (request->fields.count("transfer-encoding") > 0 &&
      absl::AsciiStrToLower(request->Field("transfer-encoding")) != "chunked") {
    const Answer answer = BadRequest(501, "Transfer-Encoding must be chunked");
    co_await Refuse(*request, answer, false);
    co_return false;
  }
  const BodyRule rule = context_.gateway.RuleFor(*request);
  if (rule.is_known) is_known_ = true;
  if (rule.refusal) {
    const bool goes_on = co_await Refuse(*request, *rule.refusal, stays && !HasBody(parser));
    co_return goes_on;
  }
  request->counted_as = rule.counted_as;
  handlers::Share held(context_.gateway.budget(), rule.counted_as);
  const bool is_there = co_await ReadBody(parser, rule, held, *request);
  if (!is_there) co_return false;
  const bool is_read = !request->is_too_large;

  NoDeadline();
  const auto exchange = std::make_shared<RequestExchange>(shared_from_this(), stays && is_read, is_new);
  exchange_ = exchange;
  Gateway& gateway = context_.gateway;
  const bool is_started = context_.start(rule.counted_as, [exchange, request, &gateway] {
    try {
      gateway.Serve(*request, *exchange);
    } catch (const std::exception&) {
      // No memory, or a thread of gRPC's that could not be started: what was not answered is cut off.
    }
    exchange->Done();
  });
  if (!is_started) {
    exchange_ = nullptr;
    const Answer answer =
        ErrorAnswer(base::Error(absl::StatusCode::kUnavailable,
                                "too many requests are under way, of all callers or of this one", {"QUEUE_FULL", {}}));
    const bool goes_on = co_await Refuse(*request, answer, stays && is_read);
    co_return goes_on;
  }
  if (buffer_.size() == 0) {
    is_watching_ = true;
    asio::co_spawn(
        strand_, [self = shared_from_this()] { return self->Watch(); }, asio::detached);
  }
  while (!exchange->is_done()) co_await WaitForSignal();
  exchange_ = nullptr;
  if (!is_read) co_await Linger();
  co_return exchange->may_stay();
}

asio::awaitable<bool> Connection::Shake() {
  error_code error;
  SetDeadline(kHeadTime);
  co_await tls_->async_handshake(asio::ssl::stream_base::server, asio::redirect_error(asio::use_awaitable, error));
  if (!error) TakeCertificate(tls_->native_handle(), context_.options, peer_);
  co_return !error;
}

asio::awaitable<void> Connection::Run() {
  bool goes_on = true;
  if (tls_) goes_on = co_await Shake();
  while (goes_on) {
    SetDeadline(context_.options.idle);
    while (is_watching_) co_await WaitForSignal();
    if (has_left_) break;
    if (buffer_.size() == 0) goes_on = co_await Fill();
    if (goes_on) goes_on = co_await ServeOne();
  }
  CloseNow();
}

}  // namespace axiscal::http
