#include "server/storage/session_remarks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "core/session/checksum.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class SessionRemarks : public testing::Test {
 protected:
  SessionRemarks() { DEMAND(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok()); }

  SessionId Open() { return database->CreateSession(TestSession(""))->id; }
  SessionId Store() {
    const SessionId id = Open();
    const std::vector<session::Column> columns = TestColumns(0, 10);
    DEMAND(Append(*database, id, 0, columns).ok());
    DEMAND(database->FinishSession(id, {1, 10, session::SessionHash({session::ChunkCrc32c(columns)})}).ok());
    return id;
  }
  CalibrationId Calibrate(const std::vector<SessionId>& sessions) {
    NewCalibration calibration;
    calibration.machine = MachineId("mt");
    calibration.machine_revision = 1;
    calibration.sessions = sessions;
    calibration.measured_at = database.clock.UtcNow();
    calibration.options_json = calibration.report_json = calibration.model_json = "{}";
    calibration.created_by = "test";
    return database->CreateCalibration(calibration)->id;
  }

  TempDatabase database;
};

TEST_F(SessionRemarks, ANoteAndLabelsStayOverARestartAndListsFindThem) {
  const SessionId id = Store(), other = Store();
  EXPECT_FALSE(database->GetSession(id)->remark.has_value());
  const auto said = database->AnnotateSession(id, "behind the crash", {"warm", "after-crash"}, 0, {"bob", ""});
  ASSERT_TRUE(said.ok()) << said.status();
  database.Close();
  database.Open();
  const SessionRecord session = *database->GetSession(id);
  ASSERT_TRUE(session.remark.has_value());
  EXPECT_EQ(session.remark->note, "behind the crash");
  EXPECT_THAT(session.remark->labels, ElementsAre("after-crash", "warm"));
  EXPECT_EQ(session.remark->changed_by, "bob");
  EXPECT_FALSE(session.is_rejected());
  SessionFilter filter;
  filter.label = "warm";
  const auto page = database->ListSessions(filter, {});
  ASSERT_EQ(page->rows.size(), 1u);
  EXPECT_EQ(page->rows[0].id, id);
  EXPECT_EQ(page->rows[0].remark->note, "behind the crash");
  filter.label = "cold";
  EXPECT_TRUE(database->ListSessions(filter, {})->rows.empty());
  const auto audit = database->ListAudit({})->rows[0];
  EXPECT_EQ(audit.action, "session.annotate");
  EXPECT_EQ(audit.became, "[warm after-crash] behind the crash");
  EXPECT_FALSE(database->GetSession(other)->remark.has_value());
}

TEST_F(SessionRemarks, WhoReadAnOlderOneReplacesNothing) {
  const SessionId id = Store();
  const int64_t etag = database->AnnotateSession(id, "a", {}, 0, Cell(""))->remark->etag;
  ASSERT_TRUE(database->AnnotateSession(id, "b", {}, etag, Cell("")).ok());
  EXPECT_EQ(base::ErrorReason(database->AnnotateSession(id, "c", {}, etag, Cell("")).status()), "ETAG_MISMATCH");
  EXPECT_EQ(database->GetSession(id)->remark->note, "b");
  EXPECT_EQ(base::ErrorReason(database->AnnotateSession(Open(), "", {}, 0, Cell("")).status()), "SESSION_NOT_COMPLETE");
  EXPECT_EQ(base::ErrorReason(database->AnnotateSession(SessionId(99), "", {}, 0, Cell("")).status()),
            "SESSION_NOT_FOUND");
}

TEST_F(SessionRemarks, WhatStandsOnARejectedSessionIsMarkedAndCannotBeApproved) {
  const SessionId bad = Store(), good = Store();
  const CalibrationId both = Calibrate({good, bad}), one = Calibrate({good});
  const auto rejected = database->RejectSession(bad, true, "the probe was loose", {"bob", ""});
  ASSERT_TRUE(rejected.ok()) << rejected.status();
  EXPECT_THAT(rejected->calibrations, ElementsAre(both));
  EXPECT_TRUE(rejected->session.is_rejected());
  EXPECT_EQ(rejected->session.remark->reason, "the probe was loose");
  EXPECT_THAT(database->GetCalibration(both)->rejected_sessions, ElementsAre(bad));
  EXPECT_THAT(database->ListCalibrations({}, {})->rows[1].rejected_sessions, ElementsAre(bad));
  EXPECT_TRUE(database->GetCalibration(one)->rejected_sessions.empty());
  const absl::Status refused = database->ApproveCalibration(both, 0, Cell("")).status();
  EXPECT_EQ(base::ErrorReason(refused), "SESSION_REJECTED");
  EXPECT_THAT(std::string(refused.message()), HasSubstr("stands on session 1"));
  EXPECT_TRUE(database->ApproveCalibration(one, 0, Cell("")).ok());
  // The first word stays; a note does not end it.
  ASSERT_TRUE(database->RejectSession(bad, true, "again", Cell("")).ok());
  ASSERT_TRUE(database->AnnotateSession(bad, "seen", {}, 0, Cell("")).ok());
  EXPECT_EQ(database->GetSession(bad)->remark->reason, "the probe was loose");
  EXPECT_TRUE(database->GetSession(bad)->is_rejected());
  // It counts again.
  ASSERT_TRUE(database->RejectSession(bad, false, "it was the cable", Cell("")).ok());
  EXPECT_TRUE(database->ApproveCalibration(both, 0, Cell("")).ok());
  EXPECT_FALSE(database->GetSession(bad)->is_rejected());
}

TEST_F(SessionRemarks, ASessionThatDoesNotCountHasNotCome) {
  const SessionId id = Store();
  const std::string name = database->GetSession(id)->name;
  EXPECT_TRUE(database->NewestSession(MachineId("mt"), name)->has_value());
  ASSERT_TRUE(database->RejectSession(id, true, "loose", Cell("")).ok());
  EXPECT_FALSE(database->NewestSession(MachineId("mt"), name)->has_value());
}

}  // namespace
}  // namespace axiscal::storage
