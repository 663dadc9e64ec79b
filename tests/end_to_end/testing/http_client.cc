#include "tests/end_to_end/testing/http_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <limits>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"

namespace axiscal::testing {

namespace http = boost::beast::http;

struct HttpConnection::Impl {
  int socket = -1;
  boost::beast::flat_buffer buffer;
  std::unique_ptr<http::response_parser<http::string_body>> parser;

  // False at the end of the connection.
  bool Fill() {
    const auto room = buffer.prepare(64 << 10);
    const ssize_t count = recv(socket, room.data(), room.size(), 0);
    if (count > 0) buffer.commit(static_cast<size_t>(count));
    return count > 0;
  }
};

HttpConnection::HttpConnection(int port) : impl_(std::make_unique<Impl>()) {
  impl_->socket = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const timeval patience = {60, 0};
  setsockopt(impl_->socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
  if (connect(impl_->socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    close(std::exchange(impl_->socket, -1));
  }
}

HttpConnection::HttpConnection(HttpConnection&&) noexcept = default;

HttpConnection::~HttpConnection() {
  if (impl_ != nullptr && impl_->socket >= 0) close(impl_->socket);
}

void HttpConnection::Send(const std::string& bytes) {
  for (size_t at = 0; at < bytes.size();) {
    const ssize_t count = send(impl_->socket, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
    if (count <= 0) return;
    at += static_cast<size_t>(count);
  }
}

void HttpConnection::SendRequest(const std::string& method, const std::string& target, const HttpFields& fields,
                                 const std::string& body) {
  std::string head = method + " " + target + " HTTP/1.1\r\n";
  if (!fields.contains("Host")) head += "Host: localhost\r\n";
  for (const auto& [name, value] : fields) absl::StrAppend(&head, name, ": ", value, "\r\n");
  if (method == "POST" || !body.empty()) absl::StrAppend(&head, "Content-Length: ", body.size(), "\r\n");
  Send(head + "\r\n" + body);
}

HttpAnswer HttpConnection::Receive() { return ReceiveSome(std::string::npos); }

HttpAnswer HttpConnection::ReceiveSome(size_t body_bytes) {
  if (impl_->parser == nullptr) {
    impl_->parser = std::make_unique<http::response_parser<http::string_body>>();
    impl_->parser->body_limit(std::numeric_limits<uint64_t>::max());
    impl_->parser->eager(true);
  }
  auto& parser = *impl_->parser;
  boost::system::error_code error;
  while (!parser.is_done()) {
    if (impl_->buffer.size() > 0) impl_->buffer.consume(parser.put(impl_->buffer.data(), error));
    if (error && error != http::error::need_more) break;
    if (parser.is_done() || (parser.is_header_done() && parser.get().body().size() >= body_bytes)) break;
    if (impl_->Fill()) continue;
    if (parser.is_header_done() && parser.need_eof()) parser.put_eof(error);
    break;
  }
  HttpAnswer answer;
  if (!parser.is_header_done()) return answer;
  answer.status = static_cast<int>(parser.get().result_int());
  for (const auto& field : parser.get())
    answer.fields[absl::AsciiStrToLower(std::string(field.name_string()))] = std::string(field.value());
  answer.body = parser.get().body();
  answer.is_whole = parser.is_done();
  if (answer.is_whole) impl_->parser.reset();
  return answer;
}

bool HttpConnection::WaitForClose() {
  do {
    impl_->buffer.consume(impl_->buffer.size());
    errno = 0;  // the end of the connection sets none
  } while (impl_->Fill());
  return errno != EAGAIN && errno != EWOULDBLOCK;
}

HttpAnswer Fetch(int port, const std::string& method, const std::string& target, const HttpFields& fields,
                 const std::string& body) {
  HttpConnection connection(port);
  connection.SendRequest(method, target, fields, body);
  return connection.Receive();
}

HttpAnswer CallJson(int port, const std::string& method, const std::string& json, HttpFields fields) {
  fields.try_emplace("Content-Type", "application/json");
  return Fetch(port, "POST", "/axiscal.v1." + method, fields, json);
}

}  // namespace axiscal::testing
