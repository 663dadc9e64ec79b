#include "server/storage/audit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const Caller kAnn = {"ann", "", "ipv4:192.0.2.7"};

class Audit : public testing::Test {
 protected:
  void SetUp() override {
    for (const std::string machine : {"a", "b", "c", "d"}) {
      database_.clock.Advance(std::chrono::hours(1));
      ASSERT_TRUE(database_->CreateMachine(MachineId(machine), "{}", machine == "c" ? Cell("") : kAnn).ok());
    }
  }
  // What somebody with the file does to it, past the triggers; then what the check says.
  absl::Status CheckAfter(const std::string& sql) {
    database_.Close();
    {
      const std::unique_ptr<Connection> connection = database_.PastGuards();
      const absl::Status done = connection->Execute(sql);
      EXPECT_TRUE(done.ok()) << done;
    }
    database_.Open();
    return database_->CheckAudit().status();
  }
  std::vector<std::string> Resources(const AuditFilter& filter, int page_size = 0) {
    std::vector<std::string> resources;
    PageRequest page{page_size, ""};
    do {
      const auto entries = database_->ListAudit(filter, page);
      EXPECT_TRUE(entries.ok()) << entries.status();
      if (!entries.ok()) break;
      for (const AuditEntry& entry : entries->rows) resources.push_back(entry.resource);
      page.token = entries->next_token;
    } while (!page.token.empty());
    return resources;
  }

  TempDatabase database_;
};

TEST_F(Audit, HoldsTheReasonAndTheRequest) {
  Caller caller = kAnn;
  caller.reason = "the spindle was changed";
  ASSERT_TRUE(database_->DeleteMachine(MachineId("a"), 0, caller).ok());
  EXPECT_EQ(database_->ListAudit({}, {})->rows[0].detail, "reason: the spindle was changed");
  caller.request_id = "r-7";
  ASSERT_TRUE(database_->DeleteMachine(MachineId("b"), 0, caller).ok());
  EXPECT_EQ(database_->ListAudit({}, {})->rows[0].detail, "request_id r-7; reason: the spindle was changed");
}

TEST_F(Audit, IsAChainThatGoesOnAfterARestart) {
  const auto before = database_->CheckAudit();
  ASSERT_TRUE(before.ok()) << before.status();
  EXPECT_EQ(before->id, 4);
  EXPECT_EQ(before->sha256.size(), 64u);
  database_.Close();
  database_.Open();
  EXPECT_EQ(database_->CheckAudit()->sha256, before->sha256);
  ASSERT_TRUE(database_->DeleteMachine(MachineId("a"), 0, kAnn).ok());
  EXPECT_EQ(database_->CheckAudit()->id, 5);
  EXPECT_NE(database_->CheckAudit()->sha256, before->sha256);
}

TEST_F(Audit, AChangedRowIsNamed) {
  for (const std::string column : {"principal", "peer", "action", "resource", "outcome", "was", "became", "detail"}) {
    const absl::Status damaged = CheckAfter("UPDATE audit SET " + column + " = " + column + " || 'x' WHERE id = 2");
    EXPECT_EQ(base::ErrorReason(damaged), "AUDIT_DAMAGED") << column;
    EXPECT_EQ(damaged.message(), "audit entry 2: is not what was written") << column;
    EXPECT_TRUE(CheckAfter("UPDATE audit SET " + column + " = substr(" + column + ", 1, length(" + column +
                           ") - 1) WHERE id = 2")
                    .ok())
        << column;
  }
  EXPECT_THAT(CheckAfter("UPDATE audit SET at_utc_us = at_utc_us + 1 WHERE id = 3").message(), HasSubstr("entry 3"));
}

// A list holds what was written or says that it is gone; one damaged entry hides no other.
TEST_F(Audit, AChangedRowIsNotShown) {
  const std::vector<AuditEntry> before = database_->ListAudit({}, {})->rows;
  ASSERT_EQ(before.size(), 4u);
  EXPECT_FALSE(CheckAfter("UPDATE audit SET principal = 'eve', became = 'nothing' WHERE id = 2").ok());
  const auto after = database_->ListAudit({}, {});
  ASSERT_TRUE(after.ok()) << after.status();
  ASSERT_EQ(after->rows.size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    const AuditEntry& entry = after->rows[i];
    EXPECT_EQ(entry.id, before[i].id);
    EXPECT_EQ(entry.at, before[i].at);
    if (entry.id != 2) {
      EXPECT_EQ(entry.principal, before[i].principal);
      EXPECT_EQ(entry.action, before[i].action);
      EXPECT_EQ(entry.became, before[i].became);
      continue;
    }
    EXPECT_EQ(entry.action, "damaged");
    EXPECT_EQ(entry.resource, "audit/2");
    EXPECT_EQ(entry.outcome, "DATA_LOSS");
    EXPECT_THAT(entry.detail, HasSubstr("AUDIT_DAMAGED"));
    EXPECT_EQ(entry.principal + entry.peer + entry.was + entry.became, "");
  }
  // Without its link the one behind it cannot be told from a forged one.
  EXPECT_FALSE(CheckAfter("DELETE FROM audit_chain WHERE audit_id = 3").ok());
  EXPECT_THAT(Resources({}), ElementsAre("audit/4", "audit/3", "audit/2", "machines/a"));
}

TEST_F(Audit, AHashThatWasMadeToFitBreaksTheNext) {
  EXPECT_THAT(CheckAfter("UPDATE audit_chain SET sha256 = 'x' WHERE audit_id = 2").message(), HasSubstr("entry 2"));
}

TEST_F(Audit, AMissingRowIsNamed) {
  EXPECT_EQ(CheckAfter("DELETE FROM audit WHERE id = 2; DELETE FROM audit_chain WHERE audit_id = 2").message(),
            "audit entry 2: is missing");
}

TEST_F(Audit, AMissingEndIsNamed) {
  EXPECT_EQ(CheckAfter("DELETE FROM audit WHERE id = 4").message(), "audit entry 4: is missing");
  EXPECT_EQ(CheckAfter("DELETE FROM audit_chain WHERE audit_id = 4").message(), "audit entry 4: is missing");
}

// A chain that is gone is not made anew for what is there.
TEST_F(Audit, AMissingChainIsNoticed) {
  EXPECT_EQ(CheckAfter("DELETE FROM audit_chain").message(), "audit entry 1: is not what was written");
}

TEST_F(Audit, AgeRemovesTheOldestAndKeepsTheAnchor) {
  const auto days = [](int count) { return std::chrono::hours(24 * count); };
  const auto keep_house = [&] { ASSERT_TRUE(database_->ExpireSessions(days(1000)).ok()); };
  keep_house();  // the first mark: after four entries
  for (int day = 0; day < 3; ++day) {
    database_.clock.Advance(days(1));
    ASSERT_TRUE(database_->UpdateMachine(MachineId("a"), 0, absl::StrCat("{\"day\":", day, "}"), kAnn).ok());
    keep_house();
  }
  EXPECT_EQ(*database_->ExpireAudit(days(4)), 0);
  EXPECT_EQ(database_->CheckAudit()->id, 7);
  EXPECT_EQ(*database_->ExpireAudit(days(2)), 5);
  EXPECT_EQ(*database_->ExpireAudit(days(2)), 0);
  const auto head = database_->CheckAudit();
  ASSERT_TRUE(head.ok()) << head.status();
  EXPECT_EQ(head->id, 8);
  EXPECT_THAT(Resources({}), ElementsAre("audit", "machines/a", "machines/a"));
  const AuditEntry told = database_->ListAudit({{}, {}, "", "audit"}, {})->rows[0];
  EXPECT_EQ(told.action, "audit.expire");
  EXPECT_EQ(told.was, "entries 1 to 5");
  EXPECT_THAT(told.became, HasSubstr("entry 5 had the hash "));
  database_.Close();
  database_.Open();
  EXPECT_EQ(database_->CheckAudit()->id, 8);
  // Whoever takes out the oldest rows by hand has no entry for it.
  EXPECT_THAT(
      CheckAfter("UPDATE audit_anchor SET audit_id = 6, sha256 = (SELECT sha256 FROM audit_chain WHERE audit_id "
                 "= 6); DELETE FROM audit_chain WHERE audit_id = 6; DELETE FROM audit WHERE id = 6")
          .message(),
      HasSubstr("entry 6: was not removed by retention"));
}

// A wall clock that jumps makes nothing old.
TEST_F(Audit, AgeIsTimeThatTheFileWasOpen) {
  ASSERT_TRUE(database_->ExpireSessions(std::chrono::hours(1)).ok());
  database_.clock.SetUtc(database_.clock.UtcNow() + std::chrono::hours(24 * 3650));
  ASSERT_TRUE(database_->ExpireSessions(std::chrono::hours(1)).ok());
  EXPECT_EQ(*database_->ExpireAudit(std::chrono::hours(24)), 0);
  EXPECT_EQ(database_->CheckAudit()->id, 4);
}

TEST_F(Audit, TriggersRefuseWhatTheProgramNeverDoes) {
  database_.Close();
  const std::unique_ptr<Connection> connection = database_.Beside();
  for (const std::string sql : {"UPDATE audit_chain SET sha256 = ''", "DELETE FROM audit_chain", "DELETE FROM audit",
                                "UPDATE audit_anchor SET is_chained = 0", "DELETE FROM audit_anchor"})
    EXPECT_FALSE(connection->Execute(sql).ok()) << sql;
}

TEST_F(Audit, IsListedByPrincipalResourceAndTime) {
  EXPECT_THAT(Resources({}, 1), ElementsAre("machines/d", "machines/c", "machines/b", "machines/a"));
  EXPECT_THAT(Resources({{}, {}, "ann", ""}, 2), ElementsAre("machines/d", "machines/b", "machines/a"));
  EXPECT_THAT(Resources({{}, {}, "cell", ""}), ElementsAre("machines/c"));
  EXPECT_THAT(Resources({{}, {}, "", "machines/b"}), ElementsAre("machines/b"));
  EXPECT_THAT(Resources({{}, {}, "cell", "machines/b"}), IsEmpty());
  const UtcTime last = database_.clock.UtcNow();
  EXPECT_THAT(Resources({last - std::chrono::hours(2), last, "", ""}, 1), ElementsAre("machines/c", "machines/b"));
  EXPECT_THAT(Resources({last + std::chrono::hours(1), {}, "", ""}), IsEmpty());
}

TEST_F(Audit, SaysFromWhereAndWhatWasBeforeAndAfter) {
  NewCalibration calibration = TestCalibration(database_.clock.UtcNow(), 1.0);
  calibration.machine = MachineId("a");
  const CalibrationId first = database_->CreateCalibration(calibration)->id;
  const CalibrationId second = database_->CreateCalibration(calibration)->id;
  ASSERT_TRUE(database_->ApproveCalibration(first, 0, kAnn).ok());
  ASSERT_TRUE(database_->ApproveCalibration(second, 0, kAnn).ok());
  const auto entries = database_->ListAudit({{}, {}, "", absl::StrCat("calibrations/", second.number())}, {});
  ASSERT_TRUE(entries.ok());
  const AuditEntry& approved = entries->rows.front();
  EXPECT_EQ(approved.peer, "ipv4:192.0.2.7");
  EXPECT_EQ(approved.was, "candidate");
  EXPECT_EQ(approved.became, absl::StrCat("approved; calibrations/", first.number(), " retired"));
}

}  // namespace
}  // namespace axiscal::storage
