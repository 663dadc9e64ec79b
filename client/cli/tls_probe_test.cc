#include "client/cli/tls_probe.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <thread>

namespace axiscal::cli {
namespace {

// A server out of descriptors takes connections and closes them at once. The probe ended by SIGPIPE.
TEST(TlsProbe, AServerThatClosesAtOnceSpeaksNoTls) {
  const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  ASSERT_EQ(bind(listener, reinterpret_cast<const sockaddr*>(&address), size), 0);
  ASSERT_EQ(listen(listener, 8), 0);
  ASSERT_EQ(getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size), 0);
  constexpr int kTries = 20;
  std::thread server([listener] {
    for (int i = 0; i < kTries; ++i) close(accept(listener, nullptr, nullptr));
  });
  const std::string at = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  for (int i = 0; i < kTries; ++i) EXPECT_FALSE(ProbeServer(at, "").speaks_tls);
  server.join();
  close(listener);
}

}  // namespace
}  // namespace axiscal::cli
