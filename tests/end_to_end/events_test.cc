// What is expected of machines and the events that follow, over the wire and by the client.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>

#include "core/base/error_detail.h"
#include "server/storage/sqlite_database.h"
#include "tests/end_to_end/testing/job_fixture.h"

namespace axiscal {
namespace {

using records::EventChangeKind;
using records::EventKind;
using ::testing::HasSubstr;

const MachineId kMt("mt");

class Events : public testing::Job {
 protected:
  // A calibration with EX0C = 30 +- 1 um, not approved.
  void StoreCalibration() {
    embedded_.reset();
    storage::SqliteOptions sqlite;
    sqlite.path = dir_.File("axiscal.db");
    auto database = storage::OpenSqlite(sqlite);
    ASSERT_OK(database);
    storage::NewCalibration calibration;
    calibration.machine = kMt;
    calibration.machine_revision = 1;
    calibration.measured_at = base::SystemClock().UtcNow();
    calibration.options_json = calibration.report_json = "{}";
    calibration.model_json = R"({"EX0C": 30})";
    calibration.estimates = {{"EX0C", records::EstimateUnit::kUm, true, 30.0, 1.0}};
    const auto stored = (*database)->CreateCalibration(calibration);
    ASSERT_OK(stored);
    calibration_ = stored->id;
    database->reset();
    Restart();
  }
  void ApproveIt() {
    const auto present = client().GetCalibration(calibration_);
    ASSERT_OK(present);
    const auto approved = client().ApproveCalibration(calibration_, present->etag);
    ASSERT_OK(approved);
  }
  // The next change after `after`, waited for.
  records::EventChange NextAfter(int64_t after) {
    records::EventChange change;
    const absl::Status watched = client().WatchEvents({}, after, [&](const records::EventNews& news) {
      if (news.change) change = *news.change;
      return !news.change.has_value();
    });
    EXPECT_TRUE(watched.ok()) << watched;
    return change;
  }

  CalibrationId calibration_;
};

TEST_F(Events, FollowFromWhatIsApprovedAndArePeoplesToAnswer) {
  ASSERT_NO_FATAL_FAILURE(StoreCalibration());
  const auto expected = client().SetExpectations({kMt, {{"EX0C", -20, 20}}, {}, {}, false});
  ASSERT_OK(expected);
  EXPECT_EQ(expected->etag, 1);
  EXPECT_EQ(expected->content.tolerances.at(0).high, 20);
  ASSERT_NO_FATAL_FAILURE(ApproveIt());
  const records::EventChange raised = NextAfter(0);
  EXPECT_EQ(raised.what, EventChangeKind::kRaised);
  EXPECT_EQ(raised.event.machine, kMt);
  EXPECT_EQ(raised.event.content.kind, EventKind::kOutOfTolerance);
  EXPECT_EQ(raised.event.content.calibration, calibration_);
  EXPECT_THAT(raised.event.content.text, HasSubstr("EX0C is 30 +- 1 um"));
  const EventId id = raised.event.id;

  EXPECT_EQ(base::ErrorReason(client().AcknowledgeEvent(id, "").status()), "FIELD_INVALID");
  const auto seen = client().AcknowledgeEvent(id, "service comes on Monday");
  ASSERT_OK(seen);
  EXPECT_EQ(seen->acknowledged_note, "service comes on Monday");
  EXPECT_THAT(seen->acknowledged_by, HasSubstr("local:"));
  const auto until = base::SystemClock().UtcNow() + std::chrono::hours(8);
  ASSERT_OK(client().ShelveEvent(id, until, "maintenance"));
  // The stream goes on behind a restart, where the caller stands.
  const records::EventChange acknowledged = NextAfter(raised.id);
  Restart();
  const records::EventChange shelved = NextAfter(acknowledged.id);
  EXPECT_EQ(acknowledged.what, EventChangeKind::kAcknowledged);
  EXPECT_EQ(acknowledged.note, "service comes on Monday");
  EXPECT_EQ(shelved.what, EventChangeKind::kShelved);
  EXPECT_EQ(shelved.note, "maintenance");

  ASSERT_OK(client().SetExpectations({kMt, {}, {}, {}, false}, 1));
  const records::EventChange cleared = NextAfter(shelved.id);
  EXPECT_EQ(cleared.what, EventChangeKind::kCleared);
  EXPECT_EQ(cleared.event.id, id);
  EXPECT_TRUE(client().ListEvents({kMt, true})->rows.empty());
  ASSERT_EQ(client().ListEvents()->rows.size(), 1u);
  EXPECT_TRUE(client().ListEvents()->rows[0].cleared_at.has_value());
}

// Of an error that no calibration will have nobody would ever hear.
TEST_F(Events, BeforeTheFirstCalibrationTolerancesAreOfErrorsThatTheMachineCanHave) {
  const auto refusal = [&](const std::string& symbol) {
    return std::string(client().SetExpectations({kMt, {{symbol, -20, 20}}, {}, {}, false}).status().message());
  };
  EXPECT_THAT(refusal("EX9Q"), HasSubstr("expectations.tolerances[0].symbol"));
  EXPECT_THAT(refusal("EX0Q"), HasSubstr("machine mt has no axis Q"));
  EXPECT_THAT(refusal("EXOC"), HasSubstr("EXOC: expected EX0C"));
  EXPECT_EQ(client().GetExpectations(kMt)->etag, 0);
  EXPECT_EQ(refusal("EX0C"), "");
  EXPECT_EQ(client().SetExpectations({kMt, {{"EXX:linear", -20, 20}}, {}, {}, false}, 1).status(), absl::OkStatus());
}

TEST_F(Events, WhatCannotBeAskedIsRefused) {
  ASSERT_NO_FATAL_FAILURE(StoreCalibration());
  const auto refused = [&](const records::Expectations& expected, const std::string& text) {
    const absl::Status status = client().SetExpectations(expected).status();
    EXPECT_EQ(base::ErrorReason(status), "FIELD_INVALID") << text;
    EXPECT_THAT(status.message(), HasSubstr(text));
  };
  refused({kMt, {{"EXOC", -20, 20}}, {}, {}, false}, "no calibration of machine mt has an error EXOC");
  refused({kMt, {{"EX0C", 20, -20}}, {}, {}, false}, "expectations.tolerances[0].low: must be less than high");
  refused({kMt, {{"EX0C", -1, 1}, {"EX0C", -2, 2}}, {}, {}, false}, "EX0C stands twice");
  refused({kMt, {}, 0, {}, false}, "calibration_days: 0, must be 1 to 3650");
  refused({kMt, {}, {}, {{"CR", 0}}, false}, "sessions[0].every_hours: 0, must be 1 to 87600");
  EXPECT_EQ(client().GetExpectations(kMt)->etag, 0);
  ASSERT_OK(client().SetExpectations({kMt, {}, 90, {}, false}));
  EXPECT_EQ(base::ErrorReason(client().SetExpectations({kMt, {}, 30, {}, false}, 7).status()), "ETAG_MISMATCH");
  EXPECT_EQ(client().GetExpectations(kMt)->content.calibration_days, 90);
  EXPECT_EQ(base::ErrorReason(client().WatchEvents({}, 5, nullptr)), "CHANGE_UNKNOWN");
  EXPECT_EQ(base::ErrorReason(client().WatchEvents(MachineId("none"), 0, nullptr)), "MACHINE_NOT_FOUND");
  EXPECT_EQ(base::ErrorReason(client().AcknowledgeEvent(EventId(9), "x").status()), "EVENT_NOT_FOUND");
}

}  // namespace
}  // namespace axiscal
