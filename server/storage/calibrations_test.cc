#include <gtest/gtest.h>

#include <limits>

#include "core/base/error_detail.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

class Calibrations : public testing::Test {
 protected:
  Calibrations() : session(StoreSession(*database, 1)) {}
  NewCalibration New(double ea0b_urad = -101.2) {
    NewCalibration calibration = TestCalibration(database.clock.UtcNow(), ea0b_urad);
    calibration.sessions = {session};
    return calibration;
  }

  TempDatabase database;
  SessionId session;
};

TEST_F(Calibrations, KeepWhatTheyAreMadeOf) {
  const auto made = database->CreateCalibration(New());
  ASSERT_TRUE(made.ok()) << made.status();
  database.Close();
  database.Open();
  const auto read = database->GetCalibration(made->id);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->version, 1);
  EXPECT_EQ(read->state, CalibrationState::kCandidate);
  EXPECT_EQ(read->content.sessions, std::vector<SessionId>{session});
  EXPECT_EQ(read->content.estimates, New().estimates);  // in their order
  EXPECT_EQ(read->content.model_json, "{\"EA0B\":1}");
  EXPECT_EQ(read->content.rms_after_um, 2.97);
  EXPECT_FALSE(read->content.condition.has_value());
  const auto list = database->ListCalibrations({MachineId("mt"), std::nullopt}, {});
  EXPECT_EQ(list->rows.at(0).content.estimates, New().estimates);
  EXPECT_EQ(list->rows.at(0).content.model_json, "");
}

TEST_F(Calibrations, ListsAreHeldToTimeAndSession) {
  const UtcTime start = database.clock.UtcNow();
  const CalibrationId first = database->CreateCalibration(New())->id;
  database.clock.Advance(std::chrono::hours(1));
  session = StoreSession(*database, 1);
  const CalibrationId second = database->CreateCalibration(New())->id;
  const auto ids = [&](const CalibrationFilter& filter) {
    std::vector<CalibrationId> found;
    const auto page = database->ListCalibrations(filter, {});
    for (const CalibrationRecord& row : page->rows) found.push_back(row.id);
    return found;
  };
  using Ids = std::vector<CalibrationId>;
  EXPECT_EQ(ids({{}, {}, {}, session}), Ids{second});
  EXPECT_EQ(ids({MachineId("mt"), {}, {{}, start + std::chrono::hours(1)}}), Ids{first});
  EXPECT_EQ(ids({{}, {}, {start, {}}}), (Ids{second, first}));
  EXPECT_EQ(ids({{}, CalibrationState::kApproved, {}, session}), Ids{});
  EXPECT_EQ(ids({{}, {}, {}, SessionId(99)}), Ids{});
}

// Nothing changes, and the second reason is not lost.
TEST_F(Calibrations, WhoApprovesOnceMoreIsHeard) {
  const CalibrationRecord made = *database->CreateCalibration(New());
  const auto approve = [&](const std::string& who, const std::string& why) {
    Caller caller = Cell("");
    caller.principal = who;
    caller.reason = why;
    return database->ApproveCalibration(made.id, 0, caller);
  };
  const auto said = [&] {
    std::vector<std::string> lines;
    AuditFilter of_it;
    of_it.resource = absl::StrCat("calibrations/", made.id.number());
    const auto page = database->ListAudit(of_it, {100, ""});
    EXPECT_TRUE(page.ok()) << page.status();
    if (!page.ok()) return lines;
    for (const AuditEntry& entry : page->rows)
      if (entry.action == "calibration.approve") lines.push_back(absl::StrCat(entry.principal, ": ", entry.detail));
    return lines;
  };
  ASSERT_TRUE(approve("ann", "after the service").ok());
  ASSERT_TRUE(approve("ann", "after the service").ok());  // repeated
  ASSERT_TRUE(approve("ann", "").ok());
  EXPECT_EQ(said(), std::vector<std::string>{"ann: reason: after the service"});
  EXPECT_EQ(approve("bob", "checked by a ball bar")->approved_by, "ann");
  EXPECT_EQ(said(), (std::vector<std::string>{"bob: reason: checked by a ball bar", "ann: reason: after the service"}));
}

TEST_F(Calibrations, WhatWasDecidedStandsWithItsReason) {
  const CalibrationRecord made = *database->CreateCalibration(New());
  EXPECT_TRUE(database->ListDecisions(made.id, 20)->empty());
  Caller ann = Cell("");
  ann.principal = "ann";
  ann.reason = "better at B = 90; reason: see the ball bar";
  ASSERT_TRUE(database->ApproveCalibration(made.id, 0, ann).ok());
  ann.reason = "";
  ASSERT_TRUE(database->RetireCalibration(made.id, 0, ann).ok());
  Caller bob = Cell("");
  bob.principal = "bob";
  bob.reason = "back: it was the stylus";
  // What else is said of it stands between.
  for (int i = 0; i < 30; ++i) {
    AuditEntry entry;
    entry.action = i % 2 == 0 ? "table.make" : "denied Calibrations.ApproveCalibration";
    entry.resource = absl::StrCat("calibrations/", made.id.number());
    entry.detail = "reason: none of this is a decision";
    ASSERT_TRUE(database->AppendAudit(entry).ok());
  }
  bob.request_id = "r-1";
  ASSERT_TRUE(database->ApproveCalibration(made.id, 0, bob).ok());
  const auto decisions = database->ListDecisions(made.id, 20);
  ASSERT_TRUE(decisions.ok()) << decisions.status();
  std::vector<std::string> lines;
  for (const records::Decision& one : *decisions)
    lines.push_back(
        absl::StrCat(one.by, one.became == CalibrationState::kApproved ? " approved: " : " retired: ", one.reason));
  EXPECT_EQ(lines, (std::vector<std::string>{"bob approved: back: it was the stylus", "ann retired: ",
                                             "ann approved: better at B = 90; reason: see the ball bar"}));
  EXPECT_EQ(database->ListDecisions(made.id, 1)->size(), 1u);
}

TEST_F(Calibrations, OnlyOneIsApproved) {
  const CalibrationRecord first = *database->CreateCalibration(New());
  const CalibrationRecord second = *database->CreateCalibration(New());
  EXPECT_EQ(second.version, 2);
  EXPECT_EQ(base::ErrorReason(database->GetApprovedCalibration(MachineId("mt")).status()), "CALIBRATION_NOT_FOUND");
  ASSERT_TRUE(database->ApproveCalibration(first.id, first.etag, Cell("")).ok());
  ASSERT_TRUE(database->ApproveCalibration(second.id, second.etag, Cell("")).ok());
  EXPECT_EQ(database->GetApprovedCalibration(MachineId("mt"))->id, second.id);
  EXPECT_EQ(database->GetCalibration(first.id)->state, CalibrationState::kRetired);
  EXPECT_TRUE(database->ApproveCalibration(second.id, second.etag, Cell("")).ok());  // repeated
  // The way back.
  EXPECT_EQ(database->ApproveCalibration(first.id, 0, Cell(""))->approved_by, "cell");
  EXPECT_EQ(database->GetCalibration(second.id)->state, CalibrationState::kRetired);
  ASSERT_TRUE(database->RetireCalibration(first.id, 0, Cell("")).ok());
  EXPECT_TRUE(absl::IsNotFound(database->GetApprovedCalibration(MachineId("mt")).status()));
}

TEST_F(Calibrations, TheFormerOfOneIsWhatItTookThePlaceOf) {
  std::vector<CalibrationId> ids;
  for (int i = 0; i < 4; ++i) ids.push_back(database->CreateCalibration(New())->id);
  EXPECT_EQ(*database->GetFormerOf(ids[0]), std::nullopt);
  for (const int i : {0, 2, 1}) {
    database.clock.Advance(std::chrono::hours(1));
    ASSERT_TRUE(database->ApproveCalibration(ids[i], 0, Cell("")).ok());
  }
  EXPECT_EQ(*database->GetFormerOf(ids[0]), std::nullopt);
  EXPECT_EQ(*database->GetFormerOf(ids[2]), ids[0]);
  EXPECT_EQ(*database->GetFormerOf(ids[1]), ids[2]);
  EXPECT_EQ(*database->GetFormerOf(ids[3]), ids[1]);  // a candidate: it would
  ASSERT_TRUE(database->RetireCalibration(ids[1], 0, Cell("")).ok());
  EXPECT_EQ(*database->GetFormerOf(ids[3]), std::nullopt);  // none is in use
  EXPECT_EQ(base::ErrorReason(database->GetFormerOf(CalibrationId(99)).status()), "CALIBRATION_NOT_FOUND");
}

TEST_F(Calibrations, ApprovingAnOldStateIsRefused) {
  const CalibrationRecord made = *database->CreateCalibration(New());
  ASSERT_TRUE(database->RetireCalibration(made.id, 0, Cell("")).ok());
  EXPECT_EQ(base::ErrorReason(database->ApproveCalibration(made.id, made.etag, Cell("")).status()), "ETAG_MISMATCH");
}

TEST_F(Calibrations, ApprovingInThePlaceOfAnotherThanIsInUseIsRefused) {
  const CalibrationId judged = database->CreateCalibration(New())->id;
  const CalibrationId faster = database->CreateCalibration(New())->id;
  const CalibrationId late = database->CreateCalibration(New())->id;
  const auto approve = [&](CalibrationId id, std::optional<CalibrationId> former) {
    return database->ApproveCalibration(id, 0, former, Cell("")).status();
  };
  const absl::Status none = approve(late, judged);
  EXPECT_TRUE(absl::IsAborted(none)) << none;
  EXPECT_EQ(base::ErrorReason(none), "ETAG_MISMATCH");
  ASSERT_TRUE(approve(judged, std::nullopt).ok());
  ASSERT_TRUE(approve(faster, judged).ok());
  const absl::Status other = approve(late, judged);
  EXPECT_EQ(base::ErrorReason(other), "ETAG_MISMATCH");
  EXPECT_EQ(other.message(), "calibration 3 was judged against calibration 1; now calibration 2 is in use");
  EXPECT_EQ(database->GetApprovedCalibration(MachineId("mt"))->id, faster);
  EXPECT_EQ(database->GetCalibration(late)->state, CalibrationState::kCandidate);
  EXPECT_TRUE(approve(faster, judged).ok());  // repeated
  EXPECT_TRUE(approve(late, faster).ok());
}

TEST_F(Calibrations, BadOnesAreRefusedWhole) {
  const auto reason = [&](auto change) {
    NewCalibration calibration = New();
    change(calibration);
    return base::ErrorReason(database->CreateCalibration(calibration).status());
  };
  EXPECT_EQ(reason([](NewCalibration& c) { c.estimates[0].value = std::numeric_limits<double>::quiet_NaN(); }),
            "CALIBRATION_INVALID");
  EXPECT_EQ(reason([](NewCalibration& c) { c.estimates[2].value = 1.0; }), "CALIBRATION_INVALID");
  EXPECT_EQ(reason([](NewCalibration& c) { c.estimates[0].value.reset(); }), "CALIBRATION_INVALID");
  EXPECT_EQ(reason([](NewCalibration& c) { c.estimates[0].sigma = -1.0; }), "CALIBRATION_INVALID");
  EXPECT_EQ(reason([](NewCalibration& c) { c.estimates[1].symbol = "EX0C"; }), "CALIBRATION_INVALID");
  EXPECT_EQ(reason([](NewCalibration& c) { c.machine_revision = 9; }), "MACHINE_NOT_FOUND");
  EXPECT_EQ(reason([](NewCalibration& c) { c.sessions = {SessionId(99)}; }), "SESSION_NOT_FOUND");
  const SessionId open = database->CreateSession(TestSession("open"))->id;
  EXPECT_EQ(reason([&](NewCalibration& c) { c.sessions = {open}; }), "SESSION_NOT_COMPLETE");
  EXPECT_TRUE(database->ListCalibrations({}, {})->rows.empty());
  EXPECT_TRUE(database->QueryDrift({MachineId("mt"), {}, UtcTime(), database.clock.UtcNow(), 10})->empty());
}

}  // namespace
}  // namespace axiscal::storage
