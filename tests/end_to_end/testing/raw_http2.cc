#include "tests/end_to_end/testing/raw_http2.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <map>
#include <set>
#include <thread>

#include "core/base/demand.h"

namespace axiscal::testing {
namespace {

constexpr std::chrono::seconds kPatience(60);

constexpr uint8_t kData = 0, kHeaders = 1, kRstStream = 3, kSettings = 4, kPing = 6, kWindowUpdate = 8;  // RFC 9113, 6
constexpr uint8_t kInitialWindowSize = 4;                                                                // 6.5.2
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

// The fields that a call begins with.
std::string Head(const std::string& method, const std::vector<std::pair<std::string, std::string>>& metadata) {
  std::string fields = Field(":method", "POST") + Field(":scheme", "http") + Field(":path", method) +
                       Field(":authority", "test") + Field("te", "trailers") +
                       Field("content-type", "application/grpc");
  for (const auto& [name, value] : metadata) fields += Field(name, value);
  return fields;
}

uint32_t NumberAt(const std::string& bytes, size_t at) {
  uint32_t number = 0;
  for (size_t i = at; i < at + 4; ++i) number = number << 8 | static_cast<unsigned char>(bytes[i]);
  return number;
}

}  // namespace

RawConnection::RawConnection(const std::string& address, int room_bytes) {
  const size_t colon = address.rfind(':');
  sockaddr_in to = {};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(colon + 1))));
  inet_pton(AF_INET, address.substr(0, colon).c_str(), &to.sin_addr);
  socket_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (room_bytes > 0) setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &room_bytes, sizeof(room_bytes));
  if (socket_ < 0 || connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof(to)) == 0) return;
  close(std::exchange(socket_, -1));
}

RawConnection::~RawConnection() {
  if (socket_ >= 0) close(socket_);
}

bool RawConnection::Send(const std::string& bytes) {
  for (size_t sent = 0; sent < bytes.size();) {
    const ssize_t count = send(socket_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (count <= 0) return false;
    sent += static_cast<size_t>(count);
  }
  return true;
}

void RawConnection::Greet() {
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
  Greet();
  std::string frames = Frame(kSettings, kAck, 0, "") + Frame(kHeaders, kEndHeaders, 1, Head(method, metadata));
  for (const std::string& message : messages) {
    frames += Frame(kData, 0, 1, BigEndian(0, 1) + BigEndian(static_cast<uint32_t>(message.size()), 4) + message);
  }
  next_head_ = 3;
  if (is_half_closed) frames += Frame(kData, kEndStream, 1, "");
  Send(frames);
}

void RawConnection::SendPart(const std::string& bytes) { Send(Frame(kData, 0, 1, bytes)); }

bool RawConnection::Receive(std::vector<Received>& frames) {
  frames.clear();
  char buffer[4096];
  const ssize_t count = recv(socket_, buffer, sizeof(buffer), 0);
  if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return true;
  if (count <= 0) {
    has_lost_ = count != 0 && errno != ECONNRESET;
    return false;
  }
  unread_.append(buffer, static_cast<size_t>(count));
  const auto byte = [this](size_t i) { return static_cast<uint32_t>(static_cast<unsigned char>(unread_[i])); };
  while (unread_.size() >= 9) {
    const size_t size = byte(0) << 16 | byte(1) << 8 | byte(2);
    if (unread_.size() < 9 + size) break;
    const uint32_t stream = (byte(5) & 0x7F) << 24 | byte(6) << 16 | byte(7) << 8 | byte(8);
    frames.push_back({static_cast<uint8_t>(byte(3)), static_cast<uint8_t>(byte(4)), stream, unread_.substr(9, size)});
    // Who does not answer is cut off for that reason alone.
    if (byte(3) == kPing && (byte(4) & kAck) == 0) Send(Frame(kPing, kAck, 0, frames.back().payload));
    unread_.erase(0, 9 + size);
  }
  return true;
}

bool RawConnection::WaitForEnd(std::string* seen) {
  SetPatience(std::chrono::seconds(1));
  const auto give_up_at = std::chrono::steady_clock::now() + kPatience;
  std::vector<Received> frames;
  while (std::chrono::steady_clock::now() < give_up_at) {
    if (!Receive(frames)) return !has_lost_;
    for (const Received& frame : frames) {
      if (seen != nullptr && (frame.type == kData || frame.type == kHeaders)) *seen += frame.payload;
      if (frame.type == kRstStream || (frame.type == kHeaders && (frame.flags & kEndStream) != 0)) return true;
    }
  }
  return false;
}

RawConnection::HalfSent RawConnection::SendHalf(const std::string& method, int calls, int64_t bytes) {
  constexpr size_t kFrameBytes = 16'384;  // the largest that HTTP/2 has without a setting
  constexpr uint32_t kAnnounced = 4 << 20;
  Greet();
  Send(Frame(kSettings, kAck, 0, ""));
  SetPatience(std::chrono::seconds(1));
  HalfSent sent;
  int64_t room = 65'535, first_room = 65'535;  // what the connection and a new call may send; the server says more
  struct Open {
    int64_t left, room;
  };
  std::map<uint32_t, Open> open;
  const auto take = [&](const Received& frame) {
    const auto number = [&](size_t at) { return NumberAt(frame.payload, at); };
    if (frame.type == kWindowUpdate && frame.stream == 0) room += number(0);
    if (frame.type == kWindowUpdate && open.count(frame.stream) > 0) open[frame.stream].room += number(0);
    if (frame.type == kSettings && (frame.flags & kAck) == 0) {
      for (size_t at = 0; at + 6 <= frame.payload.size(); at += 6) {
        if (frame.payload[at + 1] != kInitialWindowSize) continue;
        for (auto& [stream, one] : open) one.room += number(at + 2) - first_room;
        first_room = number(at + 2);
      }
    }
    const bool is_end = frame.type == kRstStream || (frame.type == kHeaders && (frame.flags & kEndStream) != 0);
    if (is_end && open.erase(frame.stream) > 0) ++sent.ended;
  };
  std::vector<Received> frames;
  uint32_t next_stream = 1;
  bool is_quiet = false;
  for (int begun = 0;;) {
    while (begun < calls && open.size() < 100) {
      ++begun;
      Send(Frame(kHeaders, kEndHeaders, next_stream, Head(method, {})));
      open[next_stream] = {bytes, first_room};
      next_stream += 2;
    }
    bool has_sent = false;
    for (auto& [stream, one] : open) {
      const int64_t count = std::min({one.left, one.room, room, static_cast<int64_t>(kFrameBytes)});
      if (count <= 0) continue;
      const bool is_first = one.left == bytes;
      std::string part(static_cast<size_t>(count), '\x12');
      if (is_first) part.replace(0, 5, BigEndian(0, 1) + BigEndian(kAnnounced, 4));
      Send(Frame(kData, 0, stream, part));
      one.left -= count;
      one.room -= count;
      room -= count;
      sent.bytes += count;
      has_sent = true;
    }
    if (has_sent) SetPatience(std::chrono::milliseconds(1));
    if (!Receive(frames)) {
      sent.ended = begun;
      return sent;
    }
    for (const Received& frame : frames) take(frame);
    if (!has_sent && frames.empty()) {
      if (is_quiet) return sent;
      SetPatience(std::chrono::seconds(1));
    }
    is_quiet = !has_sent && frames.empty();
  }
}

bool RawConnection::BeginHeads(const std::string& method,
                               const std::vector<std::pair<std::string, std::string>>& metadata, int calls) {
  const std::string head = Head(method, metadata);
  std::string heads;
  for (int i = 0; i < calls; ++i, next_head_ += 2) heads += Frame(kHeaders, kEndHeaders, next_head_, head);
  return Send(heads);
}

int RawConnection::CountEnded(int most, std::string* seen) {
  SetPatience(std::chrono::seconds(1));
  const auto give_up_at = std::chrono::steady_clock::now() + kPatience;
  std::set<uint32_t> ended;
  std::vector<Received> frames;
  while (static_cast<int>(ended.size()) < most && std::chrono::steady_clock::now() < give_up_at && Receive(frames)) {
    for (const Received& frame : frames) {
      if (frame.type == kHeaders) *seen += frame.payload;
      if (frame.type == kRstStream || (frame.type == kHeaders && (frame.flags & kEndStream) != 0))
        ended.insert(frame.stream);
    }
  }
  return static_cast<int>(ended.size());
}

bool RawConnection::IsClosed() {
  SetPatience(std::chrono::milliseconds(1));
  std::vector<Received> frames;
  do {
    if (!Receive(frames)) return true;
  } while (!frames.empty());
  return false;
}

int RawConnection::BeginAndReset(const std::string& method, int calls) {
  constexpr uint32_t kCancel = 8;  // RFC 9113, 7
  Greet();
  for (int begun = 0; begun < calls; ++begun) {
    constexpr int kTogether = 200;
    if (begun % kTogether == kTogether - 1) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    const uint32_t stream = 2 * static_cast<uint32_t>(begun) + 1;
    if (!Send(Frame(kHeaders, kEndHeaders | kEndStream, stream, Head(method, {})) +
              Frame(kRstStream, 0, stream, BigEndian(kCancel, 4))))
      return begun;
  }
  return calls;
}

void RawConnection::SetPatience(std::chrono::milliseconds patience) {
  const timeval time = {patience.count() / 1000, patience.count() % 1000 * 1000};
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
