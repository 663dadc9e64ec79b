// Routines and their runs as rows: what is refused, which sessions are new to a routine, and that one run is open at a
// time.
#include "server/storage/routines.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

using records::Scope;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const MachineId kMt("mt"), kMt2("mt2");

class Routines : public testing::Test {
 protected:
  Routines() {
    for (const MachineId& machine : {kMt, kMt2}) DEMAND(database->CreateMachine(machine, "{}", Cell("")).ok());
    DEMAND(database->CreatePrincipal("nightly", "", Cell("")).ok());
  }

  static Routine Nightly() {
    Routine routine;
    routine.name = "nightly";
    routine.scope = {Scope::Kind::kMachine, "mt"};
    routine.principal = "nightly";
    routine.sessions = {"CR", "BX"};
    return routine;
  }
  RoutineRecord Put(const Routine& routine) {
    const auto put = database->PutRoutine(routine, 0, Cell(""));
    EXPECT_TRUE(put.ok()) << put.status();
    return put.ok() ? *put : RoutineRecord();
  }
  std::string WhyNot(const Routine& routine, int64_t etag = 0) {
    return base::ErrorReason(database->PutRoutine(routine, etag, Cell("")).status());
  }
  SessionId Store(const std::string& name, const MachineId& machine = kMt) {
    NewSession session = TestSession("");
    session.machine = machine;
    session.name = name;
    const SessionId id = database->CreateSession(session)->id;
    const std::vector<session::Column> columns = TestColumns(id.number(), 10);
    DEMAND(Append(*database, id, 0, columns).ok());
    DEMAND(database->FinishSession(id, {1, 10, session::SessionHash({session::ChunkCrc32c(columns)})}).ok());
    return id;
  }
  std::optional<SessionId> NewFor(const RoutineRecord& routine, const std::string& name) {
    const auto session = database->NewSessionFor(routine.id, kMt, name);
    EXPECT_TRUE(session.ok()) << session.status();
    if (!session.ok() || !*session) return std::nullopt;
    return (*session)->id;
  }
  std::string AuditText(const std::string& action) {
    const auto page = database->ListAudit({}, {});
    DEMAND(page.ok());
    for (const AuditEntry& entry : page->rows)
      if (entry.action == action) return entry.resource + ": " + entry.was + " > " + entry.became;
    return "";
  }

  TempDatabase database;
};

TEST_F(Routines, AreKeptAsTheyWereSaid) {
  Routine said = Nightly();
  said.check_sessions = {"CK"};
  said.work = records::RoutineWork::kLoop;
  said.within_hours = 48;
  said.at_utc_minute = 125;
  said.max_effects = 3;
  said.budget_json = "{}";
  said.monte_carlo_runs = 100;
  said.monte_carlo_seed = uint64_t{1} << 63;
  said.approve_within_um = 2.5;
  said.note = "after the night shift";
  Put(said);
  database.Close();
  database.Open();
  const auto routines = database->ListRoutines({});
  ASSERT_EQ(routines->size(), 1u);
  const Routine& kept = (*routines)[0].content;
  EXPECT_THAT(kept.sessions, ElementsAre("CR", "BX"));
  EXPECT_THAT(kept.check_sessions, ElementsAre("CK"));
  EXPECT_EQ(kept.within_hours, 48);
  EXPECT_EQ(kept.at_utc_minute, 125);
  EXPECT_EQ(kept.max_effects, 3);
  EXPECT_EQ(kept.monte_carlo_runs, 100);
  EXPECT_EQ(kept.monte_carlo_seed, uint64_t{1} << 63);
  EXPECT_EQ(kept.approve_within_um, 2.5);
  EXPECT_EQ(kept.note, "after the night shift");
  EXPECT_EQ((*routines)[0].etag, 1);
  EXPECT_THAT(
      AuditText("routine.put"),
      HasSubstr("routines/nightly:  > for machine mt as nightly; sessions CR, BX within 48 h at 02:05 UTC; close "
                "the loop proved on CK"));
}

TEST_F(Routines, AreChangedByWhoeverHasSeenThem) {
  Put(Nightly());
  EXPECT_EQ(Put(Nightly()).etag, 1);  // nothing has changed
  Routine later = Nightly();
  later.within_hours = 30;
  EXPECT_EQ(WhyNot(later, 7), "ETAG_MISMATCH");
  EXPECT_EQ(database->PutRoutine(later, 1, Cell(""))->etag, 2);
  EXPECT_EQ(base::ErrorReason(database->RemoveRoutine("nightly", 1, Cell("")).status()), "ETAG_MISMATCH");
  ASSERT_TRUE(database->RemoveRoutine("nightly", 2, Cell("")).ok());
  EXPECT_TRUE(database->ListRoutines({})->empty());
  EXPECT_EQ(base::ErrorReason(database->RemoveRoutine("nightly", 0, Cell("")).status()), "ROUTINE_NOT_FOUND");
  EXPECT_EQ(Put(Nightly()).etag, 1);  // its name is free again
}

TEST_F(Routines, NeedWhatTheyName) {
  Routine routine = Nightly();
  routine.principal = "nobody";
  EXPECT_EQ(WhyNot(routine), "PRINCIPAL_NOT_FOUND");
  routine = Nightly();
  routine.scope.name = "none";
  EXPECT_EQ(WhyNot(routine), "MACHINE_NOT_FOUND");
  routine.scope = {Scope::Kind::kGroup, "turning"};
  EXPECT_EQ(WhyNot(routine), "GROUP_NOT_FOUND");
  ASSERT_TRUE(database->RevokePrincipal("nightly", Cell("")).ok());
  EXPECT_EQ(WhyNot(Nightly()), "PRINCIPAL_REVOKED");
  EXPECT_TRUE(database->ListRoutines({})->empty());
}

TEST_F(Routines, WorkForTheMachinesThatAreInTheGroupNow) {
  ASSERT_TRUE(database->ChangeGroup("turning", kMt2, true, Cell("")).ok());
  Routine routine = Nightly();
  routine.scope = {Scope::Kind::kGroup, "turning"};
  Put(routine);
  EXPECT_THAT(*database->MachinesWithRoutines(), ElementsAre(kMt2));
  EXPECT_TRUE(database->RoutinesOf(kMt)->empty());
  EXPECT_EQ(database->RoutinesOf(kMt2)->size(), 1u);
  ASSERT_TRUE(database->ChangeGroup("turning", kMt, true, Cell("")).ok());
  EXPECT_THAT(*database->MachinesWithRoutines(), ElementsAre(kMt, kMt2));
  const Visible one{false, {{Scope::Kind::kMachine, "mt"}}, "ann"};
  EXPECT_EQ(database->ListRoutines(one)->size(), 1u);
  ASSERT_TRUE(database->ChangeGroup("turning", kMt, false, Cell("")).ok());
  EXPECT_TRUE(database->ListRoutines(one)->empty());
}

// Each session is used once; what came before the routine is none of its business.
TEST_F(Routines, TakeSessionsThatAreNewToThem) {
  Store("CR");
  const RoutineRecord routine = Put(Nightly());
  EXPECT_EQ(NewFor(routine, "CR"), std::nullopt);
  const SessionId first = Store("CR"), second = Store("CR"), bx = Store("BX");
  Store("CR", kMt2);
  EXPECT_EQ(NewFor(routine, "CR"), second);
  EXPECT_GT(second, first);
  ASSERT_TRUE(database->BeginRun(routine, kMt, {second, bx}, {}).ok());
  EXPECT_EQ(NewFor(routine, "CR"), std::nullopt);
  EXPECT_EQ(NewFor(routine, "BX"), std::nullopt);
  const SessionId third = Store("CR");
  EXPECT_EQ(NewFor(routine, "CR"), third);
  // Nor what came while it was disabled.
  Routine off = Nightly();
  off.is_enabled = false;
  Put(off);
  Store("BX");
  const RoutineRecord on = Put(Nightly());
  EXPECT_EQ(on.id, routine.id);
  EXPECT_EQ(NewFor(on, "CR"), std::nullopt);
  EXPECT_EQ(NewFor(on, "BX"), std::nullopt);
}

TEST_F(Routines, RunOnceAtATimeAndAreTriedAgainWhenTheyFailed) {
  const RoutineRecord routine = Put(Nightly());
  const SessionId cr = Store("CR"), bx = Store("BX");
  const auto run = database->BeginRun(routine, kMt, {cr, bx}, {});
  ASSERT_TRUE(run.ok()) << run.status();
  EXPECT_EQ(run->state, RunState::kWaiting);
  EXPECT_EQ(run->principal, "nightly");
  EXPECT_FALSE(database->BeginRun(routine, kMt, {cr, bx}, {}).ok());
  EXPECT_EQ(base::ErrorReason(database->RetryRoutine("nightly", kMt, Cell("")).status()), "RUN_NOT_FAILED");
  EXPECT_EQ(base::ErrorReason(database->RetryRoutine("nightly", kMt2, Cell("")).status()), "RUN_NOT_FAILED");
  const int64_t changes = database->GetLookStand(kMt)->changes;
  ASSERT_TRUE(database->ChangeRun({run->id, RunState::kFailed, {}, {}, "why"}).ok());
  EXPECT_GT(database->GetLookStand(kMt)->changes, changes);  // those who look for events hear of it
  const auto again = database->RetryRoutine("nightly", kMt, Cell(""));
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_THAT(again->sessions, ElementsAre(cr, bx));
  EXPECT_EQ(again->state, RunState::kWaiting);
  ASSERT_EQ(database->NewestRuns(kMt)->size(), 1u);
  EXPECT_EQ(database->NewestRuns(kMt)->at(0).id, again->id);
  EXPECT_THAT(AuditText("routine.retry"), HasSubstr("run 1 failed > machines/mt waiting"));

  const auto all = database->ListRuns({}, {}, {});
  ASSERT_EQ(all->rows.size(), 2u);
  EXPECT_EQ(all->rows[0].id, again->id);
  EXPECT_EQ(all->rows[1].text, "why");
  EXPECT_TRUE(all->rows[1].ended_at.has_value());
  EXPECT_EQ(database->ListRuns({kMt, "nightly"}, {1, ""}, {})->rows.size(), 1u);
  EXPECT_TRUE(database->ListRuns({kMt2, ""}, {}, {})->rows.empty());
  EXPECT_EQ(database->ListRuns({{}, "nightly"}, {}, {false, {{Scope::Kind::kMachine, "mt"}}, "ann"})->rows.size(), 2u);
  EXPECT_TRUE(database->ListRuns({}, {}, {false, {{Scope::Kind::kMachine, "mt2"}}, "ann"})->rows.empty());
  EXPECT_EQ(base::ErrorReason(database->ListRuns({{}, "none"}, {}, {}).status()), "ROUTINE_NOT_FOUND");
}

// A run of a routine that was removed is still to be ended.
TEST_F(Routines, WhatIsOpenOfARemovedRoutineIsStillFound) {
  const RoutineRecord routine = Put(Nightly());
  const auto run = database->BeginRun(routine, kMt, {Store("CR"), Store("BX")}, {});
  ASSERT_TRUE(database->RemoveRoutine("nightly", 0, Cell("")).ok());
  EXPECT_THAT(*database->MachinesWithRoutines(), ElementsAre(kMt));
  EXPECT_TRUE(database->RoutinesOf(kMt)->empty());
  ASSERT_EQ(database->NewestRuns(kMt)->size(), 1u);
  ASSERT_TRUE(database->ChangeRun({run->id, RunState::kStopped, {}, {}, "removed"}).ok());
  EXPECT_TRUE(database->MachinesWithRoutines()->empty());
  EXPECT_TRUE(database->NewestRuns(kMt)->empty());
}

TEST_F(Routines, AreStoppedOnOneMachine) {
  Put(Nightly());
  EXPECT_TRUE(database->StopRoutine("nightly", kMt2, false, "", Cell(""))->stops.empty());
  ASSERT_TRUE(database->StopRoutine("nightly", kMt, true, "the probe is loose", Cell("")).ok());
  const auto stopped = database->StopRoutine("nightly", kMt, true, "again", Cell(""));
  ASSERT_EQ(stopped->stops.size(), 1u);
  EXPECT_EQ(stopped->stops[0].note, "the probe is loose");
  EXPECT_EQ(stopped->stops[0].by, "cell");
  EXPECT_THAT(AuditText("routine.stop"), HasSubstr("machines/mt stopped: the probe is loose"));
  EXPECT_TRUE(database->StopRoutine("nightly", kMt, false, "", Cell(""))->stops.empty());
}

}  // namespace
}  // namespace axiscal::storage
