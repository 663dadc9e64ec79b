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

constexpr std::chrono::seconds kPatience(60);

constexpr uint8_t kData = 0, kHeaders = 1, kRstStream = 3, kSettings = 4, kPing = 6;  // RFC 9113, 6
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

void RawConnection::Greet() {
  constexpr uint32_t kInitialWindowSize = 4;  // the setting's number (RFC 9113, 6.5.2)
  Send("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" +
       Frame(kSettings, 0, 0, BigEndian(kInitialWindowSize, 2) + BigEndian(initial_window_bytes_, 4)));
}

std::string RawConnection::Call(const std::string& method,
                                const std::vector<std::pair<std::string, std::string>>& metadata,
                                const std::string& message) {
  Begin(method, metadata, {message});
  std::string seen;
  WaitForEnd(&seen);
  return seen;
}

void RawConnection::Begin(const std::string& method, const std::vector<std::pair<std::string, std::string>>& metadata,
                          const std::vector<std::string>& messages, bool is_half_closed) {
  std::string fields = Field(":method", "POST") + Field(":scheme", "http") + Field(":path", method) +
                       Field(":authority", "test") + Field("te", "trailers") +
                       Field("content-type", "application/grpc");
  for (const auto& [name, value] : metadata) fields += Field(name, value);
  Greet();
  std::string frames = Frame(kSettings, kAck, 0, "") + Frame(kHeaders, kEndHeaders, 1, fields);
  for (const std::string& message : messages) {
    frames += Frame(kData, 0, 1, BigEndian(0, 1) + BigEndian(static_cast<uint32_t>(message.size()), 4) + message);
  }
  if (is_half_closed) frames += Frame(kData, kEndStream, 1, "");
  Send(frames);
}

bool RawConnection::WaitForEnd(std::string* seen) {
  SetPatience(std::chrono::seconds(1));
  std::string unread;
  const auto give_up_at = std::chrono::steady_clock::now() + kPatience;
  while (std::chrono::steady_clock::now() < give_up_at) {
    char buffer[4096];
    const ssize_t count = recv(socket_, buffer, sizeof(buffer), 0);
    if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) continue;
    if (count <= 0) return count == 0 || errno == ECONNRESET;
    unread.append(buffer, static_cast<size_t>(count));
    const auto byte = [&unread](size_t i) { return static_cast<size_t>(static_cast<unsigned char>(unread[i])); };
    while (unread.size() >= 9) {
      const size_t size = byte(0) << 16 | byte(1) << 8 | byte(2);
      if (unread.size() < 9 + size) break;
      const bool is_last = byte(3) == kRstStream || (byte(3) == kHeaders && (byte(4) & kEndStream) != 0);
      if (seen != nullptr && (byte(3) == kData || byte(3) == kHeaders)) *seen += unread.substr(9, size);
      // Who does not answer is cut off for that reason alone.
      if (byte(3) == kPing && (byte(4) & kAck) == 0) Send(Frame(kPing, kAck, 0, unread.substr(9, size)));
      unread.erase(0, 9 + size);
      if (is_last) return true;
    }
  }
  return false;
}

void RawConnection::SetPatience(std::chrono::seconds patience) {
  const timeval time = {patience.count(), 0};
  setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &time, sizeof(time));
}

bool RawConnection::WaitForClose() {
  SetPatience(kPatience);
  char buffer[4096];
  ssize_t count = 0;
  while ((count = recv(socket_, buffer, sizeof(buffer), 0)) > 0) {
  }
  return count == 0 || errno == ECONNRESET;
}

}  // namespace axiscal::testing
