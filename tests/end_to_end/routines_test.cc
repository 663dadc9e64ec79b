// Routines over the wire and by the client: from sessions that come to a calibration that is proposed or approved.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>

#include "core/base/error_detail.h"
#include "tests/end_to_end/testing/job_fixture.h"
#include "tests/end_to_end/testing/routine_fixture.h"

namespace axiscal {
namespace {

using records::RoutineRun;
using records::RunState;
using records::Scope;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::ScatteredSession;

const MachineId kMt("mt");

class Routines : public testing::Job {
 protected:
  void SetUp() override {
    Job::SetUp();
    ASSERT_OK(client().CreatePrincipal("night", "routines"));
    ASSERT_OK(client().ChangeRole("night", {records::Role::kTechnician, {Scope::Kind::kMachine, "mt"}}, true));
  }
  static records::Routine Nightly() {
    records::Routine routine;
    routine.name = "nightly";
    routine.scope = {Scope::Kind::kMachine, "mt"};
    routine.principal = "night";
    routine.sessions = {"BX", "BY"};
    return routine;
  }
  // A set, other readings each time; the run that follows.
  RoutineRun Measure(unsigned seed, double ex0c_um = 0.0) {
    UploadSession(ScatteredSession("BX", seed, ex0c_um));
    UploadSession(ScatteredSession("BY", seed + 1000, ex0c_um));
    return testing::WaitForRun(client(), ++runs_);
  }
  std::string WhyNot(const records::Routine& routine) {
    const absl::Status status = client().PutRoutine(routine).status();
    return base::ErrorReason(status) + ": " + std::string(status.message());
  }

  size_t runs_ = 0;
};

TEST_F(Routines, ProposeThenApproveWhatMovesLittleAndNothingElse) {
  ASSERT_OK(client().ChangeRole("night", {records::Role::kApprover, {Scope::Kind::kMachine, "mt"}}, true));
  records::Routine routine = Nightly();
  routine.approve_within_um = 5;
  ASSERT_OK(client().PutRoutine(routine));
  const RoutineRun first = Measure(1);
  EXPECT_EQ(first.state, RunState::kProposed);
  EXPECT_THAT(first.text, HasSubstr("not approved: the first calibration is put in use by a person"));
  const auto candidate = client().GetCalibration(*first.calibration);
  ASSERT_OK(candidate);
  EXPECT_EQ(candidate->content.sessions, first.sessions);
  EXPECT_EQ(candidate->job, first.job);
  EXPECT_EQ(client().GetJob(*first.job)->created_by, "night");
  ASSERT_OK(client().ApproveCalibration(candidate->id, candidate->etag));

  const RoutineRun second = Measure(2);
  EXPECT_EQ(second.state, RunState::kApproved) << second.text;
  EXPECT_THAT(second.text, HasSubstr("over the measured positions the tool point moves by up to"));
  const auto in_use = client().GetApprovedCalibration(kMt);
  ASSERT_OK(in_use);
  EXPECT_EQ(in_use->id, second.calibration);
  EXPECT_EQ(in_use->approved_by, "night");

  const RoutineRun third = Measure(3, 20);
  EXPECT_EQ(third.state, RunState::kProposed) << third.text;
  EXPECT_THAT(third.text, HasSubstr(absl::StrCat("against calibration ", in_use->id.number(), ": EX0C +")));
  EXPECT_THAT(third.text, HasSubstr("more than the 5 um that it may approve"));
  EXPECT_EQ(client().GetApprovedCalibration(kMt)->id, in_use->id);
  // A person hears of it.
  bool is_told = false;
  ASSERT_OK(client().WatchEvents(kMt, 0, [&](const records::EventNews& news) {
    is_told = news.change && news.change->event.content.kind == records::EventKind::kRoutineProposes &&
              news.change->event.content.calibration == third.calibration;
    return !is_told;
  }));
  client::AuditFilter by_night;
  by_night.principal = "night";
  const auto audit = client().ListAudit(by_night);
  ASSERT_OK(audit);
  std::string text;
  for (const client::AuditEntry& entry : audit->rows)
    absl::StrAppend(&text, entry.action, " ", entry.resource, ": ", entry.detail, "\n");
  EXPECT_THAT(text, HasSubstr(absl::StrCat("calibration.approve calibrations/", in_use->id.number(),
                                           ": reason: routine nightly, run 2\n")));
}

// The history has what routines measure although nobody has approved it, and of people only what was approved.
TEST_F(Routines, StandInTheHistoryBeforeAnybodyApproves) {
  ASSERT_OK(client().PutRoutine(Nightly()));
  const RoutineRun run = Measure(1);
  ASSERT_EQ(run.state, RunState::kProposed) << run.text;
  const auto by_person = RunJob(records::IdentifyParams{kMt, {UploadSession(ScatteredSession("CX", 5))}, {}});
  ASSERT_EQ(by_person.state, records::JobState::kSucceeded);
  const auto counted = [&](bool counts_candidates) {
    const auto found = client().FindDrift({kMt, {}, counts_candidates});
    EXPECT_TRUE(found.ok()) << found.status();
    return found.ok() ? found->counted : std::vector<CalibrationId>();
  };
  EXPECT_EQ(counted(false), std::vector<CalibrationId>{*run.calibration});
  EXPECT_EQ(counted(true).size(), 2u);
  ASSERT_OK(client().RetireCalibration(*run.calibration, client().GetCalibration(*run.calibration)->etag));
  EXPECT_TRUE(counted(false).empty());
}

TEST_F(Routines, SayWhatAgreesAndNeverApproveWhereFourEyesAreAsked) {
  ASSERT_OK(client().PutRoutine(Nightly()));
  const RoutineRun first = Measure(1);
  const auto candidate = client().GetCalibration(*first.calibration);
  ASSERT_OK(client().ApproveCalibration(candidate->id, candidate->etag));
  const RoutineRun second = Measure(2);
  EXPECT_EQ(second.state, RunState::kAgrees) << second.text;
  ASSERT_OK(client().ChangeRole("night", {records::Role::kApprover, {Scope::Kind::kMachine, "mt"}}, true));
  ASSERT_OK(client().SetFourEyes(kMt, true));
  records::Routine routine = Nightly();
  routine.approve_within_um = 1000;
  ASSERT_OK(client().PutRoutine(routine, 1));
  const RoutineRun third = Measure(3);
  EXPECT_EQ(third.state, RunState::kProposed);
  EXPECT_THAT(third.text, HasSubstr("machine mt asks for the eyes of a person"));
  EXPECT_EQ(client().GetApprovedCalibration(kMt)->id, candidate->id);
}

TEST_F(Routines, SurviveARestartAndAreStoppedAndTriedAgain) {
  ASSERT_OK(client().CreatePrincipal("weak"));
  records::Routine routine = Nightly();
  routine.principal = "weak";  // it has no role
  ASSERT_OK(client().PutRoutine(routine));
  Restart();
  EXPECT_EQ(Measure(1).state, RunState::kFailed);
  EXPECT_EQ(base::ErrorReason(client().RetryRoutine("other", kMt).status()), "ROUTINE_NOT_FOUND");
  ASSERT_OK(client().PutRoutine(Nightly()));
  ASSERT_OK(client().RetryRoutine("nightly", kMt));
  EXPECT_EQ(testing::WaitForRun(client(), ++runs_).state, RunState::kProposed);
  EXPECT_EQ(base::ErrorReason(client().RetryRoutine("nightly", kMt).status()), "RUN_NOT_FAILED");
  const auto stopped = client().StopRoutine("nightly", kMt, true, "the probe is loose");
  ASSERT_OK(stopped);
  EXPECT_EQ(stopped->stops.at(0).note, "the probe is loose");
  Restart();
  EXPECT_EQ(client().ListRoutines(kMt)->at(0).stops.size(), 1u);
  UploadSession(ScatteredSession("BX", 7));
  UploadSession(ScatteredSession("BY", 8));
  ASSERT_OK(client().StopRoutine("nightly", kMt, false));
  EXPECT_EQ(testing::WaitForRun(client(), ++runs_).state, RunState::kProposed);
  ASSERT_OK(client().RemoveRoutine("nightly"));
  EXPECT_TRUE(client().ListRoutines()->empty());
  EXPECT_EQ(client().ListRoutineRuns()->rows.size(), runs_);
}

TEST_F(Routines, WhatCannotBeMeantIsRefused) {
  const auto refused = [&](const std::function<void(records::Routine&)>& spoil, const std::string& text) {
    records::Routine routine = Nightly();
    spoil(routine);
    EXPECT_THAT(WhyNot(routine), HasSubstr(text));
  };
  refused([](auto& routine) { routine.name = "a b"; }, "FIELD_INVALID: routine.name: 'a b', must be 1 to 64 letters");
  refused([](auto& routine) { routine.scope = {}; }, "routine.scope: must be a machine or a group");
  refused([](auto& routine) { routine.scope.name = "none"; }, "MACHINE_NOT_FOUND");
  refused([](auto& routine) { routine.scope = {Scope::Kind::kGroup, "g"}; }, "GROUP_NOT_FOUND: group g does not exist");
  refused([](auto& routine) { routine.principal = "nobody"; }, "PRINCIPAL_NOT_FOUND: principal nobody does not exist");
  refused([](auto& routine) { routine.sessions = {}; }, "routine.sessions");
  refused([](auto& routine) { routine.sessions = {"BX", "BX"}; }, "routine.sessions[1]: BX stands twice");
  refused([](auto& routine) { routine.check_sessions = {"CX"}; }, "routine.check_sessions: must be empty");
  refused([](auto& routine) { routine.within_hours = 9000; }, "routine.within_hours: 9000, must be 1 to 8760");
  refused([](auto& routine) { routine.at_utc_minute = 1440; }, "routine.at_utc_minute: 1440, must be 0 to 1439");
  refused([](auto& routine) { routine.max_effects = 3; }, "routine.max_effects: must not be set");
  refused([](auto& routine) { routine.monte_carlo_runs = 0; }, "routine.monte_carlo_runs: 0, must be 1 to");
  refused([](auto& routine) { routine.approve_within_um = -1; }, "routine.approve_within_um: -1, must be > 0");
  refused(
      [](auto& routine) {
        routine.work = records::RoutineWork::kLoop;
        routine.check_sessions = {"BX"};
      },
      "routine.check_sessions[0]: BX stands twice");
  // Each run would fail.
  refused([](auto& routine) { routine.declared = {"EX0C", "EX0Q"}; }, "FIELD_INVALID: routine.declared_errors[1]: ");
  refused([](auto& routine) { routine.budget_json = R"({"nonsense": 1})"; }, "FIELD_INVALID: routine.budget_json: ");
  EXPECT_TRUE(client().ListRoutines()->empty());
}

}  // namespace
}  // namespace axiscal
