#include "server/http/sign_in.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "core/base/testing/fake_clock.h"

namespace axiscal::http {
namespace {

Request From(const std::map<std::string, std::string>& fields, bool is_tls = false) {
  Request request;
  request.method = "POST";
  request.fields = fields;
  request.peer.is_tls = is_tls;
  return request;
}

bool IsLetIn(const Request& request, bool asks = true) { return CheckOrigin(request, asks, "").ok(); }

TEST(CheckOrigin, LetsProgramsAndOwnPagesIn) {
  EXPECT_TRUE(IsLetIn(From({{"host", "axiscal.shop"}})));
  EXPECT_TRUE(IsLetIn(From({{"host", "axiscal.shop:7480"}, {"origin", "https://Axiscal.shop:7480"}}, true)));
  EXPECT_TRUE(IsLetIn(From({{"host", "a"}, {"origin", "https://proxy.shop"}, {"sec-fetch-site", "same-origin"}})));
  EXPECT_TRUE(IsLetIn(From({{"host", "a"}, {"sec-fetch-site", "none"}})));  // typed into the address bar
}

TEST(CheckOrigin, RefusesPagesOfOthers) {
  for (const char* origin : {"null", "https://evil.example", "http://axiscal.shop", "https://axiscal.shop:1", ""}) {
    const absl::Status status = CheckOrigin(From({{"host", "axiscal.shop"}, {"origin", origin}}, true), true, "");
    EXPECT_EQ(base::ErrorReason(status), "ORIGIN_REFUSED") << origin;
  }
  for (const char* site : {"cross-site", "same-site"})
    EXPECT_FALSE(IsLetIn(From({{"host", "axiscal.shop"}, {"sec-fetch-site", site}}))) << site;
}

TEST(CheckOrigin, WantsALoopbackNameWhereNobodyIsAsked) {
  for (const char* host : {"localhost", "LOCALHOST:7480", "127.0.0.1:7480", "127.1.2.3", "[::1]:7480", "[::1]"})
    EXPECT_TRUE(IsLetIn(From({{"host", host}}), false)) << host;
  // A page whose own name leads to a loopback address is of the same origin for its browser.
  for (const char* host : {"evil.example", "127.0.0.1.evil.example", "", "localhost.evil.example:7480"})
    EXPECT_FALSE(IsLetIn(From({{"host", host}}), false)) << host;
  EXPECT_TRUE(CheckOrigin(From({{"host", "cell7:7480"}}), false, "cell7").ok());
  Request by_socket = From({{"host", "anything"}});
  by_socket.peer.is_unix = true;
  EXPECT_TRUE(IsLetIn(by_socket, false));
}

TEST(SignIns, StandForATokenAndEnd) {
  base::FakeClock clock;
  SignIns sign_ins(clock);
  const std::string cookie = sign_ins.Add("Bearer axt_1"), other = sign_ins.Add("Bearer axt_2");
  EXPECT_GE(cookie.size(), 43u);
  EXPECT_NE(cookie, other);
  EXPECT_EQ(sign_ins.Find(cookie), "Bearer axt_1");
  EXPECT_EQ(sign_ins.Find("axt_1"), std::nullopt);
  sign_ins.Remove(cookie);
  EXPECT_EQ(sign_ins.Find(cookie), std::nullopt);
  clock.Advance(std::chrono::hours(12));
  EXPECT_EQ(sign_ins.Find(other), std::nullopt);
}

// Whoever signs in again and again signs out himself alone.
TEST(SignIns, OfOneTokenTakeNobodyElsesPlace) {
  base::FakeClock clock;
  SignIns sign_ins(clock);
  const std::string anns = sign_ins.Add("Bearer axt_ann");
  const std::string first = sign_ins.Add("Bearer axt_bob");
  std::string last;
  for (int i = 0; i < 10'000; ++i) last = sign_ins.Add("Bearer axt_bob");
  EXPECT_EQ(sign_ins.Find(anns), "Bearer axt_ann");
  EXPECT_EQ(sign_ins.Find(first), std::nullopt);
  EXPECT_EQ(sign_ins.Find(last), "Bearer axt_bob");
}

TEST(CookieOf, FindsOursAmongOthers) {
  EXPECT_EQ(CookieOf(From({{"cookie", "a=b; axiscal=xyz; c=d"}})), "xyz");
  EXPECT_EQ(CookieOf(From({{"cookie", "notaxiscal=xyz"}})), std::nullopt);
  // By TLS the one that browsers hold to this host.
  EXPECT_EQ(CookieOf(From({{"cookie", "axiscal=forged; __Host-axiscal=xyz"}}, true)), "xyz");
}

}  // namespace
}  // namespace axiscal::http
