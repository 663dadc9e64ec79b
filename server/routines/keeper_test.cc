// Routines on a store of their own, with a kind of job that makes the calibration that the test wants.
#include "server/routines/keeper.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <thread>

#include "core/base/error_detail.h"
#include "core/records/job_params.h"
#include "core/reports/identification.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::routines {
namespace {

using records::RoutineRun;
using records::RunState;
using storage::Cell;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const MachineId kMt("mt");
constexpr char kMachineJson[] = R"({"id": "mt", "axes": {
  "X": {"kind": "linear", "direction": [1, 0, 0]}, "Y": {"kind": "linear", "direction": [0, 1, 0]},
  "Z": {"kind": "linear", "direction": [0, 0, 1]},
  "C": {"kind": "rotary", "direction": [0, 0, 1], "point_mm": [0, 0, 0]}},
 "tool_branch": ["Z", "Y", "X"], "work_branch": ["C"], "tool_direction": [0, 0, -1], "declared": ["EX0C"]})";

class Routines : public testing::Test {
 protected:
  Routines() {
    DEMAND(database->CreateMachine(kMt, kMachineJson, Cell("")).ok());
    DEMAND(database->CreatePrincipal("night", "", Cell("")).ok());
    Grant(records::Role::kTechnician);
    StartRunner();
  }
  void Grant(records::Role role, bool holds = true) {
    const records::Grant grant = {role, {records::Scope::Kind::kMachine, "mt"}};
    DEMAND(database->ChangeRole("night", grant, holds, Cell("")).ok());
  }
  void StartRunner() {
    jobs::JobRunnerOptions options;
    options.clock = &database.clock;
    options.workers = 1;
    runner = std::make_unique<jobs::JobRunner>(*database, options);
    runner->Register(records::kIdentify, {[this](const records::JobRecord& job, jobs::JobContext& context) {
                       return Identify(job, context);
                     }});
    runner->Start();
    KeeperOptions keep;
    keep.clock = &database.clock;
    keep.tell = [this](const MachineId&, const std::string& routine, const absl::Status& status) {
      told.push_back(routine + ": " + std::string(status.message()));
    };
    keep.judge = [this](storage::Database& stored, const records::CalibrationRecord& candidate) {
      return judge ? judge(stored, candidate) : Judge(stored, candidate);
    };
    gate = std::make_unique<access::Gate>(*database, true);
    keeper = std::make_unique<Keeper>(*database, *runner, *gate, keep);
  }
  // A server that stops, or is killed after its last write, and another one on the same file.
  void Restart() {
    keeper.reset();
    runner.reset();
    gate.reset();
    database.Close();
    database.Open();
    StartRunner();
  }
  absl::StatusOr<storage::JobProduct> Identify(const records::JobRecord& job, jobs::JobContext& context) {
    while (is_held && !context.cancelled()) std::this_thread::yield();
    if (context.cancelled()) return absl::CancelledError("told to stop");
    if (fails) return absl::InvalidArgumentError("the readings do not fit");
    storage::JobProduct product;
    product.result = "{}";
    product.calibration = Calibration(job.created_by);
    return product;
  }
  storage::NewCalibration Calibration(const std::string& by) {
    storage::NewCalibration calibration;
    calibration.machine = kMt;
    calibration.machine_revision = 1;
    calibration.measured_at = database.clock.UtcNow();
    calibration.options_json = "{}";
    calibration.report_json = reports::ToJson(reports::Identification());
    calibration.model_json = absl::StrFormat(
        R"({"EX0C": %g, "covariance": {"of": ["EX0C"], "sigma": [1], "correlation": [[]]}})", ex0c_um.load());
    calibration.estimates = {{"EX0C", records::EstimateUnit::kUm, true, ex0c_um.load(), 1.0}};
    calibration.sessions = {session};
    calibration.created_by = by;
    return calibration;
  }
  records::Routine Nightly() {
    records::Routine routine;
    routine.name = "nightly";
    routine.scope = {records::Scope::Kind::kMachine, "mt"};
    routine.principal = "night";
    routine.sessions = {"CR", "BX"};
    return routine;
  }
  void Put(const records::Routine& routine) {
    const auto put = database->PutRoutine(routine, 0, Cell(""));
    ASSERT_TRUE(put.ok()) << put.status();
  }
  // Measured now.
  SessionId Store(const std::string& name) {
    storage::NewSession stored = storage::TestSession("");
    stored.name = name;
    const SessionId id = database->CreateSession(stored)->id;
    const std::vector<session::Column> columns = storage::TestColumns(id.number(), 10);
    DEMAND(storage::Append(*database, id, 0, columns).ok());
    DEMAND(database->FinishSession(id, {1, 10, session::SessionHash({session::ChunkCrc32c(columns)})}).ok());
    return session = id;
  }
  void StoreBoth() {
    Store("CR");
    Store("BX");
  }
  std::vector<RoutineRun> Runs() { return database->ListRuns({}, {}, {})->rows; }
  // Looks until the newest run has ended; its job runs on another thread.
  RoutineRun RunToEnd() {
    keeper->Look(kMt);
    while (records::IsOpen(Runs().at(0).state)) {
      const auto watch = runner->Watch(*Runs()[0].job);
      DEMAND(watch.ok());
      while (!records::IsTerminal(runner->Get(*Runs()[0].job)->state)) DEMAND((*watch)->Next(std::chrono::minutes(1)));
      keeper->Look(kMt);
    }
    return Runs()[0];
  }

  storage::TempDatabase database;
  std::atomic<bool> is_held = false, fails = false;
  std::atomic<double> ex0c_um = 10;
  SessionId session;
  std::vector<std::string> told;
  std::function<absl::StatusOr<Judgement>(storage::Database&, const records::CalibrationRecord&)> judge;
  std::unique_ptr<jobs::JobRunner> runner;
  std::unique_ptr<access::Gate> gate;
  std::unique_ptr<Keeper> keeper;
};

TEST_F(Routines, RunWhenASetIsCompleteAndOnceOnIt) {
  Put(Nightly());
  keeper->LookAtAll();
  const SessionId cr = Store("CR");
  keeper->LookAtAll();
  EXPECT_TRUE(Runs().empty());
  const SessionId bx = Store("BX");
  const RoutineRun run = RunToEnd();
  EXPECT_EQ(run.state, RunState::kProposed) << run.text;
  EXPECT_THAT(run.sessions, ElementsAre(cr, bx));
  EXPECT_THAT(run.text, HasSubstr("no calibration is in use"));
  ASSERT_TRUE(run.job.has_value());
  const auto job = database->GetJob(*run.job);
  EXPECT_EQ(job->created_by, "night");
  EXPECT_EQ(job->calibration, run.calibration);
  keeper->LookAtAll();
  Store("CR");  // one alone is no set
  keeper->LookAtAll();
  EXPECT_EQ(Runs().size(), 1u);
  EXPECT_THAT(told, ElementsAre());
}

TEST_F(Routines, TakeNoSetThatIsNotOfOneDay) {
  Put(Nightly());
  Store("CR");
  database.clock.Advance(std::chrono::hours(25));
  Store("BX");
  keeper->Look(kMt);
  EXPECT_TRUE(Runs().empty());
  const SessionId cr = Store("CR");
  EXPECT_EQ(RunToEnd().sessions.at(0), cr);
}

TEST_F(Routines, WaitForTheirTime) {
  records::Routine routine = Nightly();
  routine.at_utc_minute = 60 * 2;  // the clock starts at 22:13
  Put(routine);
  StoreBoth();
  keeper->Look(kMt);
  database.clock.Advance(std::chrono::hours(3));
  keeper->Look(kMt);
  EXPECT_TRUE(Runs().empty());
  database.clock.Advance(std::chrono::hours(1));
  EXPECT_EQ(RunToEnd().state, RunState::kProposed);
  // A server that was down at that time is late, and does it.
  StoreBoth();
  database.clock.Advance(std::chrono::hours(40));
  EXPECT_EQ(RunToEnd().id, RunId(2));
}

TEST_F(Routines, ProposeWhatDiffersAndSayWhatAgrees) {
  Put(Nightly());
  StoreBoth();
  const RoutineRun first = RunToEnd();
  ASSERT_TRUE(database->ApproveCalibration(*first.calibration, 0, Cell("")).ok());
  StoreBoth();
  const RoutineRun same = RunToEnd();
  EXPECT_EQ(same.state, RunState::kProposed);  // the readings have no positions: what the tool does is not known
  EXPECT_THAT(same.text, HasSubstr("it agrees with calibration 1"));
  EXPECT_THAT(same.text, HasSubstr("look at: what it changes at the tool point is not known"));
  ex0c_um = 40;
  StoreBoth();
  const RoutineRun other = RunToEnd();
  EXPECT_EQ(other.state, RunState::kProposed);
  EXPECT_THAT(other.text, HasSubstr("against calibration 1: EX0C +30"));
  EXPECT_EQ(database->GetApprovedCalibration(kMt)->id, *first.calibration);
}

// Without the role, on a machine that asks for four eyes, and where nobody knows what it would change.
TEST_F(Routines, ApproveNothingThatTheyMayNot) {
  records::Routine routine = Nightly();
  routine.approve_within_um = 1000;
  Put(routine);
  StoreBoth();
  EXPECT_THAT(RunToEnd().text, HasSubstr("not approved: the first calibration is put in use by a person"));
  EXPECT_THAT(Runs()[0].text, HasSubstr("approver"));
  Grant(records::Role::kApprover);
  StoreBoth();
  EXPECT_EQ(RunToEnd().text.find("approver"), std::string::npos);
  ASSERT_TRUE(database->SetFourEyes(kMt, true, Cell("")).ok());
  StoreBoth();
  EXPECT_THAT(RunToEnd().text, HasSubstr("machine mt asks for the eyes of a person"));
  EXPECT_EQ(base::ErrorReason(database->GetApprovedCalibration(kMt).status()), "CALIBRATION_NOT_FOUND");
}

// A person approves another calibration after the comparison: the run is judged again, against that one.
TEST_F(Routines, ApproveNothingInThePlaceOfAnotherThanTheyComparedWith) {
  records::Routine routine = Nightly();
  routine.approve_within_um = 1000;
  Put(routine);
  Grant(records::Role::kApprover);
  StoreBoth();
  const CalibrationId first = *RunToEnd().calibration;
  ASSERT_TRUE(database->ApproveCalibration(first, 0, Cell("")).ok());
  const CalibrationId other = database->CreateCalibration(Calibration("ann"))->id;
  std::vector<CalibrationId> compared;
  judge = [&](storage::Database& stored, const records::CalibrationRecord& candidate) {
    absl::StatusOr<Judgement> judged = Judge(stored, candidate);
    DEMAND(judged.ok() && judged->in_use.has_value());
    compared.push_back(*judged->in_use);
    judged->doubts.clear();
    if (compared.size() == 1) DEMAND(stored.ApproveCalibration(other, 0, Cell("")).ok());
    return judged;
  };
  StoreBoth();
  const RoutineRun run = RunToEnd();
  EXPECT_EQ(run.state, RunState::kApproved) << run.text;
  EXPECT_THAT(compared, ElementsAre(first, other));
  EXPECT_THAT(told, ElementsAre(HasSubstr("was judged against calibration 1; now calibration 2 is in use")));
  EXPECT_THAT(run.text, HasSubstr("calibration 2"));
  EXPECT_EQ(database->GetApprovedCalibration(kMt)->id, *run.calibration);
}

// Ten small steps are one large one: they are measured from what a person put in use.
TEST_F(Routines, ApproveNoMoreTogetherThanTheLimit) {
  records::Routine routine = Nightly();
  routine.approve_within_um = 10;
  Put(routine);
  Grant(records::Role::kApprover);
  StoreBoth();
  const CalibrationId first = *RunToEnd().calibration;
  ASSERT_TRUE(database->ApproveCalibration(first, 0, Cell("")).ok());
  double moved_um = 0.0;
  judge = [&](storage::Database& stored, const records::CalibrationRecord&) {
    Judgement judged;
    judged.in_use = stored.GetApprovedCalibration(kMt)->id;
    judged.largest_change_um = 6.0;
    EXPECT_EQ(stored.GetApprovedByPerson(kMt)->id, first);
    moved_um += 6.0;
    if (judged.in_use != first) judged.largest_change_since_person_um = moved_um;
    return absl::StatusOr<Judgement>(judged);
  };
  StoreBoth();
  EXPECT_EQ(RunToEnd().state, RunState::kApproved);
  StoreBoth();
  const RoutineRun held_up = RunToEnd();
  EXPECT_EQ(held_up.state, RunState::kProposed);
  EXPECT_THAT(held_up.text, HasSubstr("together with what routines have approved since a person did"));
  // A person looks: from there on it counts anew.
  ASSERT_TRUE(database->ApproveCalibration(*held_up.calibration, 0, Cell("")).ok());
  EXPECT_EQ(database->GetApprovedByPerson(kMt)->id, *held_up.calibration);
}

TEST_F(Routines, ThatFailSayWhyAndStopNoOther) {
  ASSERT_TRUE(database->CreatePrincipal("nobody", "", Cell("")).ok());
  records::Routine powerless = Nightly(), wrong = Nightly();
  powerless.name = "a-powerless";
  powerless.principal = "nobody";
  wrong.name = "b-wrong";
  wrong.declared = {"EX9Q"};
  Put(powerless);
  Put(wrong);
  Put(Nightly());
  StoreBoth();
  EXPECT_EQ(RunToEnd().state, RunState::kProposed);
  std::map<std::string, RoutineRun> runs;
  for (const RoutineRun& run : Runs()) runs[run.routine] = run;
  EXPECT_EQ(runs["a-powerless"].state, RunState::kFailed);
  EXPECT_THAT(runs["a-powerless"].text, HasSubstr("it acts as nobody, which has no role for this machine"));
  EXPECT_EQ(runs["b-wrong"].state, RunState::kFailed);
  EXPECT_THAT(runs["b-wrong"].text, HasSubstr("EX9Q"));
  fails = true;
  StoreBoth();
  EXPECT_EQ(RunToEnd().state, RunState::kFailed);
  EXPECT_THAT(Runs()[0].text, HasSubstr("the readings do not fit"));
  fails = false;
  ASSERT_TRUE(database->RetryRoutine("nightly", kMt, Cell("")).ok());
  EXPECT_EQ(RunToEnd().state, RunState::kProposed);
}

TEST_F(Routines, AreStoppedWithTheirJobs) {
  is_held = true;
  Put(Nightly());
  StoreBoth();
  keeper->Look(kMt);
  ASSERT_EQ(Runs().at(0).state, RunState::kRunning);
  ASSERT_TRUE(database->StopRoutine("nightly", kMt, true, "the probe is loose", Cell("")).ok());
  keeper->Look(kMt);
  EXPECT_EQ(Runs()[0].state, RunState::kStopped);
  EXPECT_THAT(Runs()[0].text, HasSubstr("stopped on this machine by cell: the probe is loose"));
  const auto watch = runner->Watch(*Runs()[0].job);
  while (!records::IsTerminal(runner->Get(*Runs()[0].job)->state)) ASSERT_TRUE((*watch)->Next(std::chrono::minutes(1)));
  EXPECT_EQ(runner->Get(*Runs()[0].job)->state, records::JobState::kCancelled);
  StoreBoth();
  keeper->Look(kMt);
  EXPECT_EQ(Runs().size(), 1u);
  is_held = false;
  // It goes on with the sessions that have come meanwhile.
  ASSERT_TRUE(database->StopRoutine("nightly", kMt, false, "", Cell("")).ok());
  EXPECT_EQ(RunToEnd().state, RunState::kProposed);
  is_held = true;
  StoreBoth();
  keeper->Look(kMt);
  ASSERT_TRUE(database->RemoveRoutine("nightly", 0, Cell("")).ok());
  keeper->LookAtAll();
  EXPECT_EQ(Runs()[0].state, RunState::kStopped);
  EXPECT_THAT(Runs()[0].text, HasSubstr("removed"));
  is_held = false;
}

// Whatever was written down last, another server goes on behind it: one job, one calibration.
TEST_F(Routines, GoOnAfterARestart) {
  is_held = true;
  Put(Nightly());
  StoreBoth();
  // Killed between the run and its job.
  const records::RoutineRecord routine = database->RoutinesOf(kMt)->at(0);
  ASSERT_TRUE(database->BeginRun(routine, kMt, {SessionId(1), SessionId(2)}, {}).ok());
  Restart();
  keeper->LookAtAll();
  ASSERT_EQ(Runs().at(0).state, RunState::kRunning);
  const JobId job = *Runs()[0].job;
  // Killed between the job and what is written down of it.
  ASSERT_TRUE(database->ChangeRun({RunId(1), RunState::kWaiting, {}, {}, ""}).ok());
  Restart();
  keeper->LookAtAll();
  EXPECT_EQ(Runs()[0].job, job);
  is_held = false;
  const RoutineRun ended = RunToEnd();
  EXPECT_EQ(ended.state, RunState::kProposed);
  EXPECT_EQ(database->ListJobs({}, {})->rows.size(), 1u);
  // Killed between an approval and what is written down of it.
  ASSERT_TRUE(database->ApproveCalibration(*ended.calibration, 0, {"night", ""}).ok());
  ASSERT_TRUE(database->ChangeRun({RunId(1), RunState::kRunning, job, {}, ""}).ok());
  Restart();
  keeper->LookAtAll();
  EXPECT_EQ(Runs()[0].state, RunState::kApproved);
  EXPECT_EQ(Runs().size(), 1u);
}

TEST_F(Routines, WaitWhileTheQueueIsFull) {
  is_held = true;
  Put(Nightly());
  StoreBoth();
  // Without a runner that takes work nothing is queued, and nothing is lost.
  runner->Drain({});
  keeper->Look(kMt);
  EXPECT_EQ(Runs().at(0).state, RunState::kWaiting);
  EXPECT_THAT(told, ElementsAre(HasSubstr("nightly: ")));
  is_held = false;
  Restart();
  EXPECT_EQ(RunToEnd().state, RunState::kProposed);
}

}  // namespace
}  // namespace axiscal::routines
