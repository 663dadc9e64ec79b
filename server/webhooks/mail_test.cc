#include "server/webhooks/mail.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_split.h"

namespace axiscal::webhooks {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

records::EventChange Change(records::EventChangeKind what) {
  records::EventChange change;
  change.id = 12;
  change.what = what;
  change.at = base::FromUtcUs(1'795'545'000'000'000);
  change.event.id = EventId(7);
  change.event.machine = MachineId("mt");
  change.event.content.kind = records::EventKind::kOutOfTolerance;
  change.event.content.subject = "EX0C";
  change.event.content.text = "EX0C is 31 +- 2 um";
  change.event.content.advice = "repeat the measurement";
  change.event.content.certainty = 0.997;
  return change;
}

std::string TextIn(const std::string& message) {
  std::string text, part;
  const size_t body = message.find("\r\n\r\n") + 4;
  for (const auto& line : absl::StrSplit(message.substr(body), "\r\n")) {
    EXPECT_LE(line.size(), 76u);
    EXPECT_TRUE(absl::Base64Unescape(line, &part));
    text += part;
  }
  return text;
}

TEST(Mail, AddressesAreOfOneForm) {
  EXPECT_THAT(*RecipientsOf("mailto:ann@plant.example,bob.b+x@10.example"),
              ElementsAre("ann@plant.example", "bob.b+x@10.example"));
  for (const std::string bad :
       {"mailto:", "mailto:ann", "mailto:@x", "mailto:ann@", "mailto:ann@x,", "mailto:a b@x", "mailto:ann@x\r\nRCPT",
        "mailto:ann@x>", "mailto:\"a\"@x", "mailto:ann@-x", "mailto:ann@x@y"})
    EXPECT_FALSE(RecipientsOf(bad).ok()) << bad;
  EXPECT_FALSE(RecipientsOf("mailto:a@x,a@x,a@x,a@x,a@x,a@x,a@x,a@x,a@x,a@x,a@x").ok());
  EXPECT_TRUE(IsMail("mailto:a@x"));
  EXPECT_FALSE(IsMail("https://mailto:a@x"));
}

TEST(Mail, SaysWhatIsTheCaseAndWhatToDo) {
  const records::EventChange raised = Change(records::EventChangeKind::kRaised);
  EXPECT_EQ(SubjectOf(raised), "[axiscal] mt: out-of-tolerance EX0C, raised");
  const std::string text = TextOf(raised);
  for (const char* const part : {"EX0C is 31 +- 2 um", "What to do: repeat the measurement", "99.7 %", "events ack 7"})
    EXPECT_THAT(text, HasSubstr(part));
  EXPECT_THAT(TextOf(Change(records::EventChangeKind::kCleared)), Not(HasSubstr("What to do")));
}

// A name in a text cannot become a header or end the mail.
TEST(Mail, HeadersAndTextAreEncoded) {
  const std::string text = "first\r\n.\r\nQUIT\r\n" + std::string(200, 'x') + "\xC3\xA4\n";
  const std::string subject = "\xC3\xA4\r\nBcc: eve@x " + std::string(90, 'y');
  const std::string message = MessageOf(
      {"axiscal@x", "webhook-1-change-5", subject, {"ann@x", "bob@x"}, base::FromUtcUs(1'795'545'025'000'000)}, text);
  EXPECT_THAT(message, HasSubstr("Date: Tue, 24 Nov 2026 18:30:25 +0000\r\n"));
  EXPECT_THAT(message, HasSubstr("To: ann@x,\r\n bob@x\r\n"));
  EXPECT_THAT(message, HasSubstr("Message-ID: <webhook-1-change-5@"));
  EXPECT_THAT(message, Not(HasSubstr("Bcc")));
  EXPECT_THAT(message, Not(HasSubstr("QUIT")));
  EXPECT_EQ(TextIn(message), text);
  for (const char c : message) EXPECT_LT(static_cast<unsigned char>(c), 0x80);
  std::string said, part;
  const size_t begin = message.find("Subject: ") + 9, end = message.find("\r\nMessage-ID");
  for (const auto& word : absl::StrSplit(message.substr(begin, end - begin), "\r\n ")) {
    ASSERT_TRUE(absl::StartsWith(word, "=?UTF-8?B?"));
    EXPECT_LE(word.size(), 75u);
    ASSERT_TRUE(absl::Base64Unescape(word.substr(10, word.size() - 12), &part));
    said += part;
  }
  EXPECT_EQ(said, subject);
}

TEST(Mail, ServersThatCannotBeAreRefused) {
  const MailServer good = {"smtp://mail.plant:587", "axiscal@plant.example", "axiscal", "password", "", true};
  EXPECT_TRUE(Check(good).ok());
  const auto with = [&](auto change) {
    MailServer server = good;
    change(server);
    return Check(server);
  };
  EXPECT_FALSE(with([](MailServer& s) { s.url = "http://mail"; }).ok());
  EXPECT_FALSE(with([](MailServer& s) { s.url = "smtp://ann:secret@mail"; }).ok());
  EXPECT_FALSE(with([](MailServer& s) { s.from = "axiscal"; }).ok());
  EXPECT_FALSE(with([](MailServer& s) { s.password_file = ""; }).ok());
  EXPECT_FALSE(with([](MailServer& s) { s.needs_tls = false; }).ok());
  EXPECT_TRUE(with([](MailServer& s) { s.needs_tls = false, s.user = s.password_file = ""; }).ok());
}

}  // namespace
}  // namespace axiscal::webhooks
