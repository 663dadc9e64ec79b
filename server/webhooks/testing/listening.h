// A socket that listens on a free port of this machine, for receivers of tests.
#ifndef AXISCAL_SERVER_WEBHOOKS_TESTING_LISTENING_H_
#define AXISCAL_SERVER_WEBHOOKS_TESTING_LISTENING_H_

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "core/base/demand.h"

namespace axiscal::webhooks {

class Listening {
 public:
  Listening() {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    DEMAND(bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0);
    DEMAND(listen(socket_, 16) == 0);
    socklen_t size = sizeof(address);
    DEMAND(getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size) == 0);
    port_ = ntohs(address.sin_port);
  }
  ~Listening() { close(socket_); }
  Listening(const Listening&) = delete;
  Listening& operator=(const Listening&) = delete;

  int port() const { return port_; }
  // The next connection, for the caller to close; -1 after Stop().
  int Accept() { return accept(socket_, nullptr, nullptr); }
  void Stop() { shutdown(socket_, SHUT_RDWR); }

 private:
  const int socket_ = socket(AF_INET, SOCK_STREAM, 0);
  int port_ = 0;
};

}  // namespace axiscal::webhooks

#endif  // AXISCAL_SERVER_WEBHOOKS_TESTING_LISTENING_H_
