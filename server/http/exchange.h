// One request as it came by HTTP, and where its answer goes. What answers requests knows neither sockets nor the
// library that speaks HTTP (connection.cc).
#ifndef AXISCAL_SERVER_HTTP_EXCHANGE_H_
#define AXISCAL_SERVER_HTTP_EXCHANGE_H_

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/clock.h"

namespace axiscal::http {

// What is known of the connection that a request came by.
struct Peer {
  std::string address;  // as gRPC writes it: "ipv4:127.0.0.1:51234", "unix:"
  std::string login;    // of a caller on this machine, where nobody is asked who he is
  bool is_tls = false;
  bool is_unix = false;
  std::optional<std::string> certificate_name;  // the common name of a certificate that TLS has verified
  std::optional<base::UtcTime> certificate_ends;
};

struct Request {
  std::string method;                         // "POST"
  std::string path;                           // without the query, not decoded
  std::map<std::string, std::string> query;   // decoded; of a name that stands twice the last
  std::map<std::string, std::string> fields;  // lower-case names; the values of one that stands twice joined by ", "
  std::optional<int64_t> content_length;      // nothing for a body of unknown length
  std::string body;
  bool is_too_large = false;  // the body is longer than it may be, and was not read
  Peer peer;
  // Whose requests and memory it counts as: the principal's name, or the address of who is nobody.
  std::string counted_as;

  // Of a field; empty where there is none.
  std::string Field(const std::string& name) const {
    const auto found = fields.find(name);
    return found == fields.end() ? "" : found->second;
  }
};

using Fields = std::vector<std::pair<std::string, std::string>>;

struct Answer {
  int status = 200;
  Fields fields;
  std::string body;
};

// Where the answer to one request goes. All block until the caller has taken enough of what was sent before; false: the
// caller has left, or has taken nothing for too long. One thread at a time, but for OnLeave's function.
class Exchange {
 public:
  virtual ~Exchange() = default;
  virtual bool Send(Answer answer) = 0;
  // Instead, an answer in parts: `length` where it is known, bytes. What ends without End() is cut off, so that nobody
  // takes it for whole.
  virtual bool Begin(int status, Fields fields, std::optional<int64_t> length) = 0;
  virtual bool Write(std::string part) = 0;
  virtual bool End() = 0;
  // Runs `leave` when the caller leaves, on another thread, at once where it has left. Replaces the one before: after
  // OnLeave(nullptr) none runs any more.
  virtual void OnLeave(std::function<void()> leave) = 0;
};

// "a%20b" -> "a b"; nothing where a '%' has no two hexadecimal digits behind it.
std::optional<std::string> PercentDecoded(const std::string& text);
// A target "/path?a=b&c" into path and query. False where it is none.
bool SplitTarget(const std::string& target, std::string* path, std::map<std::string, std::string>* query);
// The words between `separator`, without blanks around them.
std::vector<std::string> Words(const std::string& text, char separator);

}  // namespace axiscal::http

#endif  // AXISCAL_SERVER_HTTP_EXCHANGE_H_
