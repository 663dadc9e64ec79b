#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class Webhooks : public testing::Test {
 protected:
  Webhooks() { DEMAND(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok()); }
  static Webhook Mes() {
    Webhook webhook;
    webhook.name = "mes";
    webhook.url = "http://mes/hook";
    return webhook;
  }
  WebhookRecord Put(const Webhook& webhook, const NewSecret& secret = {"whsec_AAAA", false}) {
    const auto put = database->PutWebhook(webhook, secret, 0, Cell(""));
    DEMAND(put.ok());
    return *put;
  }
  // A change of an event, its number.
  int64_t Happen(const std::string& subject) {
    EventContent content;
    content.kind = EventKind::kWear;
    content.subject = subject;
    DEMAND(database->ChangeEvents({.machine = MachineId("mt"), .raised = {content}}).ok());
    return *database->LastEventChange();
  }
  WebhookStep StepOf(const WebhookRecord& webhook, int64_t to) {
    WebhookStep step;
    step.webhook = webhook.id;
    step.etag = webhook.etag;
    step.from = webhook.after_change;
    step.to = to;
    return step;
  }
  WebhookRecord Get() { return *database->GetWebhook("mes"); }

  TempDatabase database;
};

TEST_F(Webhooks, AreKeptWithTheirSecret) {
  Happen("EX0C");
  const WebhookRecord made = Put(Mes());
  EXPECT_EQ(made.after_change, 1);  // what happened before is not told
  EXPECT_EQ(made.secret, "whsec_AAAA");
  EXPECT_EQ(Put(Mes(), {"whsec_BBBB", false}).etag, 1);
  EXPECT_EQ(Get().secret, "whsec_AAAA");
  Webhook other = Mes();
  other.url = "https://other/";
  other.scope = {records::Scope::Kind::kMachine, "mt"};
  other.is_enabled = false;
  EXPECT_EQ(base::ErrorReason(database->PutWebhook(other, {}, 7, Cell("")).status()), "ETAG_MISMATCH");
  EXPECT_EQ(database->PutWebhook(other, {"whsec_CCCC", true}, 1, Cell(""))->etag, 2);
  database.Close();
  database.Open();
  const WebhookRecord read = Get();
  EXPECT_EQ(read.content.url, "https://other/");
  EXPECT_EQ(read.content.scope, other.scope);
  EXPECT_FALSE(read.content.is_enabled);
  EXPECT_EQ(read.secret, "whsec_CCCC");
  EXPECT_EQ(read.after_change, 1);
  std::string audit;
  const auto entries = database->ListAudit(PageRequest());
  for (const AuditEntry& entry : entries->rows) audit += entry.action + entry.was + entry.became + "\n";
  EXPECT_THAT(audit, HasSubstr("webhook.put"));
  EXPECT_THAT(audit, HasSubstr("https://other/ for machine mt; new secret"));
  EXPECT_THAT(audit, Not(HasSubstr("whsec")));
  ASSERT_TRUE(database->RemoveWebhook("mes", 0, Cell("")).ok());
  EXPECT_EQ(base::ErrorReason(database->GetWebhook("mes").status()), "WEBHOOK_NOT_FOUND");
  EXPECT_NE(Put(Mes()).id, made.id);
}

TEST_F(Webhooks, AreForMachinesThatAreThereAndAtMostSixteen) {
  Webhook nowhere = Mes();
  nowhere.scope = {records::Scope::Kind::kMachine, "none"};
  EXPECT_EQ(base::ErrorReason(database->PutWebhook(nowhere, {}, 0, Cell("")).status()), "MACHINE_NOT_FOUND");
  nowhere.scope = {records::Scope::Kind::kGroup, "none"};
  EXPECT_EQ(base::ErrorReason(database->PutWebhook(nowhere, {}, 0, Cell("")).status()), "GROUP_NOT_FOUND");
  for (int i = 0; i < 16; ++i) {
    Webhook webhook = Mes();
    webhook.name = absl::StrCat("w", i);
    Put(webhook);
  }
  EXPECT_EQ(base::ErrorReason(database->PutWebhook(Mes(), {}, 0, Cell("")).status()), "TOO_MANY_WEBHOOKS");
}

TEST_F(Webhooks, GoOnWhereTheyStood) {
  const WebhookRecord begun = Put(Mes());
  const int64_t first = Happen("EX0C"), second = Happen("EY0C");
  WebhookStep failed = StepOf(begun, begun.after_change);
  failed.tries = 1;
  failed.error = "HTTP 500";
  failed.next_try_at = database.clock.UtcNow() + std::chrono::seconds(5);
  EXPECT_TRUE(*database->StepWebhook(failed));
  EXPECT_EQ(Get().tries, 1);
  EXPECT_EQ(Get().next_try_at, failed.next_try_at);
  WebhookStep sent = StepOf(Get(), first);
  sent.is_sent = true;
  EXPECT_TRUE(*database->StepWebhook(sent));
  EXPECT_FALSE(*database->StepWebhook(sent));  // it is elsewhere already
  EXPECT_EQ(Get().after_change, first);
  EXPECT_EQ(Get().last_error, "");
  EXPECT_EQ(Get().last_sent_at, database.clock.UtcNow());
  EXPECT_FALSE(Get().next_try_at.has_value());
  const WebhookRecord before = Get();
  Webhook other = Mes();
  other.url = "http://other/";
  Put(other);
  EXPECT_FALSE(*database->StepWebhook(StepOf(before, second)));  // what was sent elsewhere counts no more
  EXPECT_EQ(Get().after_change, first);
}

TEST_F(Webhooks, KeepDeadLettersUntilTheyAreTaken) {
  Put(Mes());
  for (const char* const subject : {"EX0C", "EY0C", "EZ0C"}) {
    const int64_t change = Happen(subject);
    WebhookStep step = StepOf(Get(), change);
    step.error = "HTTP 404";
    step.dead = {change, 4, "HTTP 404"};
    ASSERT_TRUE(*database->StepWebhook(step));
  }
  EXPECT_EQ(Get().dead_letters, 3);
  EXPECT_EQ(Get().after_change, 3);
  const auto page = database->ListDeadLetters("mes", {2, ""});
  ASSERT_EQ(page->rows.size(), 2u);
  EXPECT_EQ(page->rows[0].change, 3);
  EXPECT_EQ(page->rows[0].machine, MachineId("mt"));
  EXPECT_EQ(page->rows[0].error, "HTTP 404");
  EXPECT_EQ(database->ListDeadLetters("mes", {2, page->next_token})->rows.at(0).change, 1);
  EXPECT_FALSE(database->WantedLetter(Get().id)->has_value());
  EXPECT_EQ(base::ErrorReason(database->ResendDeadLetters("mes", 9, Cell("")).status()), "DEAD_LETTER_NOT_FOUND");
  EXPECT_EQ(*database->ResendDeadLetters("mes", 2, Cell("")), 1);
  EXPECT_EQ((*database->WantedLetter(Get().id))->event.content.subject, "EY0C");
  EXPECT_TRUE(*database->EndWantedLetter(Get().id, 2, ""));
  EXPECT_FALSE(*database->EndWantedLetter(Get().id, 2, ""));
  EXPECT_EQ(*database->ResendDeadLetters("mes", {}, Cell("")), 2);
  EXPECT_EQ((*database->WantedLetter(Get().id))->id, 1);
  EXPECT_TRUE(*database->EndWantedLetter(Get().id, 1, "HTTP 410"));
  EXPECT_EQ((*database->WantedLetter(Get().id))->id, 3);
  EXPECT_EQ(Get().dead_letters, 2);
  EXPECT_EQ(database->ListDeadLetters("mes", {})->rows.at(1).tries, 5);
  ASSERT_TRUE(database->RemoveWebhook("mes", 0, Cell("")).ok());
}

}  // namespace
}  // namespace axiscal::storage
