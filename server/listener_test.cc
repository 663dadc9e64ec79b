#include "server/listener.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <ifaddrs.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <future>

#include "absl/strings/str_cat.h"
#include "core/base/error_detail.h"

namespace axiscal::server {
namespace {

// Connects to 127.0.0.1; the listener has it by the time it returns.
int ConnectTo(int port) {
  sockaddr_in to = {};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<uint16_t>(port));
  inet_pton(AF_INET, "127.0.0.1", &to.sin_addr);
  const int made = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (connect(made, reinterpret_cast<sockaddr*>(&to), sizeof(to)) == 0) return made;
  close(made);
  return -1;
}

// As gRPC names it: with the number of its interface.
TEST(Listener, TellsTheInterfaceOfALinkLocalPeer) {
  ifaddrs* all = nullptr;
  ASSERT_EQ(getifaddrs(&all), 0);
  sockaddr_in6 to = {};
  for (const ifaddrs* at = all; at != nullptr; at = at->ifa_next) {
    if (at->ifa_addr == nullptr || at->ifa_addr->sa_family != AF_INET6) continue;
    const auto& address = *reinterpret_cast<const sockaddr_in6*>(at->ifa_addr);
    if (IN6_IS_ADDR_LINKLOCAL(&address.sin6_addr)) to = address;
  }
  freeifaddrs(all);
  if (to.sin6_scope_id == 0) GTEST_SKIP() << "no interface of this machine has a link-local address";
  const auto listener = Listener::Open("[::]:0");
  ASSERT_TRUE(listener.ok()) << listener.status();
  to.sin6_port = htons(static_cast<uint16_t>((*listener)->port()));
  const int made = socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0);
  std::promise<std::string> peer;
  (*listener)->Start(
      [&peer](int, int connection) {
        peer.set_value(PeerOf(connection));
        close(connection);
      },
      [](int64_t) {});
  ASSERT_EQ(connect(made, reinterpret_cast<sockaddr*>(&to), sizeof(to)), 0) << std::strerror(errno);
  EXPECT_NE(peer.get_future().get().find(absl::StrCat("%", to.sin6_scope_id, "]:")), std::string::npos);
  close(made);
}

TEST(Listener, TakesConnectionsUnderEveryNameOfThisMachine) {
  for (const std::string host : {"127.0.0.1", "0.0.0.0", "localhost", "ipv4:127.0.0.1", "dns:///127.0.0.1", "[::]"}) {
    const auto listener = Listener::Open(host + ":0");
    ASSERT_TRUE(listener.ok()) << listener.status();
    ASSERT_GT((*listener)->port(), 0) << host;
    std::promise<void> taken;
    (*listener)->Start(
        [&taken](int, int connection) {
          close(connection);
          taken.set_value();
        },
        [](int64_t) { ADD_FAILURE(); });
    const int connection = ConnectTo((*listener)->port());
    ASSERT_GE(connection, 0) << host;
    taken.get_future().wait();
    close(connection);
    (*listener)->Stop();
    EXPECT_LT(ConnectTo((*listener)->port()), 0) << host;
  }
}

TEST(Listener, APortThatIsTakenIsRefused) {
  const auto first = Listener::Open("127.0.0.1:0");
  ASSERT_TRUE(first.ok());
  const auto second = Listener::Open(absl::StrCat("127.0.0.1:", (*first)->port()));
  EXPECT_EQ(base::ErrorReason(second.status()), "LISTEN_FAILED");
  EXPECT_NE(second.status().message().find("Address already in use"), std::string::npos) << second.status();
  EXPECT_FALSE(Listener::Open(absl::StrCat("0.0.0.0:", (*first)->port())).ok());
}

TEST(Listener, WhatIsNoAddressIsRefused) {
  for (const std::string address : {"", "7410", "127.0.0.1", ":7410", "::1:7410", "127.0.0.1:http2",
                                    "unix:", "192.0.2.1:7410", "127.0.0.1:70000"}) {
    const auto listener = Listener::Open(address);
    EXPECT_EQ(base::ErrorReason(listener.status()), "LISTEN_FAILED") << address;
    EXPECT_NE(listener.status().message().find("cannot listen on " + address), std::string::npos) << listener.status();
  }
}

TEST(Listener, ASocketInTheFileSystemIsTakenOverAndGoesWithTheListener) {
  const std::string path = absl::StrCat(::testing::TempDir(), "/listener.", getpid());
  for (int i = 0; i < 2; ++i) {
    auto listener = Listener::Open("unix:" + path);
    ASSERT_TRUE(listener.ok()) << listener.status();
    EXPECT_EQ((*listener)->port(), 0);
    EXPECT_EQ(access(path.c_str(), F_OK), 0);
    (*listener)->Stop();
    EXPECT_NE(access(path.c_str(), F_OK), 0);
    // As kill -9 leaves it.
    sockaddr_un place = {};
    place.sun_family = AF_UNIX;
    std::strncpy(place.sun_path, path.c_str(), sizeof(place.sun_path) - 1);
    const int left = socket(AF_UNIX, SOCK_STREAM, 0);
    EXPECT_EQ(bind(left, reinterpret_cast<sockaddr*>(&place), sizeof(place)), 0);
    close(left);
  }
  unlink(path.c_str());
}

TEST(Listener, ASocketThatAnotherServerHasMadeThereStays) {
  const std::string path = absl::StrCat(::testing::TempDir(), "/replaced.", getpid());
  auto first = Listener::Open("unix:" + path);
  ASSERT_TRUE(first.ok()) << first.status();
  unlink(path.c_str());
  auto second = Listener::Open("unix:" + path);
  ASSERT_TRUE(second.ok()) << second.status();
  (*first)->Stop();
  EXPECT_EQ(access(path.c_str(), F_OK), 0);
  (*second)->Stop();
  EXPECT_NE(access(path.c_str(), F_OK), 0);
}

// Its clients would reach another database without a word.
TEST(Listener, ASocketAtWhichAServerListensIsNotTaken) {
  const std::string path = absl::StrCat(::testing::TempDir(), "/listening.", getpid());
  const auto first = Listener::Open("unix:" + path);
  ASSERT_TRUE(first.ok()) << first.status();
  const auto second = Listener::Open("unix:" + path);
  EXPECT_EQ(base::ErrorReason(second.status()), "LISTEN_FAILED");
  EXPECT_NE(second.status().message().find("another server listens there"), std::string::npos) << second.status();
  EXPECT_EQ(access(path.c_str(), F_OK), 0);
}

}  // namespace
}  // namespace axiscal::server
