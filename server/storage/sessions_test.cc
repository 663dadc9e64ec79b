#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "server/storage/check.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

class Sessions : public testing::Test {
 protected:
  Sessions() {
    DEMAND(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
    id = database->CreateSession(TestSession("r1"))->id;
  }
  absl::Status AppendTest(int64_t seq, int64_t content) {
    return Append(*database, id, seq, TestColumns(content, 10)).status();
  }
  SessionTotals Totals(int chunks) {
    std::vector<uint32_t> crcs;
    for (int seq = 0; seq < chunks; ++seq) crcs.push_back(session::ChunkCrc32c(TestColumns(seq, 10)));
    return {chunks, chunks * 10, session::SessionHash(crcs)};
  }

  TempDatabase database;
  SessionId id;
};

TEST_F(Sessions, CreateIsIdempotentByRequestId) {
  EXPECT_EQ(database->CreateSession(TestSession("r1"))->id, id);
  EXPECT_NE(database->CreateSession(TestSession("r2"))->id, id);
  NewSession other = TestSession("r1");
  other.name = "CQ";
  const absl::Status reused = database->CreateSession(other).status();
  EXPECT_TRUE(absl::IsInvalidArgument(reused)) << reused;
  EXPECT_EQ(base::ErrorReason(reused), "REQUEST_ID_REUSED");
  NewSession of_another = TestSession("r1");
  of_another.caller.principal = "other cell";
  EXPECT_EQ(database->CreateSession(of_another)->id, id);  // a session is its machine and content
  of_another.name = "CQ";
  EXPECT_NE(database->CreateSession(of_another)->id, id);  // ids of others are no obstacle
}

TEST_F(Sessions, ReadBackWhatWasAppended) {
  for (int seq = 0; seq < 3; ++seq) ASSERT_TRUE(AppendTest(seq, seq).ok());
  ASSERT_TRUE(database->FinishSession(id, Totals(3)).ok());
  database.Close();
  database.Open();
  const absl::StatusOr<session::Session> read = database->ReadSession(id);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->header, TestSession("").header);
  ASSERT_EQ(read->columns.size(), 3u);
  EXPECT_EQ(read->reading_count(), 30u);
  for (int i = 0; i < 30; ++i) {
    const std::vector<session::Column> columns = TestColumns(i / 10, 10);
    EXPECT_EQ(read->columns[1].values[i], columns[1].values[i % 10]);
    EXPECT_EQ(read->columns[2].texts[i], columns[2].texts[i % 10]);
  }
}

TEST_F(Sessions, RepeatedChunksAreRecognised) {
  ASSERT_TRUE(AppendTest(0, 0).ok());
  const auto again = Append(*database, id, 0, TestColumns(0, 10));
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_TRUE(again->duplicate);
  EXPECT_EQ(again->next_seq, 1);
  const absl::Status other = AppendTest(0, 5);
  EXPECT_TRUE(absl::IsAlreadyExists(other)) << other;
  EXPECT_EQ(base::ErrorReason(other), "CHUNK_CONFLICT");
  EXPECT_EQ(database->GetSession(id)->reading_count, 10);
}

TEST_F(Sessions, AGapNamesTheNextSeq) {
  ASSERT_TRUE(AppendTest(0, 0).ok());
  const absl::Status gap = AppendTest(2, 2);
  EXPECT_TRUE(absl::IsOutOfRange(gap)) << gap;
  EXPECT_EQ(base::ErrorReason(gap), "SEQ_GAP");
  EXPECT_EQ(base::GetErrorDetail(gap)->facts.at("next_seq"), "1");
}

TEST_F(Sessions, OtherColumnsAreRefused) {
  const std::vector<session::Column> columns = TestColumns(0, 10);
  std::vector<session::Column> fewer = {columns[0]};
  EXPECT_EQ(base::ErrorReason(Append(*database, id, 0, fewer).status()), "CHUNK_INVALID");
  EXPECT_EQ(base::ErrorReason(Append(*database, SessionId(99), 0, columns).status()), "SESSION_NOT_FOUND");
  EXPECT_EQ(database->GetSession(id)->next_seq, 0);
}

TEST_F(Sessions, OpenOnesAreNotReadable) {
  ASSERT_TRUE(AppendTest(0, 0).ok());
  EXPECT_EQ(base::ErrorReason(database->ReadSession(id).status()), "SESSION_NOT_COMPLETE");
}

TEST_F(Sessions, FinishChecksTheTotalsAndMayBeRepeated) {
  ASSERT_TRUE(AppendTest(0, 0).ok());
  ASSERT_TRUE(AppendTest(1, 1).ok());
  SessionTotals wrong = Totals(2);
  wrong.reading_count = 19;
  EXPECT_EQ(base::ErrorReason(database->FinishSession(id, wrong).status()), "TOTALS_MISMATCH");
  wrong = Totals(2);
  wrong.hash = Totals(1).hash;
  EXPECT_EQ(base::ErrorReason(database->FinishSession(id, wrong).status()), "TOTALS_MISMATCH");
  EXPECT_EQ(base::ErrorReason(database->FinishSession(id, Totals(1)).status()), "TOTALS_MISMATCH");
  const auto finished = database->FinishSession(id, Totals(2));
  ASSERT_TRUE(finished.ok()) << finished.status();
  EXPECT_EQ(finished->state, SessionState::kComplete);
  EXPECT_EQ(finished->hash, Totals(2).hash);
  EXPECT_TRUE(database->FinishSession(id, Totals(2)).ok());
  EXPECT_EQ(base::ErrorReason(database->FinishSession(id, Totals(1)).status()), "TOTALS_MISMATCH");
}

TEST_F(Sessions, AnEmptyOneIsNotFinished) {
  EXPECT_EQ(base::ErrorReason(database->FinishSession(id, Totals(0)).status()), "SESSION_EMPTY");
}

TEST_F(Sessions, CompleteOnesNeverChange) {
  ASSERT_TRUE(AppendTest(0, 0).ok());
  ASSERT_TRUE(database->FinishSession(id, Totals(1)).ok());
  EXPECT_EQ(base::ErrorReason(AppendTest(1, 1)), "SESSION_CLOSED");
  EXPECT_TRUE(AppendTest(0, 0).ok());  // a repeat after a lost answer
  EXPECT_EQ(base::ErrorReason(database->AbortSession(id).status()), "SESSION_CLOSED");
}

TEST_F(Sessions, AbortedAndExpiredOnesLoseTheirChunks) {
  ASSERT_TRUE(AppendTest(0, 0).ok());
  ASSERT_TRUE(database->AbortSession(id).ok());
  EXPECT_EQ(database->AbortSession(id)->state, SessionState::kAborted);
  EXPECT_EQ(base::ErrorReason(AppendTest(0, 0)), "SESSION_CLOSED");

  const SessionId idle = database->CreateSession(TestSession("idle"))->id;
  database.clock.Advance(std::chrono::hours(1));
  const SessionId busy = database->CreateSession(TestSession("busy"))->id;
  EXPECT_EQ(*database->ExpireSessions(std::chrono::minutes(1)), 1);
  EXPECT_EQ(database->GetSession(idle)->state, SessionState::kExpired);
  EXPECT_EQ(database->GetSession(busy)->state, SessionState::kOpen);
}

// Only time in which a server had the file open counts.
TEST_F(Sessions, ExpireNeitherByAClockThatIsSetNorByANightWithoutPower) {
  using std::chrono::hours;
  const hours week(7 * 24);
  ASSERT_TRUE(AppendTest(0, 0).ok());
  database.Close();
  database.clock.SetUtc(database.clock.UtcNow() + hours(8 * 24));
  database.Open();
  EXPECT_EQ(*database->ExpireSessions(week), 0);
  database.Close();
  database.clock.Advance(hours(30 * 24));
  database.Open();
  EXPECT_EQ(*database->ExpireSessions(week), 0);
  // Six days up, restarts between them, and one day more; a clock set back holds nothing up.
  for (int day = 0; day < 6; ++day) {
    database.clock.Advance(hours(24));
    EXPECT_EQ(*database->ExpireSessions(week), 0);
    database.Close();
    database.clock.SetUtc(database.clock.UtcNow() - hours(72));
    database.Open();
  }
  database.clock.Advance(hours(25));
  EXPECT_EQ(*database->ExpireSessions(week), 1);
  EXPECT_EQ(database->GetSession(id)->state, SessionState::kExpired);
}

// A crash loses what was counted since it was saved last; what it has stamped lies not in the future.
TEST_F(Sessions, ExpireAfterTheirTimeAlsoBehindACrash) {
  using std::chrono::hours;
  database.clock.Advance(hours(100));
  ASSERT_TRUE(AppendTest(0, 0).ok());
  database.Close();
  ASSERT_TRUE(database.Beside()->Execute("UPDATE up_time SET up_us = 0").ok());
  database.Open();
  EXPECT_EQ(*database->ExpireSessions(hours(1)), 0);
  database.clock.Advance(hours(1) + std::chrono::minutes(1));
  EXPECT_EQ(*database->ExpireSessions(hours(1)), 1);
}

TEST_F(Sessions, WhatWasGivenUpCanBeSentAgain) {
  ASSERT_TRUE(AppendTest(0, 0).ok());
  ASSERT_TRUE(database->AbortSession(id).ok());
  const SessionRecord again = *database->CreateSession(TestSession("r1"));
  EXPECT_NE(again.id, id);
  EXPECT_EQ(again.state, SessionState::kOpen);
  EXPECT_EQ(database->CreateSession(TestSession("r1"))->id, again.id);
  EXPECT_EQ(database->GetSession(id)->state, SessionState::kAborted);
  ASSERT_TRUE(Append(*database, again.id, 0, TestColumns(0, 10)).ok());
  ASSERT_TRUE(database->FinishSession(again.id, Totals(1)).ok());
  EXPECT_EQ(database->CreateSession(TestSession("r1"))->id, again.id);
  NewSession other = TestSession("r1");
  other.name = "CQ";
  EXPECT_EQ(base::ErrorReason(database->CreateSession(other).status()), "REQUEST_ID_REUSED");
}

TEST_F(Sessions, ListsFilterAndPage) {
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(database->CreateSession(TestSession("")).ok());
  const SessionId complete = StoreSession(*database, 1);
  SessionFilter filter;
  filter.state = SessionState::kOpen;
  filter.machine = MachineId("mt");
  std::vector<int64_t> ids;
  PageRequest request = {4, ""};
  do {
    const auto page = database->ListSessions(filter, request);
    ASSERT_TRUE(page.ok()) << page.status();
    for (const SessionRecord& session : page->rows) ids.push_back(session.id.number());
    request.token = page->next_token;
    ASSERT_TRUE(database->CreateSession(TestSession("")).ok());  // newer ones must not shift the pages
  } while (!request.token.empty());
  EXPECT_EQ(ids, (std::vector<int64_t>{6, 5, 4, 3, 2, 1}));
  filter.state = SessionState::kComplete;
  EXPECT_EQ(database->ListSessions(filter, {})->rows.at(0).id, complete);
  filter.state = SessionState::kAborted;
  EXPECT_TRUE(database->ListSessions(filter, {})->rows.empty());
}

// All ids of a list, newest first, page by page; how many pages hold nothing.
struct Listed {
  std::vector<int64_t> ids;
  int pages = 0;
};

Listed ListAll(Database& database, const SessionFilter& filter, int page_size) {
  Listed listed;
  PageRequest request = {page_size, ""};
  do {
    const auto page = database.ListSessions(filter, request);
    EXPECT_TRUE(page.ok()) << page.status();
    if (!page.ok()) break;
    for (const SessionRecord& session : page->rows) listed.ids.push_back(session.id.number());
    request.token = page->next_token;
    ++listed.pages;
  } while (!request.token.empty());
  return listed;
}

TEST_F(Sessions, ListsAreHeldToTimeInstrumentAndName) {
  const UtcTime start = database.clock.UtcNow();
  NewSession session = TestSession("");
  session.name = "CQ";
  session.instrument = "ballbar";
  session.measured_at = start - std::chrono::hours(5);
  ASSERT_EQ(database->CreateSession(session)->id.number(), 2);
  session.measured_at = start;
  ASSERT_EQ(database->CreateSession(session)->id.number(), 3);
  database.clock.Advance(std::chrono::hours(1));
  session.measured_at.reset();  // it counts as measured when it came
  session.name = "CR";
  ASSERT_EQ(database->CreateSession(session)->id.number(), 4);
  using Ids = std::vector<int64_t>;
  const auto ids = [&](const SessionFilter& filter) { return ListAll(*database, filter, 1).ids; };
  for (const std::optional<MachineId>& machine : {std::optional<MachineId>(), std::optional(MachineId("mt"))}) {
    EXPECT_EQ(ids({machine, {}, {}, "ballbar"}), (Ids{4, 3, 2}));
    EXPECT_EQ(ids({machine, {}, {}, "", "CQ"}), (Ids{3, 2}));
    EXPECT_EQ(ids({machine, {}, {}, "ballbar", "CR"}), (Ids{4}));
    EXPECT_EQ(ids({machine, {}, {start, {}}, "ballbar"}), (Ids{4, 3}));
    EXPECT_EQ(ids({machine, {}, {{}, start}}), (Ids{2}));
    EXPECT_EQ(ids({machine, {}, {start, start + std::chrono::hours(1)}, "ballbar"}), (Ids{3}));
    EXPECT_EQ(ids({machine, SessionState::kComplete, {}, "ballbar"}), Ids{});
  }
  const auto page = database->ListSessions({{}, {}, {}, "ballbar"}, {1, ""});
  EXPECT_EQ(base::ErrorReason(database->ListSessions({{}, {}, {}, "touch"}, {1, page->next_token}).status()),
            "PAGE_INVALID");
}

// What fits few rows ends with its first page, however many newer rows fit it not.
TEST_F(Sessions, WhatFewRowsFitIsFoundHoweverManyDoNot) {
  constexpr int kOthers = 2250;
  NewSession session = TestSession("");
  session.name = "rare";
  session.instrument = "ballbar";
  session.measured_at = base::FromUtcUs(5);
  const auto rare = database->CreateSession(session);
  ASSERT_TRUE(rare.ok());
  const std::unique_ptr<Connection> connection = database.Beside();
  const std::string others = absl::StrCat("WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < ",
                                          kOthers, ") INSERT INTO ");
  ASSERT_TRUE(connection
                  ->Execute(others +
                            "session (machine_id, name, instrument, state, next_seq, reading_count, created_by, "
                            "body_sha256, created_at_utc_us, last_seen_at_utc_us) SELECT 1, 's', 'touch', 1, 0, 0, "
                            "'u', 'b', 100 + i, i FROM n")
                  .ok());
  ASSERT_TRUE(connection->Execute("INSERT INTO session_label (session_id, label) SELECT id, 'cold' FROM session").ok());
  ASSERT_TRUE(connection->Execute("INSERT INTO session_label (session_id, label) VALUES (2, 'warm')").ok());
  const TimeSpan early = {{}, base::FromUtcUs(100)}, at_all = {base::FromUtcUs(1), {}};
  const Visible all, some = {false, {{records::Scope::Kind::kMachine, "mt"}}, "u"};
  for (const std::optional<MachineId>& machine : {std::optional<MachineId>(), std::optional(MachineId("mt"))}) {
    for (const Visible& visible : {all, some}) {
      for (const SessionFilter& filter :
           {SessionFilter{machine, {}, {}, "", "rare"}, SessionFilter{machine, {}, {}, "ballbar"},
            SessionFilter{machine, {}, early}, SessionFilter{machine, {}, {}, "", "", "warm"},
            SessionFilter{machine, SessionState::kOpen, at_all, "ballbar", "rare", "cold"}}) {
        const auto page = database->ListSessions(filter, {}, visible);
        ASSERT_TRUE(page.ok()) << page.status();
        ASSERT_EQ(page->rows.size(), 1u);
        EXPECT_EQ(page->rows[0].id, rare->id);
        EXPECT_EQ(page->next_token, "");
      }
      const auto none = database->ListSessions({machine, SessionState::kAborted, {}, "", "rare"}, {}, visible);
      EXPECT_TRUE(none.ok() && none->rows.empty() && none->next_token.empty());
    }
    // What many fit comes in pages, each row once.
    for (const SessionFilter& filter :
         {SessionFilter{machine, {}, {}, "", "s"}, SessionFilter{machine, {}, {}, "touch"},
          SessionFilter{machine, {}, {base::FromUtcUs(1), {}}, "", "s", "cold"}})
      EXPECT_EQ(ListAll(*database, filter, 300).ids.size(), static_cast<size_t>(kOthers + filter.name.empty()));
  }
  // Of a label that other machines' sessions have, too, nobody sees those.
  const Visible other = {false, {{records::Scope::Kind::kMachine, "other"}}, "u"};
  for (const SessionFilter& filter :
       {SessionFilter{{}, {}, {}, "", "", "warm"}, SessionFilter{{}, {}, {}, "", "rare"}, SessionFilter{{}, {}, early}})
    EXPECT_TRUE(database->ListSessions(filter, {}, other)->rows.empty());
}

// A time that very many fit, behind very many that do not: each page has its rows, none is looked for in vain.
TEST_F(Sessions, WhatManyOfATimeAreIsFoundBehindManyThatAreNot) {
  constexpr int kOfTime = 7000, kOthers = 9000;
  {
    const std::unique_ptr<Connection> connection = database.Beside();
    for (const auto& [rows, first_us] : {std::pair(kOfTime, 1'000'000), std::pair(kOthers, 2'000'000)})
      ASSERT_TRUE(connection
                      ->Execute(absl::StrCat(
                          "WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < ", rows,
                          ") INSERT INTO session (machine_id, name, instrument, state, next_seq, reading_count, "
                          "created_by, body_sha256, created_at_utc_us, last_seen_at_utc_us) SELECT 1, 's', 'touch', "
                          "1, 0, 0, 'u', 'b', ",
                          first_us, " + i, i FROM n"))
                      .ok());
  }
  const TimeSpan early = {base::FromUtcUs(1'000'000), base::FromUtcUs(2'000'000)};
  const Visible all, some = {false, {{records::Scope::Kind::kMachine, "mt"}}, "u"};
  for (const std::optional<MachineId>& machine : {std::optional<MachineId>(), std::optional(MachineId("mt"))}) {
    for (const Visible& visible : {all, some}) {
      std::vector<int64_t> ids;
      PageRequest request = {1000, ""};
      do {
        const auto page = database->ListSessions({machine, {}, early}, request, visible);
        ASSERT_TRUE(page.ok()) << page.status();
        ASSERT_TRUE(!page->rows.empty() || page->next_token.empty());
        for (const SessionRecord& session : page->rows) ids.push_back(session.id.number());
        request.token = page->next_token;
      } while (!request.token.empty());
      ASSERT_EQ(ids.size(), static_cast<size_t>(kOfTime));
      EXPECT_TRUE(std::is_sorted(ids.rbegin(), ids.rend()));
      EXPECT_EQ(ids.front() - ids.back(), kOfTime - 1);
    }
  }
}

TEST_F(Sessions, ManyAppendsUnderWayAreAnsweredInOrder) {
  std::vector<int64_t> answered;
  for (int seq = 0; seq < 300; ++seq) {
    database->AppendChunkAsync(
        id, records::Chunk::Seal(seq, TestColumns(seq, 3)),
        [&](absl::StatusOr<AppendResult> result) { answered.push_back(result.ok() ? result->next_seq : -1); });
  }
  const records::Chunk other = records::Chunk::Seal(0, {TestColumns(0, 3)[0]});
  database->AppendChunkAsync(id, other, [&](absl::StatusOr<AppendResult> result) {
    answered.push_back(base::ErrorReason(result.status()) == "CHUNK_INVALID" ? 1000 : -1);
  });
  EXPECT_EQ(database->AbortSession(SessionId(99)).status().code(),
            absl::StatusCode::kNotFound);  // waits for all before it
  ASSERT_EQ(answered.size(), 301u);
  for (int i = 0; i < 300; ++i) EXPECT_EQ(answered[i], i + 1);
  EXPECT_EQ(answered[300], 1000);
}

TEST_F(Sessions, LowDiskRefusesGrowthButLetsThingsEnd) {
  ASSERT_TRUE(AppendTest(0, 0).ok());
  database.free_bytes = 1000;
  const absl::Status refused = AppendTest(1, 1);
  EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
  EXPECT_EQ(base::ErrorReason(refused), "DISK_LOW");
  EXPECT_EQ(base::ErrorReason(database->CreateSession(TestSession("")).status()), "DISK_LOW");
  EXPECT_TRUE(database->FinishSession(id, Totals(1)).ok());
  EXPECT_TRUE(database->ReadSession(id).ok());
}

class Retention : public testing::Test {
 protected:
  Retention() { DEMAND(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok()); }
  static std::chrono::hours days(int count) { return std::chrono::hours(24 * count); }
  SessionId Store(const std::string& request_id, int chunks) {
    const SessionId id = database->CreateSession(TestSession(request_id))->id;
    std::vector<uint32_t> crcs;
    for (int seq = 0; seq < chunks; ++seq) {
      crcs.push_back(session::ChunkCrc32c(TestColumns(seq, 10)));
      DEMAND(Append(*database, id, seq, TestColumns(seq, 10)).ok());
    }
    DEMAND(database->FinishSession(id, {chunks, chunks * 10, session::SessionHash(crcs)}).ok());
    return id;
  }
  void Mark() { DEMAND(database->ExpireSessions(days(1000)).ok()); }

  TempDatabase database;
};

// Readings go by age; a calibration keeps those that it stands on, a job those of its machine.
TEST_F(Retention, RemovesOldReadingsThatNothingStandsOn) {
  const SessionId kept = Store("kept", 2), old = Store("old", 450);
  NewCalibration calibration = TestCalibration(database.clock.UtcNow(), 1.0);
  calibration.sessions = {kept};
  ASSERT_TRUE(database->CreateCalibration(calibration).ok());
  Mark();
  database.clock.Advance(days(1));
  Mark();
  const SessionId young = Store("young", 1);
  database.clock.Advance(days(9));
  EXPECT_EQ(*database->ExpireReadings(days(11)), 0);
  NewJob job;
  job.kind = "identify";
  job.machine = MachineId("mt");
  job.caller = Cell("");
  const JobId id = database->CreateJob(job, 10)->id;
  EXPECT_EQ(*database->ExpireReadings(days(9)), 0);
  ASSERT_TRUE(database->CancelJob(id, Cell("")).ok());
  EXPECT_EQ(*database->ExpireReadings(days(9)), 1);
  EXPECT_EQ(*database->ExpireReadings(days(9)), 0);
  const SessionRecord expired = *database->GetSession(old);
  EXPECT_EQ(expired.state, SessionState::kExpired);
  EXPECT_EQ(expired.next_seq, 0);
  EXPECT_EQ(expired.reading_count, 0);
  EXPECT_EQ(base::ErrorReason(database->ReadSession(old).status()), "SESSION_NOT_COMPLETE");
  EXPECT_TRUE(database->ReadSession(kept).ok());
  EXPECT_TRUE(database->ReadSession(young).ok());
  const auto told = database->ListAudit({{}, {}, "", absl::StrCat("sessions/", old.number())}, {});
  ASSERT_EQ(told->rows.size(), 1u);
  EXPECT_EQ(told->rows[0].action, "session.expire");
  // The same can be sent again, as a new session.
  EXPECT_NE(database->CreateSession(TestSession("old"))->id, old);
  database.Close();
  const CheckReport report = database.Check();
  EXPECT_EQ(report.damage_count, 0) << report.damages[0].text;
}

TEST_F(Retention, TheFileItselfKeepsWhatACalibrationStandsOn) {
  const SessionId kept = Store("kept", 2);
  NewCalibration calibration = TestCalibration(database.clock.UtcNow(), 1.0);
  calibration.sessions = {kept};
  ASSERT_TRUE(database->CreateCalibration(calibration).ok());
  EXPECT_FALSE(database.Beside()->Execute("UPDATE session SET state = 4, hash = NULL").ok());
}

}  // namespace
}  // namespace axiscal::storage
