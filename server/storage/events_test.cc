#include "server/storage/events.h"

#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

using records::EventChangeKind;

const MachineId kMt("mt"), kOther("other");

class Events : public testing::Test {
 protected:
  Events() {
    for (const MachineId& machine : {kMt, kOther}) DEMAND(database->CreateMachine(machine, "{}", Cell("")).ok());
  }
  static EventContent OutOfTolerance(const std::string& symbol, double size) {
    EventContent content;
    content.kind = EventKind::kOutOfTolerance;
    content.subject = symbol;
    content.text = absl::StrCat(symbol, " is ", size);
    content.advice = "look";
    content.amounts = {{symbol, EstimateUnit::kUm, size, 0.5}};
    content.certainty = 0.99;
    return content;
  }
  static EventContent Step(UtcTime from) {
    EventContent content;
    content.kind = EventKind::kStep;
    content.text = "jumped";
    content.from = from;
    content.to = from + std::chrono::days(7);
    return content;
  }
  EventId Raise(const MachineId& machine, const EventContent& content) {
    EventChanges changes{.machine = machine, .raised = {content}};
    EXPECT_EQ(*database->ChangeEvents(changes), 1);
    return database->ListEvents({}, {}, {})->rows.at(0).id;
  }
  std::vector<EventChange> ChangesAfter(int64_t after, const Visible& visible = {}) {
    const auto page = database->ReadEventChanges(after, {}, visible);
    EXPECT_TRUE(page.ok()) << page.status();
    return page->changes;
  }

  TempDatabase database;
};

TEST_F(Events, WhatIsExpectedIsKeptInOrderAndGuardedByItsEtag) {
  EXPECT_EQ(database->GetExpectations(kMt)->etag, 0);
  Expectations expected{kMt, {{"EX0C", -20, 20}, {"EB0C", -5, 7.5}}, 90, {{"nightly", 24}}, true};
  const auto set = database->SetExpectations(expected, 0, Cell(""));
  ASSERT_TRUE(set.ok()) << set.status();
  EXPECT_EQ(set->etag, 1);
  EXPECT_EQ(set->changed_by, "cell");
  ASSERT_EQ(set->content.tolerances.size(), 2u);
  EXPECT_EQ(set->content.tolerances[0].symbol, "EB0C");
  EXPECT_EQ(set->content.tolerances[0].high, 7.5);
  EXPECT_EQ(set->content.calibration_days, 90);
  EXPECT_EQ(set->content.sessions.at(0).every_hours, 24);
  EXPECT_TRUE(set->content.counts_candidates);
  // The same again is no change.
  EXPECT_EQ(database->SetExpectations(expected, 0, Cell(""))->etag, 1);
  expected.tolerances.pop_back();
  expected.calibration_days.reset();
  EXPECT_EQ(database->SetExpectations(expected, 1, Cell(""))->etag, 2);
  EXPECT_EQ(base::ErrorReason(database->SetExpectations(expected, 1, Cell("")).status()), "ETAG_MISMATCH");
  EXPECT_EQ(database->GetExpectations(kMt)->content.tolerances.size(), 1u);
  EXPECT_EQ(database->ListAudit({})->rows[0].action, "expectations.set");
}

TEST_F(Events, AreRaisedOnceUpdatedAndCleared) {
  const EventId id = Raise(kMt, OutOfTolerance("EX0C", 31));
  EXPECT_EQ(*database->ChangeEvents({.machine = kMt, .raised = {OutOfTolerance("EX0C", 32)}}), 0);
  EXPECT_EQ(*database->ChangeEvents({.machine = kMt, .updated = {{id, OutOfTolerance("EX0C", 33)}}}), 1);
  Event event = *database->GetEvent(id);
  EXPECT_EQ(event.content.text, "EX0C is 33");
  ASSERT_EQ(event.content.amounts.size(), 1u);
  EXPECT_EQ(event.content.amounts[0].size, 33);
  EXPECT_EQ(*database->ChangeEvents({.machine = kMt, .cleared = {{id, "inside again"}}}), 1);
  EXPECT_EQ(*database->ChangeEvents({.machine = kMt, .cleared = {{id, "inside again"}}}), 0);
  EXPECT_EQ(*database->ChangeEvents({.machine = kMt, .updated = {{id, OutOfTolerance("EX0C", 34)}}}), 0);
  event = *database->GetEvent(id);
  EXPECT_EQ(event.cleared_why, "inside again");
  EXPECT_EQ(event.content.text, "EX0C is 33");
  EXPECT_TRUE(database->ListEvents({{}, true}, {}, {})->rows.empty());
  EXPECT_EQ(database->ListEvents({kMt, false}, {}, {})->rows.size(), 1u);
  // A new one after it, and one of another machine beside it.
  EXPECT_NE(Raise(kMt, OutOfTolerance("EX0C", 35)), id);
  Raise(kOther, OutOfTolerance("EX0C", 35));
  EXPECT_EQ(database->ListEvents({{}, true}, {}, {})->rows.size(), 2u);
  EXPECT_EQ(database->ListEvents({kMt, true}, {}, {})->rows.size(), 1u);
}

TEST_F(Events, StepsAreToldApartByTheirDates) {
  const UtcTime first = database.clock.UtcNow() - std::chrono::days(30), second = first + std::chrono::days(14);
  const EventId id = Raise(kMt, Step(first));
  Raise(kMt, Step(second));
  EXPECT_EQ(*database->ChangeEvents({.machine = kMt, .raised = {Step(first)}}), 0);
  // A person's word ends a step: it has happened, and is not raised again while the history shows it.
  const auto seen = database->AcknowledgeEvent(id, "the chuck was hit", {"ann", ""});
  ASSERT_TRUE(seen.ok()) << seen.status();
  EXPECT_TRUE(seen->cleared_at.has_value());
  EXPECT_EQ(database->StandingEvents(kMt)->size(), 2u);
  EXPECT_EQ(database->ListEvents({kMt, true}, {}, {})->rows.size(), 1u);
}

TEST_F(Events, AWordOfAPersonStaysAndTheFirstOneCounts) {
  const EventId id = Raise(kMt, OutOfTolerance("EX0C", 31));
  ASSERT_TRUE(database->AcknowledgeEvent(id, "service comes on Monday", {"ann", ""}).ok());
  ASSERT_TRUE(database->AcknowledgeEvent(id, "me too", {"bob", ""}).ok());
  const Event event = *database->GetEvent(id);
  EXPECT_EQ(event.acknowledged_by, "ann");
  EXPECT_EQ(event.acknowledged_note, "service comes on Monday");
  EXPECT_FALSE(event.cleared_at.has_value());
  EXPECT_EQ(ChangesAfter(0).size(), 2u);
  EXPECT_EQ(base::ErrorReason(database->AcknowledgeEvent(EventId(99), "", Cell("")).status()), "EVENT_NOT_FOUND");
}

TEST_F(Events, OnTheShelfUntilItsTimeIsOver) {
  const EventId id = Raise(kMt, OutOfTolerance("EX0C", 31));
  const UtcTime now = database.clock.UtcNow();
  for (const UtcTime wrong : {now, now - std::chrono::hours(1), now + std::chrono::days(400)})
    EXPECT_EQ(base::ErrorReason(database->ShelveEvent(id, wrong, "", Cell("")).status()), "EVENT_INVALID");
  ASSERT_TRUE(database->ShelveEvent(id, now + std::chrono::hours(8), "maintenance", {"ann", ""}).ok());
  EXPECT_EQ(database->GetEvent(id)->shelved_until, now + std::chrono::hours(8));
  EXPECT_EQ(*database->BringBackEvents(), 0);
  database.clock.Advance(std::chrono::hours(8));
  EXPECT_EQ(*database->BringBackEvents(), 1);
  EXPECT_EQ(*database->BringBackEvents(), 0);
  EXPECT_FALSE(database->GetEvent(id)->shelved_until.has_value());
  ASSERT_TRUE(database->ShelveEvent(id, database.clock.UtcNow() + std::chrono::hours(8), "", {"ann", ""}).ok());
  ASSERT_TRUE(database->ShelveEvent(id, {}, "done already", {"ann", ""}).ok());
  std::vector<EventChangeKind> kinds;
  for (const EventChange& change : ChangesAfter(0)) kinds.push_back(change.what);
  EXPECT_EQ(kinds, (std::vector{EventChangeKind::kRaised, EventChangeKind::kShelved, EventChangeKind::kBack,
                                EventChangeKind::kShelved, EventChangeKind::kBack}));
  ASSERT_EQ(*database->ChangeEvents({.machine = kMt, .cleared = {{id, "over"}}}), 1);
  EXPECT_EQ(base::ErrorReason(
                database->ShelveEvent(id, database.clock.UtcNow() + std::chrono::hours(1), "", Cell("")).status()),
            "EVENT_CLEARED");
}

TEST_F(Events, ChangesAreHandedOutInOrderAndOnlyToWhoMaySeeThem) {
  for (int i = 0; i < 700; ++i) Raise(i % 7 == 0 ? kMt : kOther, OutOfTolerance(absl::StrCat("E", i), i));
  Visible some{false, {{records::Scope::Kind::kMachine, "mt"}}, "ann"};
  int64_t after = 0, seen = 0, pages = 0;
  bool is_last = false;
  while (!is_last) {
    const auto page = database->ReadEventChanges(after, {}, some);
    ASSERT_TRUE(page.ok()) << page.status();
    for (const EventChange& change : page->changes) {
      EXPECT_GT(change.id, after);
      after = change.id;
      EXPECT_EQ(change.event.machine, kMt);
      ++seen;
    }
    after = page->up_to;
    is_last = page->is_last;
    ++pages;
  }
  EXPECT_EQ(seen, 100);
  EXPECT_EQ(pages, 2);
  EXPECT_EQ(after, *database->LastEventChange());
  EXPECT_EQ(database->ReadEventChanges(0, kMt, {})->changes.size(), 72u);  // of the first 500
  EXPECT_EQ(ChangesAfter(after - 1).size(), 1u);
  EXPECT_EQ(base::ErrorReason(database->ReadEventChanges(after + 1, {}, {}).status()), "CHANGE_UNKNOWN");
  int listed = 0;
  PageRequest request{30, ""};
  do {
    const auto page = database->ListEvents({{}, true}, request, some);
    ASSERT_TRUE(page.ok()) << page.status();
    for (const Event& event : page->rows) {
      EXPECT_EQ(event.machine, kMt);
      ++listed;
    }
    request.token = page->next_token;
  } while (!request.token.empty());
  EXPECT_EQ(listed, 100);
}

// At a glance: what is in use, what waits, what nobody has seen, and what the last look has found.
TEST_F(Events, CareOfEachMachineIsListedByName) {
  ASSERT_TRUE(database->CreateMachine(MachineId("a"), R"({"id": "a"})", Cell("")).ok());
  const auto list = [&](const PageRequest& page = {}) { return *database->ListCare(page, {}); };
  ASSERT_EQ(list().rows.size(), 3u);
  EXPECT_EQ(list().rows[0].machine, MachineId("a"));
  const auto mt = [&] { return list().rows[1]; };
  EXPECT_FALSE(mt().in_use.has_value());
  EXPECT_TRUE(mt().is_followed);  // there is no history
  const UtcTime start = database.clock.UtcNow();
  const auto used = database->CreateCalibration(TestCalibration(start, 1.0));
  ASSERT_TRUE(used.ok() && database->ApproveCalibration(used->id, 0, Cell("")).ok());
  const auto older = database->CreateCalibration(TestCalibration(start - std::chrono::hours(1), 2.0));
  const auto newer = database->CreateCalibration(TestCalibration(start + std::chrono::hours(1), 3.0));
  ASSERT_TRUE(older.ok() && newer.ok());
  EXPECT_EQ(mt().in_use->calibration, used->id);
  EXPECT_EQ(mt().in_use->measured_at, start);
  EXPECT_EQ(mt().waiting, 1);  // the older one is news of the past
  EXPECT_FALSE(mt().is_followed);
  EventContent first, second;
  first.kind = EventKind::kWear;
  first.text = "wears";
  second.kind = EventKind::kScatter;
  second.text = "scatters";
  const int64_t changes = database->GetLookStand(kMt)->changes;
  const std::vector<StandingFinding> findings = {{DriftKind::kStep, start, "jumped"},
                                                 {DriftKind::kSuspect, start, "doubtful"}};
  ASSERT_TRUE(
      database
          ->ChangeEvents(
              {.machine = kMt, .raised = {first, second}, .looked_at = changes, .looked_by = "1", .findings = findings})
          .ok());
  EXPECT_TRUE(mt().is_followed);
  EXPECT_EQ(mt().new_events, 2);
  EXPECT_EQ(mt().newest_event, "scatters");
  ASSERT_EQ(mt().findings.size(), 2u);
  EXPECT_EQ(mt().findings[1].kind, DriftKind::kSuspect);
  EXPECT_EQ(mt().findings[0].text, "jumped");
  // Seen, or on the shelf, an event is no news; time alone leaves the findings, another look replaces them.
  const std::vector<Event> open = database->ListEvents({kMt, true}, {}, {})->rows;
  ASSERT_TRUE(database->AcknowledgeEvent(open[0].id, "seen", Cell("")).ok());
  const UtcTime until = database.clock.UtcNow() + std::chrono::hours(1);
  ASSERT_TRUE(database->ShelveEvent(open[1].id, until, "", Cell("")).ok());
  EXPECT_EQ(mt().new_events, 0);
  EXPECT_EQ(mt().newest_event, "");
  database.clock.Advance(std::chrono::hours(2));
  EXPECT_EQ(mt().new_events, 1);
  EXPECT_EQ(mt().findings.size(), 2u);
  ASSERT_TRUE(database->ChangeEvents({.machine = kMt, .looked_at = changes, .looked_by = "1"}).ok());
  EXPECT_TRUE(mt().findings.empty());
  // Pages, and what one may see.
  EXPECT_EQ(list({1, ""}).rows[0].machine, MachineId("a"));
  EXPECT_EQ(list({1, list({1, ""}).next_token}).rows[0].machine, kMt);
  const Visible one{false, {{records::Scope::Kind::kMachine, "a"}}, "ann"};
  ASSERT_EQ(database->ListCare({}, one)->rows.size(), 1u);
  ASSERT_TRUE(database->DeleteMachine(MachineId("a"), 0, Cell("")).ok());
  EXPECT_EQ(list().rows.size(), 2u);
}

// Whatever events follow from makes its machine one to look at, until it was looked at as it stands.
TEST_F(Events, MachinesThatChangeAreLookedAt) {
  EXPECT_TRUE(database->MachinesToLookAt("1")->empty());
  const auto looked = [&] {
    const LookStand stand = *database->GetLookStand(kMt);
    DEMAND(database->ChangeEvents({.machine = kMt, .looked_at = stand.changes, .looked_by = "1"}).ok());
    return database->MachinesToLookAt("1")->empty();
  };
  const auto is_due = [&] { return *database->MachinesToLookAt("1") == std::vector{kMt}; };
  const auto calibration = database->CreateCalibration(TestCalibration(database.clock.UtcNow(), 1.0));
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  EXPECT_TRUE(is_due());
  EXPECT_TRUE(looked());
  EXPECT_EQ(*database->MachinesToLookAt("2"), std::vector{kMt});  // another version would say other things
  ASSERT_TRUE(database->ApproveCalibration(calibration->id, 0, Cell("")).ok());
  EXPECT_TRUE(is_due());
  const LookStand before = *database->GetLookStand(kMt);
  const auto mark = database->PutMark({kMt, database.clock.UtcNow(), records::MarkKind::kService, {}, ""}, Cell(""));
  ASSERT_TRUE(mark.ok()) << mark.status();
  // What came while it was looked at is looked at again.
  ASSERT_TRUE(database->ChangeEvents({.machine = kMt, .looked_at = before.changes, .looked_by = "1"}).ok());
  EXPECT_TRUE(is_due());
  EXPECT_TRUE(looked());
  ASSERT_TRUE(database->WithdrawMark(mark->id, Cell("")).ok());
  EXPECT_TRUE(is_due());
  EXPECT_TRUE(looked());
  ASSERT_TRUE(database->SetExpectations({kMt, {}, 90, {}, false}, 0, Cell("")).ok());
  EXPECT_FALSE(looked());  // by time it is looked at always
  ASSERT_TRUE(database->DeleteMachine(kMt, 0, Cell("")).ok());
  EXPECT_TRUE(database->MachinesToLookAt("1")->empty());
}

TEST_F(Events, TheNewestSessionOfAName) {
  EXPECT_FALSE(database->NewestSession(kMt, "CR")->has_value());
  StoreSession(*database, 1);
  EXPECT_EQ(**database->NewestSession(kMt, "CR"), database.clock.UtcNow());
  EXPECT_FALSE(database->NewestSession(kMt, "BX")->has_value());
}

}  // namespace
}  // namespace axiscal::storage
