#include "server/webhooks/letter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error_detail.h"

namespace axiscal::webhooks {
namespace {

using ::testing::HasSubstr;

// The example of the specification.
TEST(WebhookLetter, IsSignedAsStandardWebhooksSay) {
  EXPECT_EQ(Signature("whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw", "msg_p5jXN8AQM9LWM0D4loKWxJek", 1614265330,
                      "{\"test\": 2432232314}"),
            "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=");
  EXPECT_NE(Signature("whsec_%", "a", 1, "b"), "");  // damaged: it is sent, and the receiver refuses it
  EXPECT_NE(NewSecret(), NewSecret());
  EXPECT_NE(Signature(NewSecret(), "a", 1, "b"), Signature(NewSecret(), "a", 1, "b"));
}

TEST(WebhookLetter, SaysWhatTheStreamSays) {
  records::WebhookRecord webhook;
  webhook.id = WebhookId(3);
  records::EventChange change;
  change.id = 41;
  change.what = records::EventChangeKind::kAcknowledged;
  change.by = "ann";
  change.event.id = EventId(7);
  change.event.machine = MachineId("mt");
  change.event.content.amounts = {{"EX0C", records::EstimateUnit::kUm, 21.5, 0.5}};
  const Letter letter = LetterOf(webhook, change);
  EXPECT_EQ(letter.id, "webhook-3-change-41");
  EXPECT_THAT(letter.body, HasSubstr("{\"type\":\"event.acknowledged\",\"change\":{\"changeId\":\"41\""));
  EXPECT_THAT(letter.body, HasSubstr("\"eventId\":\"7\",\"machineId\":\"mt\""));
  EXPECT_THAT(letter.body, HasSubstr("\"size\":21.5"));
}

TEST(WebhookUrl, IsHttpWithoutSecrets) {
  for (const char* const url : {"http://mes.shop/hook?line=3", "https://192.0.2.7:8443/", "http://[2001:db8::1]:80/x"})
    EXPECT_TRUE(CheckUrl(url, nullptr).ok()) << url << " " << CheckUrl(url, nullptr);
  for (const char* const url :
       {"", "mes", "ftp://mes/", "file:///etc/passwd", "http://ann:secret@mes/", "http://ann@mes/", "http://mes/#part",
        "http://", "http://mes\n/", "gopher://mes:25/"}) {
    EXPECT_EQ(base::ErrorReason(CheckUrl(url, nullptr)), "FIELD_INVALID") << url;
  }
  // An address is judged where it is put, with the port that the URL or its scheme means.
  const auto allowed = AddressRule::Allowing("127.0.0.1:8080,127.0.0.1:443");
  ASSERT_TRUE(allowed.ok());
  EXPECT_TRUE(CheckUrl("http://127.0.0.1:8080/events", &*allowed).ok());
  EXPECT_TRUE(CheckUrl("https://127.0.0.1/events", &*allowed).ok());
  for (const char* const url : {"http://127.0.0.1/", "https://127.0.0.1:8081/", "http://127.1/", "http://0x7f.1:8081/",
                                "http://[::1]/", "http://[::ffff:127.0.0.1]:8081/", "http://169.254.169.254/latest"})
    EXPECT_EQ(base::ErrorReason(CheckUrl(url, &*allowed)), "FIELD_INVALID") << url;
  EXPECT_THAT(std::string(CheckUrl("http://127.0.0.1/", &*allowed).message()),
              HasSubstr("127.0.0.1 is a loopback address, which webhooks.allowed does not name"));
}

}  // namespace
}  // namespace axiscal::webhooks
