// HTTP/2 as no gRPC client would speak it: connections that say nothing, and metadata of any bytes.
#ifndef AXISCAL_TESTS_END_TO_END_TESTING_RAW_HTTP2_H_
#define AXISCAL_TESTS_END_TO_END_TESTING_RAW_HTTP2_H_

#include <string>
#include <utility>
#include <vector>

namespace axiscal::testing {

// One TCP connection to "127.0.0.1:PORT"; closed when it goes.
class RawConnection {
 public:
  explicit RawConnection(const std::string& address);
  RawConnection(RawConnection&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}
  RawConnection& operator=(RawConnection&&) = delete;
  ~RawConnection();

  bool is_connected() const { return socket_ >= 0; }
  // What every HTTP/2 client begins with. A connection that did not say it is no idle one, but half open.
  void Greet();
  // Greets, calls a method ("/axiscal.v1.Ingest/ListSessions") with one message and returns all that comes until the
  // call or the connection ends, as it comes: gRPC writes the status' message readable (but for '%').
  std::string Call(const std::string& method, const std::vector<std::pair<std::string, std::string>>& metadata,
                   const std::string& message);
  // Waits until the server has closed the connection; false where it does not, after a minute.
  bool WaitForClose();

 private:
  void Send(const std::string& bytes);

  int socket_ = -1;
};

}  // namespace axiscal::testing

#endif  // AXISCAL_TESTS_END_TO_END_TESTING_RAW_HTTP2_H_
