#include "tests/end_to_end/testing/raw_http2.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>

#include "core/base/demand.h"

namespace axiscal::testing {
namespace {

constexpr uint8_t kData = 0, kHeaders = 1, kRstStream = 3, kSettings = 4;  // RFC 9113, 6
constexpr uint8_t kEndStream = 1, kAck = 1, kEndHeaders = 4;

std::string BigEndian(uint32_t number, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(number >> (8 * i) & 0xFF);
  return text;
}

std::string Frame(uint8_t type, uint8_t flags, uint32_t stream, const std::string& payload) {
  return BigEndian(static_cast<uint32_t>(payload.size()), 3) + BigEndian(type, 1) + BigEndian(flags, 1) +
         BigEndian(stream, 4) + payload;
}

// A text of HPACK, not compressed (RFC 7541, 5.2).
std::string Text(const std::string& text) {
  DEMAND(text.size() < 127);
  return BigEndian(static_cast<uint32_t>(text.size()), 1) + text;
}

std::string Field(const std::string& name, const std::string& value) {
  return BigEndian(0, 1) + Text(name) + Text(value);
}

}  // namespace

RawConnection::RawConnection(const std::string& address) {
  const size_t colon = address.rfind(':');
  sockaddr_in to = {};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(colon + 1))));
  inet_pton(AF_INET, address.substr(0, colon).c_str(), &to.sin_addr);
  socket_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (socket_ < 0 || connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof(to)) == 0) return;
  close(std::exchange(socket_, -1));
}

RawConnection::~RawConnection() {
  if (socket_ >= 0) close(socket_);
}

void RawConnection::Send(const std::string& bytes) {
  for (size_t sent = 0; sent < bytes.size();) {
    const ssize_t count = send(socket_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (count <= 0) return;
    sent += static_cast<size_t>(count);
  }
}

void RawConnection::Greet() { Send("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + Frame(kSettings, 0, 0, "")); }

std::string RawConnection::Call(const std::string& method,
                                const std::vector<std::pair<std::string, std::string>>& metadata,
                                const std::string& message) {
  std::string fields = Field(":method", "POST") + Field(":scheme", "http") + Field(":path", method) +
                       Field(":authority", "test") + Field("te", "trailers") +
                       Field("content-type", "application/grpc");
  for (const auto& [name, value] : metadata) fields += Field(name, value);
  Greet();
  Send(Frame(kSettings, kAck, 0, "") + Frame(kHeaders, kEndHeaders, 1, fields) +
       Frame(kData, kEndStream, 1, BigEndian(0, 1) + BigEndian(static_cast<uint32_t>(message.size()), 4) + message));
  std::string seen, unread;
  while (true) {
    char buffer[4096];
    const ssize_t count = recv(socket_, buffer, sizeof(buffer), 0);
    if (count <= 0) return seen;
    unread.append(buffer, static_cast<size_t>(count));
    const auto byte = [&unread](size_t i) { return static_cast<size_t>(static_cast<unsigned char>(unread[i])); };
    while (unread.size() >= 9) {
      const size_t size = byte(0) << 16 | byte(1) << 8 | byte(2);
      if (unread.size() < 9 + size) break;
      const bool is_last = byte(3) == kRstStream || (byte(3) == kHeaders && (byte(4) & kEndStream) != 0);
      if (byte(3) == kData || byte(3) == kHeaders) seen += unread.substr(9, size);
      unread.erase(0, 9 + size);
      if (is_last) return seen;
    }
  }
}

bool RawConnection::WaitForClose() {
  char buffer[4096];
  const timeval patience = {60, 0};
  setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
  ssize_t count = 0;
  while ((count = recv(socket_, buffer, sizeof(buffer), 0)) > 0) {
  }
  return count == 0 || errno == ECONNRESET;
}

}  // namespace axiscal::testing
