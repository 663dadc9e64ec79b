// HTTP/2 as no gRPC client would speak it: connections that say nothing, metadata of any bytes, replies that nobody
// takes.
#ifndef AXISCAL_TESTS_END_TO_END_TESTING_RAW_HTTP2_H_
#define AXISCAL_TESTS_END_TO_END_TESTING_RAW_HTTP2_H_

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace axiscal::testing {

// One TCP connection to "127.0.0.1:PORT"; closed when it goes.
class RawConnection {
 public:
  // `room_bytes`: so much the system takes for this side until it is received; 0: what it finds right.
  explicit RawConnection(const std::string& address, int room_bytes = 0);
  RawConnection(RawConnection&& other) noexcept
      : socket_(std::exchange(other.socket_, -1)),
        initial_window_bytes_(other.initial_window_bytes_),
        unread_(std::move(other.unread_)),
        next_head_(other.next_head_) {}
  RawConnection& operator=(RawConnection&&) = delete;
  ~RawConnection();

  bool is_connected() const { return socket_ >= 0; }
  // From the greeting on the server may send no byte of a message (a flow-control window of 0): head and status of a
  // call arrive, messages wait.
  void TakeNoMessages() { initial_window_bytes_ = 0; }
  // What every HTTP/2 client begins with. A connection that did not say it is no idle one, but half open.
  void Greet();
  // Greets, calls a method ("/axiscal.v1.Ingest/ListSessions") with one message and returns all that comes until the
  // call or the connection ends, as it comes: gRPC writes the status' message readable (but for '%').
  std::string Call(const std::string& method, const std::vector<std::pair<std::string, std::string>>& metadata,
                   const std::string& message);
  // The same in two steps. Several messages, and a side of ours that stays open, are for streams.
  void Begin(const std::string& method, const std::vector<std::pair<std::string, std::string>>& metadata,
             const std::vector<std::string>& messages, bool is_half_closed = true);
  // More of the call that Begin() began: bytes of its messages.
  void SendPart(const std::string& bytes);
  // Whether the call has ended, with the connection or without, within a minute. `seen`, unless null, gets what came.
  bool WaitForEnd(std::string* seen = nullptr);
  // Whether the server has closed the connection by now. Answers pings.
  bool IsClosed();
  struct HalfSent {
    int64_t bytes = 0;
    int ended = 0;  // calls that the server has ended meanwhile, all where it ended the connection
  };
  // Greets, and sends of each of `calls` calls, 100 at a time, the first `bytes` of a message of 4 MB, as far as the
  // server lets it; returns when that is done, or the server lets nothing more pass for a second.
  HalfSent SendHalf(const std::string& method, int calls, int64_t bytes);
  // After Greet(), without acknowledging the server's settings: begins calls and sends nothing but their heads; false
  // where the connection has ended.
  bool BeginHeads(const std::string& method, const std::vector<std::pair<std::string, std::string>>& metadata,
                  int calls);
  // How many of those the server ends, until there are `most`, the connection has ended or a minute has passed. `seen`
  // gets what came.
  int CountEnded(int most, std::string* seen);
  // Greets, and begins calls and takes each of them back at once, at most 20,000 a second, until the server ends the
  // connection or there were so many; how many.
  int BeginAndReset(const std::string& method, int calls);
  // Waits until the server has closed the connection; false where it does not, after a minute.
  bool WaitForClose();

 private:
  struct Received {
    uint8_t type, flags;
    uint32_t stream;
    std::string payload;
  };
  // The frames that are there in full; false where no more can come. Answers pings.
  bool Receive(std::vector<Received>& frames);
  bool Send(const std::string& bytes);                   // false where the connection has ended
  void SetPatience(std::chrono::milliseconds patience);  // of one recv()

  int socket_ = -1;
  uint32_t initial_window_bytes_ = 65'535;  // what HTTP/2 begins with
  std::string unread_;
  uint32_t next_head_ = 1;  // the stream of the next call of BeginHeads()
  bool has_lost_ = false;   // by another error than the server's end
};

}  // namespace axiscal::testing

#endif  // AXISCAL_TESTS_END_TO_END_TESTING_RAW_HTTP2_H_
