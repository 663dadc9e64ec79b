#include "server/webhooks/addresses.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <ifaddrs.h>

#include <cstring>

#include "core/base/demand.h"

namespace axiscal::webhooks {
namespace {

using ::testing::HasSubstr;

std::string WhyNotCall(const AddressRule& rule, const std::string& ip, int port = 80) {
  sockaddr_storage storage = {};
  auto* const v4 = reinterpret_cast<sockaddr_in*>(&storage);
  auto* const v6 = reinterpret_cast<sockaddr_in6*>(&storage);
  if (inet_pton(AF_INET, ip.c_str(), &v4->sin_addr) == 1) {
    v4->sin_family = AF_INET;
    v4->sin_port = htons(static_cast<uint16_t>(port));
  } else {
    DEMAND(inet_pton(AF_INET6, ip.c_str(), &v6->sin6_addr) == 1);
    v6->sin6_family = AF_INET6;
    v6->sin6_port = htons(static_cast<uint16_t>(port));
  }
  return rule.WhyNot(reinterpret_cast<const sockaddr*>(&storage));
}

TEST(AddressRule, RefusesThisMachineItsCableAndCloudMetadata) {
  const AddressRule rule;
  for (const char* const ip : {"127.0.0.1",
                               "127.9.9.9",
                               "0.0.0.0",
                               "169.254.1.1",
                               "169.254.169.254",
                               "224.0.0.1",
                               "255.255.255.255",
                               "100.100.100.200",
                               "168.63.129.16",
                               "::1",
                               "::",
                               "fe80::1",
                               "ff02::1",
                               "fd00:ec2::254",
                               "fd00:ec2::23",
                               "fec0::1",
                               "64:ff9b:1::7f00:1",
                               "::ffff:0:127.0.0.1",
                               "::ffff:127.0.0.1",
                               "::ffff:169.254.169.254",
                               "64:ff9b::7f00:1",
                               "2002:7f00:1::",
                               "::7f00:1"}) {
    EXPECT_NE(WhyNotCall(rule, ip), "") << ip;
  }
  EXPECT_EQ(WhyNotCall(rule, "::ffff:127.0.0.1"),
            "127.0.0.1 is a loopback address, which webhooks.allowed does not name");
  // Those of the plant's network may be called: there the receivers are.
  for (const char* const ip : {"10.0.0.7", "172.16.3.4", "192.168.1.20", "fd12:3456::1", "2001:db8::7", "192.0.2.7",
                               "128.0.0.1", "168.63.129.17", "64:ff9b::c000:207"}) {
    EXPECT_EQ(WhyNotCall(rule, ip), "") << ip;
  }
}

// A connection to an address of one's own does not leave the machine: what trusts "this machine" would be reached by
// it.
TEST(AddressRule, RefusesWhateverAddressThisMachineHas) {
  ifaddrs* found = nullptr;
  ASSERT_EQ(getifaddrs(&found), 0);
  int count = 0;
  for (const ifaddrs* one = found; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || (one->ifa_addr->sa_family != AF_INET && one->ifa_addr->sa_family != AF_INET6))
      continue;
    EXPECT_NE(AddressRule().WhyNot(one->ifa_addr), "") << one->ifa_name;
    ++count;
  }
  freeifaddrs(found);
  EXPECT_GT(count, 0);
}

TEST(AddressRule, AllowsWhatIsListed) {
  const auto rule = AddressRule::Allowing(" 127.0.0.1:8080, 169.254.3.4,[::1]:81, fe80::7 ");
  ASSERT_TRUE(rule.ok()) << rule.status();
  EXPECT_EQ(WhyNotCall(*rule, "127.0.0.1", 8080), "");
  EXPECT_EQ(WhyNotCall(*rule, "::ffff:127.0.0.1", 8080), "");
  EXPECT_THAT(WhyNotCall(*rule, "127.0.0.1", 8081), HasSubstr("loopback"));
  EXPECT_EQ(WhyNotCall(*rule, "169.254.3.4", 1), "");
  EXPECT_THAT(WhyNotCall(*rule, "169.254.3.5", 1), HasSubstr("link-local"));
  EXPECT_EQ(WhyNotCall(*rule, "::1", 81), "");
  EXPECT_THAT(WhyNotCall(*rule, "::1", 82), HasSubstr("loopback"));
  EXPECT_EQ(WhyNotCall(*rule, "fe80::7", 5), "");
  EXPECT_TRUE(AddressRule::Allowing("").ok());
  for (const char* const list : {"localhost", "127.0.0.1:", "127.0.0.1:0", "127.0.0.1:70000", "[::1]:x",
                                 "127.0.0.1,,::1", "127.0.0.0/8", "[", "[12]", "[10.0.0.7"}) {
    EXPECT_THAT(std::string(AddressRule::Allowing(list).status().message()), HasSubstr("is no address")) << list;
  }
}

}  // namespace
}  // namespace axiscal::webhooks
