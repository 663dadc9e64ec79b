#include "server/local_login.h"

#include <gtest/gtest.h>

namespace axiscal::server {
namespace {

TEST(PeerUsers, AreAskedForOnceAConnection) {
  int asked = 0;
  std::optional<uid_t> holder = 1000;
  PeerUsers users([&](const std::string&) {
    ++asked;
    return holder;
  });
  EXPECT_EQ(users.UserOf("ipv4:127.0.0.1:40000"), std::nullopt);  // no connection of ours
  users.Connected("ipv4:127.0.0.1:40000");
  for (int call = 0; call < 3; ++call) EXPECT_EQ(users.UserOf("ipv4:127.0.0.1:40000"), 1000u);
  EXPECT_EQ(asked, 1);
  // The same port, in another's hand.
  holder = 1001;
  users.Connected("ipv4:127.0.0.1:40000");
  EXPECT_EQ(users.UserOf("ipv4:127.0.0.1:40000"), 1001u);
  users.Connected("ipv6:%5B::1%5D:40001");
  EXPECT_EQ(users.UserOf("ipv6:%5B::1%5D:40001"), 1001u);
  EXPECT_EQ(asked, 3);
}

TEST(PeerUsers, WhatTheSystemDoesNotTellIsAskedAgain) {
  std::optional<uid_t> holder;
  PeerUsers users([&](const std::string&) { return holder; });
  users.Connected("ipv4:127.0.0.1:40000");
  EXPECT_EQ(users.UserOf("ipv4:127.0.0.1:40000"), std::nullopt);
  holder = 1000;
  EXPECT_EQ(users.UserOf("ipv4:127.0.0.1:40000"), 1000u);
}

// An answer that was under way when the port changed hands is kept for nobody.
TEST(PeerUsers, AnAnswerOfBeforeIsNotTheNextOnes) {
  PeerUsers* all = nullptr;
  int asked = 0;
  PeerUsers users([&](const std::string& peer) -> std::optional<uid_t> {
    if (++asked > 1) return 1001;
    all->Connected(peer);
    return 1000;
  });
  all = &users;
  users.Connected("ipv4:127.0.0.1:40000");
  EXPECT_EQ(users.UserOf("ipv4:127.0.0.1:40000"), 1000u);
  EXPECT_EQ(users.UserOf("ipv4:127.0.0.1:40000"), 1001u);
}

}  // namespace
}  // namespace axiscal::server
