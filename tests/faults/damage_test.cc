// Bits that flip on the disk: never other readings, always an error that says where.
#include <gtest/gtest.h>

#include <random>

#include "core/base/error_detail.h"
#include "core/base/sha256.h"
#include "server/storage/sqlite_connection.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

class Damage : public testing::Test {
 protected:
  // Changes rows behind the store's back, as a disk may.
  void Execute(const std::string& sql) {
    const auto connection = SqliteConnection::Open(database.path(), Access::kWrite);
    DEMAND(connection.ok());
    const absl::Status status = (*connection)->Execute(sql);
    ASSERT_TRUE(status.ok()) << status;
  }
  std::string ReadContent(const std::string& sql) {
    const auto connection = SqliteConnection::Open(database.path(), Access::kReadOnly);
    DEMAND(connection.ok());
    auto row = (*connection)->Ask(sql);
    DEMAND(row.ok() && row->Step().ok());
    return row->Text(0);
  }
  void WriteContent(const std::string& sql, const std::string& content) {
    const auto connection = SqliteConnection::Open(database.path(), Access::kWrite);
    DEMAND(connection.ok());
    const absl::Status status = (*connection)->Run(sql, Blob{content});
    ASSERT_TRUE(status.ok()) << status;
  }

  TempDatabase database;
  std::mt19937 random{7};
};

TEST_F(Damage, OfAChunkIsNoticedAndNamed) {
  const SessionId id = StoreSession(*database, 3);
  const session::Session good = *database->ReadSession(id);
  Execute("DROP TRIGGER chunk_is_never_changed");
  const std::string content = ReadContent("SELECT content FROM chunk WHERE seq = 1");
  for (int round = 0; round < 300; ++round) {
    std::string bad = content;
    bad[random() % bad.size()] ^= static_cast<char>(1 << random() % 8);
    WriteContent("UPDATE chunk SET content = ?1 WHERE seq = 1", bad);
    const absl::StatusOr<session::Session> read = database->ReadSession(id);
    // A bit that means nothing (a filler of the compressed stream) may flip; readings never differ.
    if (read.ok()) {
      ASSERT_EQ(*read, good);
      continue;
    }
    ASSERT_TRUE(absl::IsDataLoss(read.status())) << read.status();
    ASSERT_EQ(base::ErrorReason(read.status()), "CHUNK_DAMAGED");
    ASSERT_EQ(base::GetErrorDetail(read.status())->facts.at("seq"), "1");
  }
  WriteContent("UPDATE chunk SET content = ?1 WHERE seq = 1", content);
  EXPECT_EQ(*database->ReadSession(id), good);
}

TEST_F(Damage, AMissingChunkIsNoticed) {
  const SessionId id = StoreSession(*database, 3);
  Execute("DROP TRIGGER complete_session_keeps_its_chunks; DELETE FROM chunk WHERE seq = 2");
  EXPECT_EQ(base::GetErrorDetail(database->ReadSession(id).status())->facts.at("seq"), "2");
}

TEST_F(Damage, TheStoreItselfCannotChangeRawReadings) {
  StoreSession(*database, 1);
  const auto connection = SqliteConnection::Open(database.path(), Access::kWrite);
  EXPECT_FALSE((*connection)->Execute("UPDATE chunk SET crc32c = 0").ok());
  EXPECT_FALSE((*connection)->Execute("DELETE FROM chunk").ok());
  EXPECT_FALSE((*connection)->Execute("DELETE FROM audit").ok());
}

// One digit of what a calibration says, of whose description it was fitted to or of who may use it.
TEST_F(Damage, OfACalibrationIsNoticedAndNamed) {
  const SessionId session = StoreSession(*database, 1);
  NewCalibration content = TestCalibration(database.clock.UtcNow(), -101.2);
  content.sessions = {session};
  const CalibrationRecord made = *database->CreateCalibration(content);
  ASSERT_TRUE(database->ApproveCalibration(made.id, 0, Cell("")).ok());
  const auto expect_intact = [&](const std::string& after) {
    const auto read = database->GetApprovedCalibration(MachineId("mt"));
    ASSERT_TRUE(read.ok()) << after << ": " << read.status();
    EXPECT_EQ(read->content.estimates, content.estimates);
  };
  expect_intact("nothing");
  const std::pair<std::string, std::string> damages[] = {
      {"UPDATE estimate SET estimated_um_urad = 93.1 WHERE symbol = 'EX0C'", "SET estimated_um_urad = 53.1"},
      {"UPDATE estimate SET sigma_um_urad = 0.6 WHERE symbol = 'EX0C'", "SET sigma_um_urad = 0.5"},
      {"UPDATE estimate SET unit = 2 WHERE symbol = 'EX0C'", "SET unit = 1"},
      {"UPDATE estimate SET position = 7 WHERE symbol = 'EX0C'", "SET position = 0"},
      {"UPDATE calibration SET model_json = '{\"EA0B\":9}'", "SET model_json = '{\"EA0B\":1}'"},
      {"UPDATE calibration SET report_json = '{\"rank\":3}'", "SET report_json = '{\"rank\":2}'"},
      {"UPDATE calibration SET rank = 1", "SET rank = 2"},
      {"UPDATE calibration SET version = 2", "SET version = 1"},
      {"PRAGMA foreign_keys = OFF; UPDATE calibration SET machine_revision = 2", "SET machine_revision = 1"},
      {"UPDATE calibration SET rms_after_um = NULL", "SET rms_after_um = 2.97"},
      {"UPDATE machine_revision SET description_json = '{ }'", "SET description_json = '{}'"},
  };
  for (const auto& [damage, repair] : damages) {
    Execute(damage);
    const absl::Status approved = database->GetApprovedCalibration(MachineId("mt")).status();
    EXPECT_TRUE(absl::IsDataLoss(approved)) << damage << ": " << approved;
    EXPECT_EQ(base::ErrorReason(approved), "CALIBRATION_DAMAGED") << damage;
    EXPECT_NE(approved.message().find("calibration 1"), std::string::npos) << approved;
    EXPECT_TRUE(absl::IsDataLoss(database->GetCalibration(made.id).status())) << damage;
    EXPECT_TRUE(database->ListCalibrations({}, {}).ok()) << damage;  // one must not hide the others
    const size_t set = damage.find(" SET "), where = damage.find(" WHERE ");
    Execute(damage.substr(0, set) + " " + repair + (where == std::string::npos ? "" : damage.substr(where)));
    expect_intact(damage);
  }
}

TEST_F(Damage, DoesNotApproveACalibration) {
  StoreSession(*database, 1);
  const CalibrationRecord made = *database->CreateCalibration(TestCalibration(database.clock.UtcNow(), -101.2));
  Execute("UPDATE calibration SET state = 2");
  EXPECT_EQ(base::ErrorReason(database->GetApprovedCalibration(MachineId("mt")).status()), "CALIBRATION_DAMAGED");
  EXPECT_TRUE(database->RetireCalibration(made.id, 0, Cell("")).ok());
  EXPECT_TRUE(absl::IsNotFound(database->GetApprovedCalibration(MachineId("mt")).status()));
}

// The way out is another calibration; a damaged one is never approved, and what retires it does not make it good.
TEST_F(Damage, OfACalibrationDoesNotKeepAnotherFromBeingApproved) {
  StoreSession(*database, 1);
  const CalibrationRecord bad = *database->CreateCalibration(TestCalibration(database.clock.UtcNow(), -101.2));
  ASSERT_TRUE(database->ApproveCalibration(bad.id, 0, Cell("")).ok());
  const CalibrationRecord good = *database->CreateCalibration(TestCalibration(database.clock.UtcNow(), -90.0));
  Execute("UPDATE calibration SET model_json = 'x' WHERE id = 1");
  const auto approved = database->ApproveCalibration(good.id, 0, Cell(""));
  ASSERT_TRUE(approved.ok()) << approved.status();
  EXPECT_EQ(database->GetApprovedCalibration(MachineId("mt"))->id, good.id);
  EXPECT_EQ(base::ErrorReason(database->ApproveCalibration(bad.id, 0, Cell("")).status()), "CALIBRATION_DAMAGED");
  EXPECT_EQ(base::ErrorReason(database->GetCalibration(bad.id).status()), "CALIBRATION_DAMAGED");
  EXPECT_TRUE(database->GetApprovedCalibration(MachineId("mt")).ok());
}

TEST_F(Damage, OfAMachineIsNoticedAndMendedByAnotherDescription) {
  ASSERT_TRUE(database->CreateMachine(MachineId("mt"), "{\"pivot_mm\":120}", Cell("")).ok());
  Execute("UPDATE machine_revision SET description_json = '{\"pivot_mm\":920}'");
  for (const absl::Status& read :
       {database->GetMachine(MachineId("mt")).status(), database->GetMachineRevision(MachineId("mt"), 1).status()}) {
    EXPECT_TRUE(absl::IsDataLoss(read)) << read;
    EXPECT_EQ(base::ErrorReason(read), "MACHINE_DAMAGED");
  }
  EXPECT_TRUE(database->ListMachines({}).ok());
  const auto mended = database->UpdateMachine(MachineId("mt"), 1, "{\"pivot_mm\":120}", Cell(""));
  ASSERT_TRUE(mended.ok()) << mended.status();
  EXPECT_EQ(mended->revision, 2);
  EXPECT_TRUE(database->GetMachine(MachineId("mt")).ok());
}

TEST_F(Damage, OfASessionsHeaderIsNoticed) {
  const SessionId id = StoreSession(*database, 1);
  for (const std::string damage : {"UPDATE session_header SET text = '3.0' WHERE key = 'sigma_um'",
                                   "UPDATE session_header SET key = 'sigma' WHERE text = '3.0'"}) {
    Execute(damage);
    const absl::Status read = database->ReadSession(id).status();
    EXPECT_TRUE(absl::IsDataLoss(read)) << damage << ": " << read;
    EXPECT_EQ(base::ErrorReason(read), "SESSION_DAMAGED");
  }
}

// A session of three chunks under a request id; what its upload left.
class DamagedUpload : public Damage {
 protected:
  DamagedUpload() {
    DEMAND(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
    id = Create().id;
    Append(id, 3);
  }
  SessionRecord Create() {
    const absl::StatusOr<SessionRecord> session = database->CreateSession(TestSession("r-1"));
    DEMAND(session.ok());
    return *session;
  }
  void Append(SessionId to, int chunks) {
    for (int seq = 0; seq < chunks; ++seq) DEMAND(storage::Append(*database, to, seq, TestColumns(seq, 10)).ok());
  }
  absl::Status Finish(SessionId of) {
    std::vector<uint32_t> crcs;
    for (int seq = 0; seq < 3; ++seq) crcs.push_back(session::ChunkCrc32c(TestColumns(seq, 10)));
    return database->FinishSession(of, {3, 30, session::SessionHash(crcs)}).status();
  }
  // The same file again, as a client sends it: a new session, which is whole.
  void ExpectHealed(const std::string& damage) {
    const SessionRecord again = Create();
    EXPECT_NE(again.id, id) << damage;
    EXPECT_EQ(again.state, SessionState::kOpen) << damage;
    Append(again.id, 3);
    EXPECT_TRUE(Finish(again.id).ok()) << damage;
    EXPECT_TRUE(database->ReadSession(again.id).ok()) << damage;
    EXPECT_EQ(Create().id, again.id) << damage;
    const auto listed = database->ListSessions({}, {});
    ASSERT_TRUE(listed.ok()) << damage << ": " << listed.status();
    EXPECT_EQ(listed->rows.size(), 2u) << damage;
  }

  SessionId id;
};

TEST_F(DamagedUpload, WhatIsWholeIsNotStoredTwice) {
  EXPECT_EQ(Create().id, id);
  ASSERT_TRUE(Finish(id).ok());
  EXPECT_EQ(Create().id, id);
  EXPECT_TRUE(storage::Append(*database, id, 1, TestColumns(1, 10))->duplicate);
  EXPECT_TRUE(database.damages.empty());
}

TEST_F(DamagedUpload, OfReadingsIsHealedBySendingThemAgain) {
  ASSERT_TRUE(Finish(id).ok());
  Execute("DROP TRIGGER chunk_is_never_changed");
  std::string content = ReadContent("SELECT content FROM chunk WHERE seq = 1");
  content.resize(content.size() / 2);
  WriteContent("UPDATE chunk SET content = ?1 WHERE seq = 1", content);
  // Into the damaged session itself nothing goes.
  const absl::Status repeat = storage::Append(*database, id, 1, TestColumns(1, 10)).status();
  EXPECT_EQ(base::ErrorReason(repeat), "CHUNK_DAMAGED") << repeat;
  EXPECT_NE(repeat.message().find("send the session again"), std::string::npos) << repeat;
  EXPECT_TRUE(storage::Append(*database, id, 0, TestColumns(0, 10))->duplicate);
  ExpectHealed("content");
  ASSERT_FALSE(database.damages.empty());
  EXPECT_EQ(base::ErrorReason(database.damages[0]), "CHUNK_DAMAGED");
}

TEST_F(DamagedUpload, OfAChunksChecksumIsNoConflict) {
  ASSERT_TRUE(Finish(id).ok());
  Execute("DROP TRIGGER chunk_is_never_changed; UPDATE chunk SET crc32c = crc32c + 1 WHERE seq = 1");
  EXPECT_EQ(base::ErrorReason(storage::Append(*database, id, 1, TestColumns(1, 10)).status()), "CHUNK_DAMAGED");
  ExpectHealed("checksum");
}

TEST_F(DamagedUpload, OfAChunkThatIsGoneIsHealed) {
  ASSERT_TRUE(Finish(id).ok());
  Execute("DROP TRIGGER complete_session_keeps_its_chunks; DELETE FROM chunk WHERE seq = 1");
  ExpectHealed("row");
}

TEST_F(DamagedUpload, OfAnOpenSessionIsHealed) {
  Execute("DROP TRIGGER chunk_is_never_changed; UPDATE chunk SET content = CAST('x' AS BLOB) WHERE seq = 2");
  ExpectHealed("open");
}

TEST_F(DamagedUpload, OfItsColumnsIsHealed) {
  ASSERT_TRUE(Finish(id).ok());
  Execute("DELETE FROM session_column");
  const absl::Status read = database->GetSession(id).status();
  EXPECT_TRUE(absl::IsDataLoss(read)) << read;
  EXPECT_EQ(base::ErrorReason(read), "SESSION_DAMAGED");
  ExpectHealed("columns");
}

TEST_F(Damage, OfAJobsParamsIsNoticedBeforeItRuns) {
  NewJob job;
  job.kind = "compensate";
  job.params = "tool 120";
  job.caller = Cell("");
  const JobId id = database->CreateJob(job, 10)->id;
  Execute("UPDATE job SET params = CAST('tool 920' AS BLOB)");
  EXPECT_FALSE(database->ClaimJob(std::chrono::seconds(30))->has_value());
  const JobRecord failed = *database->GetJob(id);
  EXPECT_EQ(failed.state, JobState::kFailed);
  EXPECT_EQ(failed.error->code, absl::StatusCode::kDataLoss);
  EXPECT_EQ(failed.error->reason, "JOB_DAMAGED");
}

TEST_F(Damage, OfAJobsResultIsNoticedAndNamed) {
  std::vector<JobId> ids;
  for (const std::string result : {"wear_um 12.5", "wear_um 3.5"}) {
    NewJob job;
    job.kind = "tool_setter";
    job.caller = Cell("");
    ids.push_back(database->CreateJob(job, 10)->id);
    const auto claimed = database->ClaimJob(std::chrono::seconds(30));
    DEMAND(claimed.ok() && claimed->has_value());
    ASSERT_TRUE(database->SucceedJob(ClaimOf(**claimed), {result, {}, {}}).ok());
    EXPECT_EQ(database->GetJob(ids.back())->result, result);
  }
  for (const std::string damage :
       {"UPDATE job SET result = CAST('wear_um 2.5' AS BLOB) WHERE id = 1",
        "UPDATE job SET result_sha256 = '' WHERE id = 1",
        "UPDATE job SET (result, result_sha256) = (SELECT result, result_sha256 FROM job WHERE id = 2) WHERE id = 1"}) {
    Execute(damage);
    const absl::Status read = database->GetJob(ids[0]).status();
    EXPECT_TRUE(absl::IsDataLoss(read)) << damage << ": " << read;
    EXPECT_EQ(base::ErrorReason(read), "JOB_DAMAGED") << damage;
    EXPECT_EQ(base::GetErrorDetail(read)->facts.at("job"), "1") << damage;
    EXPECT_TRUE(database->GetJob(ids[1]).ok()) << damage;
    EXPECT_EQ(database->ListJobs({}, {})->rows.size(), 2u) << damage;  // one must not hide the others
  }
}

TEST_F(Damage, OfAProgramIsNoticed) {
  const ProgramId id = database->BeginProgram({"nc", "O1", Cell("")})->id;
  ASSERT_TRUE(database->AppendProgram(id, 0, "G01 X1.0000 Y2.0000 Z3.0000\n").ok());
  ASSERT_TRUE(database->FinishProgram(id, 28, "").ok());
  std::string content = ReadContent("SELECT content FROM program_part");
  content[content.size() - 3] ^= 1;
  WriteContent("UPDATE program_part SET content = ?1", content);
  const absl::Status read = database->ReadProgram(id, 0, [](const std::string&) { return absl::OkStatus(); });
  EXPECT_EQ(base::ErrorReason(read), "PART_DAMAGED") << read;
}

TEST_F(Damage, OfAProgramIsHealedByTheSameContent) {
  const std::string text = "G01 X1.0000 Y2.0000 Z3.0000\n";
  const auto put = [&](const std::string& request_id) {
    const auto begun = database->BeginProgram({"nc", "O1", Cell(request_id)});
    DEMAND(begun.ok());
    if (begun->state != ProgramState::kComplete) DEMAND(database->AppendProgram(begun->id, 0, text).ok());
    return database->FinishProgram(begun->id, static_cast<int64_t>(text.size()), base::Sha256Hex(text));
  };
  const ProgramId id = put("a")->id;
  EXPECT_EQ(put("a")->id, id);
  EXPECT_EQ(put("b")->id, id);
  EXPECT_TRUE(database.damages.empty());
  // Under its own request id and under another one.
  for (const std::string request_id : {"a", "c"}) {
    for (const std::string damage : {"UPDATE program_part SET content = CAST('x' AS BLOB)", "DELETE FROM program_part",
                                     "UPDATE program_part SET crc32c = 1"}) {
      Execute(damage);
      const auto again = put(request_id);
      ASSERT_TRUE(again.ok()) << damage << ": " << again.status();
      EXPECT_EQ(again->id, id) << damage;
      std::string all;
      const absl::Status read = database->ReadProgram(id, 0, [&](const std::string& bytes) {
        all += bytes;
        return absl::OkStatus();
      });
      EXPECT_TRUE(read.ok()) << damage << ": " << read;
      EXPECT_EQ(all, text) << damage;
      EXPECT_FALSE(std::exchange(database.damages, {}).empty()) << damage;
    }
  }
}

TEST_F(Damage, OfAProgramThatIsStillSentIsHealed) {
  const NewProgram program{"nc", "O1", Cell("a")};
  const ProgramId id = database->BeginProgram(program)->id;
  ASSERT_TRUE(database->AppendProgram(id, 0, "G01 X1.0000\n").ok());
  Execute("UPDATE program_part SET content = CAST('x' AS BLOB)");
  const ProgramRecord again = *database->BeginProgram(program);
  EXPECT_NE(again.id, id);
  EXPECT_EQ(again.byte_count, 0);
}

}  // namespace
}  // namespace axiscal::storage
