#include "server/access/known_peers.h"

#include <gtest/gtest.h>

namespace axiscal::access {
namespace {

TEST(KnownPeers, ThoseThatAreConnectedStayKnown) {
  KnownPeers known;
  for (const std::string peer : {"ipv4:192.0.2.7:1", "ipv4:192.0.2.7:2", "ipv6:%5B::1%5D:3"}) known.Add(peer);
  const auto connected = [&] {
    known.Add("ipv4:192.0.2.8:4");  // has come since it was asked
    return std::vector<std::string>{"ipv4:192.0.2.7:2", "ipv6:[::1]:3", "ipv4:192.0.2.9:5"};
  };
  known.ForgetGone(3, connected);
  EXPECT_TRUE(known.Has("ipv4:192.0.2.7:1"));
  EXPECT_FALSE(known.Has("ipv4:192.0.2.8:4"));  // nobody was asked
  known.ForgetGone(2, connected);
  EXPECT_FALSE(known.Has("ipv4:192.0.2.7:1"));
  EXPECT_TRUE(known.Has("ipv4:192.0.2.7:2"));
  EXPECT_TRUE(known.Has("ipv6:[::1]:3"));
  EXPECT_TRUE(known.Has("ipv4:192.0.2.8:4"));
  EXPECT_FALSE(known.Has("ipv4:192.0.2.9:5"));
}

TEST(KnownPeers, ArePlain) {
  EXPECT_EQ(PlainPeer("ipv6:%5B::1%5D:40312"), "ipv6:[::1]:40312");
  EXPECT_EQ(PlainPeer("ipv6:%5Bfe80::1%252%5D:40312"), "ipv6:[fe80::1%2]:40312");
  EXPECT_EQ(PlainPeer("ipv6:[fe80::1%2]:40312"), "ipv6:[fe80::1%2]:40312");
}

}  // namespace
}  // namespace axiscal::access
