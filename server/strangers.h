// Connections from which nobody has called whom the server knows. By TLS each takes some 100 KB, whatever it says.
#ifndef AXISCAL_SERVER_STRANGERS_H_
#define AXISCAL_SERVER_STRANGERS_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>

namespace axiscal::server {

class Strangers {
 public:
  // Of the connections to `port` of this process, of which strangers may have `most`. `is_known`: whether the peer
  // (PeerOf()) is no stranger.
  Strangers(int port, size_t most, std::function<bool(const std::string& peer)> is_known)
      : port_(port), most_(most), is_known_(std::move(is_known)) {}

  // The peers whose connections are to be ended (access::BeyondTheMost), the order of coming as far as one look tells
  // it from the other. By one thread.
  std::set<std::string> TooMany();

 private:
  const int port_;
  const size_t most_;
  const std::function<bool(const std::string& peer)> is_known_;
  std::map<std::string, int64_t> strangers_;  // by peer, in which look they were seen first
  int64_t looks_ = 0;
};

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_STRANGERS_H_
