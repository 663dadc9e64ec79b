// Letters to a receiver on this machine that answers as the test wants: takes, fails, leads elsewhere, hangs, is gone.
#include "server/webhooks/sender.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/storage/testing/temp_database.h"
#include "server/webhooks/testing/mail_receiver.h"
#include "server/webhooks/testing/receiver.h"

namespace axiscal::webhooks {
namespace {

using storage::Cell;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class WebhookSender : public testing::Test {
 protected:
  WebhookSender() {
    for (const char* const machine : {"mt", "other"})
      DEMAND(database->CreateMachine(MachineId(machine), "{}", Cell("")).ok());
    options.post.addresses = *AddressRule::Allowing(absl::StrCat("127.0.0.1:", receiver.port()));
    options.post.clock = &database.clock;
    options.random = [] { return 1.0; };
    options.tell = [this](const records::WebhookRecord& webhook, const std::string& error, bool is_dead) {
      told.push_back(webhook.content.name + (is_dead ? " dead: " : ": ") + error);
    };
    Start();
  }
  void Start() { sender = std::make_unique<Sender>(*database, board, options); }
  records::WebhookRecord Put(const std::string& url, const std::string& name = "mes", records::Scope scope = {}) {
    records::Webhook webhook;
    webhook.name = name;
    webhook.url = url;
    webhook.scope = scope;
    const auto put = database->PutWebhook(webhook, {NewSecret(), false}, 0, Cell(""));
    DEMAND(put.ok());
    return *put;
  }
  void Happen(const std::string& subject, const std::string& machine = "mt") {
    records::EventContent content;
    content.kind = records::EventKind::kWear;
    content.subject = subject;
    DEMAND(database->ChangeEvents({.machine = MachineId(machine), .raised = {content}}).ok());
    board->Tell();
  }
  records::WebhookRecord Get(const std::string& name = "mes") { return *database->GetWebhook(name); }
  // As time goes on until it is tried again.
  void TryAgain() {
    DEMAND(Get().next_try_at.has_value());
    database.clock.SetUtc(*Get().next_try_at);
    sender->SendDue();
  }

  Receiver receiver;
  storage::TempDatabase database;
  const std::shared_ptr<watch::EventBoard> board = std::make_shared<watch::EventBoard>();
  std::vector<std::string> told;
  SenderOptions options;
  std::unique_ptr<Sender> sender;
};

TEST_F(WebhookSender, SendsWhatTheStreamSendsOnceSignedAndInOrder) {
  Happen("before");
  const records::WebhookRecord webhook = Put(receiver.Url("/hook?line=3"));
  Happen("EX0C");
  Happen("EY0C", "other");
  sender->SendDue();
  sender->SendDue();
  EXPECT_THAT(receiver.Ids(), ElementsAre("webhook-1-change-2", "webhook-1-change-3"));
  const Received first = receiver.received().at(0);
  EXPECT_EQ(first.path, "POST /hook?line=3 HTTP/1.1");
  EXPECT_EQ(first.headers.at("content-type"), "application/json");
  const int64_t now_s = base::ToUtcUs(database.clock.UtcNow()) / 1'000'000;
  EXPECT_EQ(first.headers.at("webhook-timestamp"), absl::StrCat(now_s));
  EXPECT_EQ(first.headers.at("webhook-signature"), Signature(webhook.secret, "webhook-1-change-2", now_s, first.body));
  EXPECT_THAT(first.body, StartsWith("{\"type\":\"event.raised\",\"change\":{\"changeId\":\"2\""));
  EXPECT_THAT(first.body, HasSubstr("\"subject\":\"EX0C\""));
  EXPECT_EQ(Get().after_change, 3);
  EXPECT_EQ(Get().dead_letters, 0);
  EXPECT_THAT(told, ElementsAre());
}

TEST_F(WebhookSender, TellsOfTheMachinesOfItsScopeAlone) {
  Put(receiver.Url(), "mes", {records::Scope::Kind::kMachine, "other"});
  Happen("EX0C");
  Happen("EY0C", "other");
  Happen("EZ0C");
  sender->SendDue();
  EXPECT_THAT(receiver.Ids(), ElementsAre("webhook-1-change-2"));
  EXPECT_EQ(Get().after_change, 3);
}

TEST_F(WebhookSender, TriesAgainLaterAndLaterAndThenKeepsADeadLetter) {
  receiver.Say(Answer(503));
  Put(receiver.Url());
  Happen("EX0C");
  Happen("EY0C");
  sender->SendDue();
  sender->SendDue();  // it is not yet time
  EXPECT_EQ(receiver.received().size(), 1u);
  EXPECT_EQ(Get().next_try_at, database.clock.UtcNow() + std::chrono::seconds(5));
  TryAgain();
  EXPECT_EQ(Get().next_try_at, database.clock.UtcNow() + std::chrono::seconds(10));
  EXPECT_THAT(receiver.Ids(), ElementsAre("webhook-1-change-1", "webhook-1-change-1"));
  while (Get().dead_letters == 0) TryAgain();
  EXPECT_EQ(receiver.Ids().at(kTries - 1), "webhook-1-change-1");
  EXPECT_EQ(receiver.Ids().at(kTries), "webhook-1-change-2");
  EXPECT_EQ(Get().after_change, 1);
  EXPECT_EQ(told.at(kTries - 1), "mes dead: HTTP 503");
  receiver.Say(Answer(200));
  TryAgain();
  EXPECT_EQ(Get().after_change, 2);
  EXPECT_EQ(Get().last_error, "");
  // On wish once more, and then it is none any more.
  EXPECT_EQ(database->ListDeadLetters("mes", {})->rows.at(0).tries, kTries);
  ASSERT_EQ(*database->ResendDeadLetters("mes", {}, Cell("")), 1);
  sender->SendDue();
  EXPECT_EQ(receiver.Ids().back(), "webhook-1-change-1");
  EXPECT_TRUE(database->ListDeadLetters("mes", {})->rows.empty());
  EXPECT_EQ(Get().dead_letters, 0);
}

TEST_F(WebhookSender, GivesUpSoonerWhatIsRefusedOrLedElsewhere) {
  receiver.Say("HTTP/1.1 404 X\r\nContent-Length: 15\r\n\r\nno such hook\r\n!");
  Put(receiver.Url());
  Happen("EX0C");
  sender->SendDue();
  for (int i = 1; i < kTriesOfRefused; ++i) TryAgain();
  EXPECT_EQ(Get().dead_letters, 1);
  EXPECT_EQ(Get().last_error, "HTTP 404: no such hook  !");
  receiver.Say(Answer(302, absl::StrCat("Location: ", receiver.Url("/elsewhere"), "\r\n")));
  Happen("EY0C");
  sender->SendDue();
  EXPECT_EQ(Get().last_error, "HTTP 302: redirects are not followed");
  for (const Received& one : receiver.received()) EXPECT_THAT(one.path, HasSubstr("/hook"));
  EXPECT_EQ(receiver.received().size(), static_cast<size_t>(kTriesOfRefused) + 1);
}

TEST_F(WebhookSender, CallsNothingThatTrustsThisMachine) {
  options.post.addresses = AddressRule();
  Start();
  Put(receiver.Url());
  Put(absl::StrCat("http://localhost:", receiver.port(), "/"), "name");
  Happen("EX0C");
  sender->SendDue();
  EXPECT_EQ(Get().last_error, "127.0.0.1 is a loopback address, which webhooks.allowed does not name");
  EXPECT_THAT(Get("name").last_error, HasSubstr("is a loopback address"));
  EXPECT_TRUE(receiver.received().empty());
}

TEST_F(WebhookSender, EndsWhatHangsBreaksOffOrNeverEnds) {
  options.post.timeout = std::chrono::milliseconds(200);
  Start();
  receiver.Say("hang");
  Put(receiver.Url());
  Happen("EX0C");
  sender->SendDue();
  EXPECT_THAT(Get().last_error, HasSubstr("timed out"));
  receiver.Say("");  // closes without a word
  TryAgain();
  EXPECT_EQ(Get().tries, 2);
  EXPECT_THAT(Get().last_error, HasSubstr("mpty reply"));
  receiver.Say("HTTP/1.1 200 X\r\nContent-Length: 10\r\n\r\nbroken");
  TryAgain();
  EXPECT_EQ(Get().tries, 3);  // of an answer that was cut off nobody knows what it meant
  receiver.Say("HTTP/1.1 200 X\r\nConnection: close\r\n\r\n" + std::string(1 << 20, 'x'));
  TryAgain();
  EXPECT_EQ(Get().after_change, 1);
}

// One that hangs holds up no other, and no stop.
TEST_F(WebhookSender, WaitsForNobody) {
  Receiver hanging;
  hanging.Say("hang");
  options.post.timeout = std::chrono::hours(1);
  options.post.addresses =
      *AddressRule::Allowing(absl::StrCat("127.0.0.1:", receiver.port(), ",127.0.0.1:", hanging.port()));
  Start();
  sender->Start();
  Put(hanging.Url(), "hanging");
  Put(receiver.Url());
  sender->LookSoon();
  Happen("EX0C");
  hanging.WaitFor(1);
  receiver.WaitFor(1);
  for (int i = 0; i < 20; ++i) Happen(absl::StrCat("s", i));
  receiver.WaitFor(21);
  sender->Stop();
  EXPECT_EQ(hanging.received().size(), 1u);
  EXPECT_EQ(Get("hanging").tries, 0);  // what was given up is no try
}

// Whatever was under way, nothing is lost; what was stored as taken does not come again.
TEST_F(WebhookSender, LosesNothingOverRestarts) {
  Put(receiver.Url());
  for (int i = 0; i < 5; ++i) Happen(absl::StrCat("a", i));
  sender->SendDue();
  receiver.Say(Answer(500));
  for (int i = 0; i < 5; ++i) Happen(absl::StrCat("b", i));
  sender->SendDue();
  sender.reset();
  database.Close();
  database.Open();
  receiver.Say(Answer(200));
  Start();
  sender->SendDue();
  EXPECT_EQ(receiver.received().size(), 6u);  // the wait is kept, too
  TryAgain();
  std::vector<std::string> taken = receiver.Ids();
  ASSERT_EQ(taken.size(), 11u);
  EXPECT_EQ(taken[5], taken[6]);
  taken.erase(taken.begin() + 5);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(taken[i], absl::StrCat("webhook-1-change-", i + 1));
}

TEST_F(WebhookSender, SendsWhatHappenedWhileItWasDisabled) {
  records::Webhook webhook = Put(receiver.Url()).content;
  webhook.is_enabled = false;
  ASSERT_TRUE(database->PutWebhook(webhook, {}, 0, Cell("")).ok());
  Happen("EX0C");
  sender->SendDue();
  EXPECT_TRUE(receiver.received().empty());
  webhook.is_enabled = true;
  ASSERT_TRUE(database->PutWebhook(webhook, {}, 0, Cell("")).ok());
  sender->SendDue();
  EXPECT_EQ(receiver.received().size(), 1u);
}

TEST_F(WebhookSender, SendsTestsAtOnce) {
  const records::WebhookRecord webhook = Put(receiver.Url());
  const auto taken = sender->Try(webhook, [] { return false; });
  ASSERT_TRUE(taken.ok()) << taken.status();
  EXPECT_EQ(taken->status, 204);
  EXPECT_EQ(taken->error, "");
  EXPECT_EQ(receiver.received().at(0).body, "{\"type\":\"test\"}");
  receiver.Say(Answer(401));
  EXPECT_EQ(sender->Try(webhook, [] { return false; })->error, "HTTP 401");
  EXPECT_TRUE(absl::IsCancelled(sender->Try(webhook, [] { return true; }).status()));
}

TEST(WebhookWaits, DoubleUpToAnHour) {
  EXPECT_EQ(WaitAfter(1, 0.0), std::chrono::milliseconds(2500));
  EXPECT_EQ(WaitAfter(1, 1.0), std::chrono::seconds(5));
  EXPECT_EQ(WaitAfter(4, 1.0), std::chrono::seconds(40));
  EXPECT_EQ(WaitAfter(11, 1.0), std::chrono::hours(1));
  EXPECT_EQ(WaitAfter(50, 0.0), std::chrono::minutes(30));
}

class MailSender : public WebhookSender {
 protected:
  MailSender() { Restart(false); }
  void Restart(bool needs_tls) {
    options.post.mail = MailServer{mail.Url(), "axiscal@plant.example", "", "", "", needs_tls};
    Start();
  }
  void Say(EventId event) {
    DEMAND(database->AcknowledgeEvent(event, "seen", Cell("")).ok());
    board->Tell();
  }

  MailReceiver mail;
};

TEST_F(MailSender, SendsWhatIsRaisedAndNotWhatPeopleSaid) {
  Put("mailto:ann@plant.example,bob@plant.example");
  Happen("EX0C");
  sender->SendDue();
  Say(EventId(1));
  sender->SendDue();
  ASSERT_EQ(mail.mails().size(), 1u);
  const ReceivedMail got = mail.mails()[0];
  EXPECT_EQ(got.from, "<axiscal@plant.example>");
  EXPECT_THAT(got.to, ElementsAre("<ann@plant.example>", "<bob@plant.example>"));
  EXPECT_THAT(got.message, HasSubstr("From: axiscal@plant.example\r\n"));
  // What is not told by mail does not wait.
  EXPECT_EQ(Get().after_change, 2);
  EXPECT_EQ(Get().last_error, "");
  Happen("EY0C");
  sender->SendDue();
  EXPECT_EQ(mail.mails().size(), 2u);
  // A test says by which protocol it was taken.
  const auto trial = sender->Try(Get(), [] { return false; });
  ASSERT_TRUE(trial.ok()) << trial.status();
  EXPECT_EQ(trial->error, "");
  EXPECT_TRUE(trial->is_mail);
  EXPECT_EQ(trial->status, 250);
  EXPECT_EQ(mail.mails().size(), 3u);
}

TEST_F(MailSender, ABusyServerIsTriedAgainARefusalFourTimes) {
  Put("mailto:ann@plant.example");
  mail.Say("RCPT", "451 try again later");
  Happen("EX0C");
  sender->SendDue();
  EXPECT_THAT(Get().last_error, HasSubstr("451"));
  for (int i = 0; i < 5; ++i) TryAgain();
  mail.Say("", "");
  TryAgain();
  EXPECT_EQ(mail.mails().size(), 1u);
  mail.Say("RCPT", "550 nobody of that name");
  Happen("EY0C");
  sender->SendDue();
  for (int i = 1; i < kTriesOfRefused; ++i) TryAgain();
  EXPECT_EQ(Get().dead_letters, 1);
}

// Without TLS where TLS is asked for nothing is said but the greeting.
TEST_F(MailSender, NothingGoesInTheClearUnlessThatIsSaid) {
  Restart(true);
  Put("mailto:ann@plant.example");
  Happen("EX0C");
  sender->SendDue();
  EXPECT_TRUE(mail.mails().empty());
  EXPECT_EQ(mail.said().find("MAIL FROM"), std::string::npos) << mail.said();
  EXPECT_NE(Get().last_error, "");
}

TEST_F(MailSender, WithoutAServerALetterFailsAndSaysWhy) {
  options.post.mail.reset();
  Start();
  Put("mailto:ann@plant.example");
  Happen("EX0C");
  sender->SendDue();
  EXPECT_THAT(Get().last_error, HasSubstr("mail.server"));
  EXPECT_FALSE(sender->has_mail());
}

}  // namespace
}  // namespace axiscal::webhooks
