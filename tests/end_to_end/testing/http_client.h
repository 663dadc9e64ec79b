// One HTTP/1.1 connection as a test sees it: bytes out, answers in. The answers are read by Boost.Beast.
#ifndef AXISCAL_TESTS_END_TO_END_TESTING_HTTP_CLIENT_H_
#define AXISCAL_TESTS_END_TO_END_TESTING_HTTP_CLIENT_H_

#include <map>
#include <memory>
#include <string>

namespace axiscal::testing {

using HttpFields = std::map<std::string, std::string>;

struct HttpAnswer {
  int status = 0;     // 0: there was none
  HttpFields fields;  // lower-case names
  std::string body;
  bool is_whole = false;  // its end was seen

  std::string Field(const std::string& name) const {
    const auto found = fields.find(name);
    return found == fields.end() ? "" : found->second;
  }
};

class HttpConnection {
 public:
  // To 127.0.0.1. Gives up on an answer after a minute.
  explicit HttpConnection(int port);
  ~HttpConnection();
  HttpConnection(HttpConnection&&) noexcept;

  void Send(const std::string& bytes);
  // A request with Host and, where there is a body or the method is POST, Content-Length.
  void SendRequest(const std::string& method, const std::string& target, const HttpFields& fields = {},
                   const std::string& body = "");
  HttpAnswer Receive();
  // Until that many bytes of a body have come, or its end; what there is of it. For answers that go on.
  HttpAnswer ReceiveSome(size_t body_bytes);
  // Whether the server has closed the connection, waiting for it.
  bool WaitForClose();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// On a connection of its own.
HttpAnswer Fetch(int port, const std::string& method, const std::string& target, const HttpFields& fields = {},
                 const std::string& body = "");
// A call by the Connect protocol in JSON.
HttpAnswer CallJson(int port, const std::string& method, const std::string& json, HttpFields fields = {});

}  // namespace axiscal::testing

#endif  // AXISCAL_TESTS_END_TO_END_TESTING_HTTP_CLIENT_H_
