// Machines whose calibrations, marks and time make events, on a store of its own.
#include "server/watch/watcher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/reports/loop.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::watch {
namespace {

using records::Event;
using records::EventKind;
using storage::Cell;
using ::testing::HasSubstr;

const MachineId kMt("mt");
constexpr char kMachineJson[] = R"({"id": "mt", "axes": {
  "X": {"kind": "linear", "direction": [1, 0, 0]}, "Y": {"kind": "linear", "direction": [0, 1, 0]},
  "Z": {"kind": "linear", "direction": [0, 0, 1], "travel_mm": [0, 400]},
  "C": {"kind": "rotary", "direction": [0, 0, 1], "point_mm": [0, 0, 0]}},
 "tool_branch": ["Z", "Y", "X"], "work_branch": ["C"], "tool_direction": [0, 0, -1], "declared": ["EX0C"]})";

class Watch : public testing::Test {
 protected:
  Watch() { DEMAND(database->CreateMachine(kMt, kMachineJson, Cell("")).ok()); }

  WatcherOptions Options() {
    WatcherOptions options;
    options.version = "1";
    options.clock = &database.clock;
    options.tell = [](const MachineId& machine, const absl::Status& status) {
      ADD_FAILURE() << machine.text() << ": " << status;
    };
    return options;
  }
  SessionId StoreSession() {
    const storage::NewSession session = storage::TestSession("");
    const SessionId id = database->CreateSession(session)->id;
    const std::vector<session::Column> columns = storage::TestColumns(0, 10);
    DEMAND(storage::Append(*database, id, 0, columns).ok());
    DEMAND(database->FinishSession(id, {1, 10, session::SessionHash({session::ChunkCrc32c(columns)})}).ok());
    return id;
  }
  // Measured now, of a session of its own; approved.
  CalibrationId Calibrate(double ex0c_um, double ey0c_um, const std::string& report_json = "{}",
                          bool is_approved = true) {
    storage::NewCalibration calibration;
    calibration.machine = kMt;
    calibration.machine_revision = 1;
    calibration.sessions = {StoreSession()};
    calibration.measured_at = database.clock.UtcNow();
    calibration.options_json = "{}";
    calibration.report_json = report_json;
    calibration.model_json = absl::StrFormat(R"({"EX0C": %.3f, "EY0C": %.3f})", ex0c_um, ey0c_um);
    calibration.estimates = {{"EX0C", records::EstimateUnit::kUm, true, ex0c_um, 1.0},
                             {"EY0C", records::EstimateUnit::kUm, true, ey0c_um, 1.0}};
    calibration.created_by = "test";
    const auto stored = database->CreateCalibration(calibration);
    DEMAND(stored.ok());
    if (is_approved) DEMAND(database->ApproveCalibration(stored->id, 0, Cell("")).ok());
    return stored->id;
  }
  void Expect(const records::Expectations& expected) {
    const auto set = database->SetExpectations(expected, 0, Cell(""));
    ASSERT_TRUE(set.ok()) << set.status();
  }
  void Week() { database.clock.Advance(std::chrono::days(7)); }
  // Near enough to normal: mean 0, variance 1.
  double Noise() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>((seed_ = seed_ * 1664525 + 1013904223) >> 8) / (1 << 24);
    return sum;
  }
  void Look() {
    const absl::Status looked = watcher.Look(kMt);
    ASSERT_TRUE(looked.ok()) << looked;
  }
  std::vector<Event> Open(EventKind kind) {
    std::vector<Event> events = database->ListEvents({kMt, true}, {1000, ""}, {})->rows;
    std::erase_if(events, [kind](const Event& event) { return event.content.kind != kind; });
    return events;
  }

  storage::TempDatabase database;
  std::shared_ptr<EventBoard> board = std::make_shared<EventBoard>();
  Watcher watcher{*database, board, Options()};
  uint32_t seed_ = 1;
};

// Raised when it is proven to be outside, kept while it may be either, cleared when it is proven to be inside.
TEST_F(Watch, OutOfToleranceIsRaisedOnceAndClearedWithHysteresis) {
  Expect({kMt, {{"EX0C", -20, 20}}, {}, {}, false});
  const auto look_at = [&](double ex0c) {
    Week();
    Calibrate(ex0c, 0);
    Look();
    return Open(EventKind::kOutOfTolerance);
  };
  EXPECT_TRUE(look_at(10).empty());
  EXPECT_TRUE(look_at(20.5).empty());
  const std::vector<Event> raised = look_at(25);
  ASSERT_EQ(raised.size(), 1u);
  EXPECT_EQ(raised[0].content.subject, "EX0C");
  EXPECT_THAT(raised[0].content.text, HasSubstr("EX0C is 25 +- 1 um, its tolerance is -20 .. 20 um"));
  ASSERT_EQ(raised[0].content.amounts.size(), 1u);
  EXPECT_EQ(raised[0].content.amounts[0].size, 25);
  EXPECT_GT(*raised[0].content.certainty, 0.95);
  EXPECT_FALSE(raised[0].content.advice.empty());
  const int64_t told = board->told();
  EXPECT_GE(told, 1);
  Look();  // nothing is new
  EXPECT_EQ(board->told(), told);
  const std::vector<Event> kept = look_at(19.5);
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].id, raised[0].id);
  EXPECT_EQ(kept[0].content.amounts[0].size, 19.5);
  EXPECT_TRUE(look_at(12).empty());
  EXPECT_TRUE(database->GetEvent(raised[0].id)->cleared_at.has_value());
  EXPECT_EQ(look_at(-25).size(), 1u);
  // Without a tolerance nothing is out of it.
  Expect({kMt, {}, {}, {}, false});
  Look();
  EXPECT_TRUE(Open(EventKind::kOutOfTolerance).empty());
}

TEST_F(Watch, CandidatesCountWhereTheyAreExpectedTo) {
  Expect({kMt, {{"EX0C", -20, 20}}, {}, {}, false});
  Calibrate(30, 0, "{}", false);
  Look();
  EXPECT_TRUE(Open(EventKind::kOutOfTolerance).empty());
  Expect({kMt, {{"EX0C", -20, 20}}, {}, {}, true});
  Look();
  EXPECT_EQ(Open(EventKind::kOutOfTolerance).size(), 1u);
}

class Steps : public Watch {
 protected:
  // Thirty quiet weeks, then both errors jump and stay.
  void Jump() {
    for (int week = 0; week < 34; ++week) {
      Week();
      if (week == 30) before_ = database.clock.UtcNow() - std::chrono::days(7);
      const double jump = week >= 30 ? 20 : 0;
      Calibrate(10 + jump + Noise(), -5 - jump + Noise());
      Look();
    }
  }
  base::UtcTime before_;
};

TEST_F(Steps, AreRaisedOnceAndEndedByAWord) {
  Jump();
  const std::vector<Event> steps = Open(EventKind::kStep);
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_EQ(steps[0].content.from, before_);
  EXPECT_EQ(steps[0].content.amounts.size(), 2u);
  EXPECT_NEAR(steps[0].content.amounts[0].size * steps[0].content.amounts[1].size, -400, 150);
  EXPECT_GT(*steps[0].content.certainty, 0.9);
  EXPECT_THAT(steps[0].content.text, HasSubstr("jumped together"));
  ASSERT_TRUE(database->AcknowledgeEvent(steps[0].id, "hit the chuck", {"ann", ""}).ok());
  for (int week = 0; week < 3; ++week) {
    Week();
    Calibrate(30 + Noise(), -25 + Noise());
    Look();
  }
  EXPECT_TRUE(Open(EventKind::kStep).empty());
}

TEST_F(Steps, AMarkExplainsThem) {
  Jump();
  ASSERT_EQ(Open(EventKind::kStep).size(), 1u);
  const storage::NewMark mark{kMt, before_ + std::chrono::days(1), records::MarkKind::kCollision, {}, ""};
  const auto put = database->PutMark(mark, Cell(""));
  ASSERT_TRUE(put.ok()) << put.status();
  Look();
  EXPECT_TRUE(Open(EventKind::kStep).empty());
  // Whoever was wrong about the mark hears of the step again.
  ASSERT_TRUE(database->WithdrawMark(put->id, Cell("")).ok());
  Look();
  EXPECT_EQ(Open(EventKind::kStep).size(), 1u);
}

// What a list of the fleet says of the machine without going through its history.
TEST_F(Steps, AreKeptUntilACalibrationBehindThemIsInUse) {
  const auto care = [&] {
    const auto page = database->ListCare({}, {});
    DEMAND(page.ok() && page->rows.size() == 1);
    return page->rows[0];
  };
  Calibrate(10, -5);
  EXPECT_FALSE(care().is_followed);
  Look();
  EXPECT_TRUE(care().is_followed);
  EXPECT_TRUE(care().findings.empty());
  for (int week = 0; week < 30; ++week) {
    Week();
    Calibrate(10 + Noise(), -5 + Noise());
  }
  const base::UtcTime in_use = database.clock.UtcNow();
  // Nobody approves what comes after the jump: it counts here although nothing says that candidates are expected to.
  CalibrationId last;
  for (int week = 0; week < 4; ++week) {
    Week();
    last = Calibrate(30 + Noise(), -25 + Noise(), "{}", false);
  }
  Look();
  EXPECT_TRUE(Open(EventKind::kStep).empty());
  ASSERT_EQ(care().findings.size(), 1u);
  EXPECT_EQ(care().findings[0].kind, records::DriftKind::kStep);
  EXPECT_THAT(care().findings[0].text, HasSubstr("jumped together"));
  EXPECT_GT(care().findings[0].at, in_use);
  EXPECT_EQ(care().waiting, 4);
  EXPECT_EQ(care().in_use->measured_at, in_use);
  // One that was measured behind the jump knows of it.
  ASSERT_TRUE(database->ApproveCalibration(last, 0, Cell("")).ok());
  EXPECT_FALSE(care().is_followed);
  Look();
  EXPECT_TRUE(care().findings.empty());
  EXPECT_EQ(care().in_use->calibration, last);
  EXPECT_EQ(care().waiting, 0);
}

TEST_F(Steps, OnesOfLongAgoAreNoNews) {
  for (int week = 0; week < 34; ++week) {
    Week();
    const double jump = week >= 30 ? 20 : 0;
    Calibrate(10 + jump + Noise(), -5 - jump + Noise());
  }
  database.clock.Advance(std::chrono::days(120));
  Look();  // for the first time
  EXPECT_TRUE(Open(EventKind::kStep).empty());
}

TEST_F(Watch, ABadCalibrationIsToldUntilTheNext) {
  for (int week = 0; week < 30; ++week) {
    Week();
    Calibrate(10 + Noise(), -5 + Noise());
  }
  Week();
  Calibrate(60, -5);
  Look();
  const std::vector<Event> suspects = Open(EventKind::kSuspect);
  ASSERT_EQ(suspects.size(), 1u);
  EXPECT_EQ(suspects[0].content.amounts.at(0).symbol, "EX0C");
  Week();
  Calibrate(10, -5);
  Look();
  EXPECT_TRUE(Open(EventKind::kSuspect).empty());
}

TEST_F(Watch, WhatWearsIsForetoldToReachItsLimit) {
  Expect({kMt, {{"EX0C", -13, 13}}, {}, {}, false});
  for (int week = 0; week < 104; ++week) {
    Week();
    Calibrate(0.1 * week + Noise(), Noise());
  }
  Look();
  const std::vector<Event> forecasts = Open(EventKind::kLimitForecast);
  ASSERT_EQ(forecasts.size(), 1u);
  EXPECT_EQ(forecasts[0].content.subject, "EX0C");
  EXPECT_GT(*forecasts[0].content.certainty, 0.5);
  ASSERT_TRUE(forecasts[0].content.to.has_value());
  EXPECT_GT(*forecasts[0].content.to, database.clock.UtcNow());
  EXPECT_LT(*forecasts[0].content.to, database.clock.UtcNow() + std::chrono::days(366));
  const std::vector<Event> wear = Open(EventKind::kWear);
  ASSERT_EQ(wear.size(), 1u);
  EXPECT_NEAR(wear[0].content.amounts.at(0).size, 5.2, 2);  // um a year
  // Once it is outside, that is told and no forecast.
  Expect({kMt, {{"EX0C", -5, 5}}, {}, {}, false});
  Look();
  EXPECT_TRUE(Open(EventKind::kLimitForecast).empty());
  EXPECT_EQ(Open(EventKind::kOutOfTolerance).size(), 1u);
}

TEST_F(Watch, WhatIsMissedOrOldIsToldByTime) {
  Expect({kMt, {}, 90, {{"CR", 48}}, false});
  Look();
  EXPECT_TRUE(database->ListEvents({kMt, false}, {}, {})->rows.empty());
  database.clock.Advance(std::chrono::hours(49));
  watcher.LookAtAll();
  const std::vector<Event> missed = Open(EventKind::kSessionMissed);
  ASSERT_EQ(missed.size(), 1u);
  EXPECT_EQ(missed[0].content.subject, "CR");
  EXPECT_THAT(missed[0].content.text, HasSubstr("none has come yet"));
  StoreSession();
  watcher.LookAtAll();
  EXPECT_TRUE(Open(EventKind::kSessionMissed).empty());
  database.clock.Advance(std::chrono::days(90));
  watcher.LookAtAll();
  EXPECT_EQ(Open(EventKind::kSessionMissed).size(), 1u);
  ASSERT_EQ(Open(EventKind::kCalibrationOld).size(), 1u);
  EXPECT_THAT(Open(EventKind::kCalibrationOld)[0].content.text, HasSubstr("no calibration is in use"));
  const CalibrationId id = Calibrate(1, 1);
  watcher.LookAtAll();
  EXPECT_TRUE(Open(EventKind::kCalibrationOld).empty());
  database.clock.Advance(std::chrono::days(91));
  watcher.LookAtAll();
  ASSERT_EQ(Open(EventKind::kCalibrationOld).size(), 1u);
  EXPECT_EQ(Open(EventKind::kCalibrationOld)[0].content.calibration, id);
}

TEST_F(Watch, WhatTheModelLacksIsTold) {
  reports::Loop report;
  report.verdict = reports::Verdict::kUnexplained;
  report.unexplained = {{.kind = reports::PartKind::kSlip, .session = "CR", .rms_um = 4.2}};
  Calibrate(1, 1, reports::ToJson(report));
  Look();
  const std::vector<Event> lacks = Open(EventKind::kModelLacks);
  ASSERT_EQ(lacks.size(), 1u);
  EXPECT_THAT(lacks[0].content.text, HasSubstr("a slip in session CR (4.2 um rms)"));
  Week();
  report.verdict = reports::Verdict::kAdequate;
  report.unexplained.clear();
  Calibrate(1, 1, reports::ToJson(report));
  Look();
  EXPECT_TRUE(Open(EventKind::kModelLacks).empty());
}

TEST_F(Watch, WhatChangedWhileNobodyLookedIsLookedAtAfterAStart) {
  Expect({kMt, {{"EX0C", -20, 20}}, {}, {}, false});
  Calibrate(30, 0);
  watcher.Start();
  while (Open(EventKind::kOutOfTolerance).empty()) board->Wait(0, std::chrono::milliseconds(100));
  const int64_t told = board->told();
  Week();
  Calibrate(0, 0);
  watcher.LookSoon(kMt);
  board->Wait(told, std::chrono::seconds(60));
  while (!Open(EventKind::kOutOfTolerance).empty()) board->Wait(told, std::chrono::milliseconds(100));
  watcher.Stop();
  watcher.Stop();
}

// A command line that approves and ends leaves the events behind that follow.
TEST_F(Watch, WhatIsDueIsLookedAtBeforeItStops) {
  Expect({kMt, {{"EX0C", -20, 20}}, {}, {}, false});
  watcher.Start();
  Calibrate(30, 0);
  watcher.LookSoon(kMt);
  watcher.Stop(std::chrono::minutes(10));
  EXPECT_EQ(Open(EventKind::kOutOfTolerance).size(), 1u);
}

// A cell that says nothing any more, or that says that it wants a person, until that is over.
TEST_F(Watch, CellsThatAreSilentOrWantAPersonAreTold) {
  records::CellReport report;
  report.machine = kMt;
  report.name = "seven";
  report.problem = "2 files were refused";
  ASSERT_TRUE(database->ReportCell(report, Cell("")).ok());
  watcher.LookAtAll();
  ASSERT_EQ(Open(EventKind::kCellProblem).size(), 1u);
  EXPECT_EQ(Open(EventKind::kCellProblem)[0].content.subject, "seven");
  EXPECT_THAT(Open(EventKind::kCellProblem)[0].content.text, HasSubstr("cell seven: 2 files were refused"));
  EXPECT_TRUE(Open(EventKind::kCellSilent).empty());
  report.problem.clear();
  ASSERT_TRUE(database->ReportCell(report, Cell("")).ok());
  watcher.LookAtAll();
  EXPECT_TRUE(Open(EventKind::kCellProblem).empty());
  database.clock.Advance(std::chrono::minutes(15));
  watcher.LookAtAll();
  EXPECT_TRUE(Open(EventKind::kCellSilent).empty());
  database.clock.Advance(std::chrono::minutes(1));
  watcher.LookAtAll();
  ASSERT_EQ(Open(EventKind::kCellSilent).size(), 1u);
  EXPECT_THAT(Open(EventKind::kCellSilent)[0].content.text, HasSubstr("longer than 15 minutes"));
  const int64_t change = *database->LastEventChange();
  database.clock.Advance(std::chrono::hours(1));
  watcher.LookAtAll();
  EXPECT_EQ(*database->LastEventChange(), change) << "it is told once";
  ASSERT_TRUE(database->ReportCell(report, Cell("")).ok());
  watcher.LookAtAll();
  EXPECT_TRUE(Open(EventKind::kCellSilent).empty());
  database.clock.Advance(std::chrono::hours(1));
  watcher.LookAtAll();
  ASSERT_EQ(Open(EventKind::kCellSilent).size(), 1u);
  ASSERT_TRUE(database->ForgetCell(kMt, "seven", Cell("")).ok());
  watcher.LookAtAll();
  EXPECT_TRUE(Open(EventKind::kCellSilent).empty());
}

// What a routine has done is told while it stands: a failure until it runs again, a proposal until a person decides.
TEST_F(Watch, RoutinesThatFailOrProposeAreTold) {
  ASSERT_TRUE(database->CreatePrincipal("night", "", Cell("")).ok());
  records::Routine routine;
  routine.name = "nightly";
  routine.scope = {records::Scope::Kind::kMachine, "mt"};
  routine.principal = "night";
  routine.sessions = {"CR"};
  const auto put = database->PutRoutine(routine, 0, Cell(""));
  ASSERT_TRUE(put.ok()) << put.status();
  const auto run = [&](records::RunState state, std::optional<CalibrationId> calibration) {
    const auto begun = database->BeginRun(*put, kMt, {StoreSession()}, {});
    ASSERT_TRUE(begun.ok()) << begun.status();
    ASSERT_TRUE(database->ChangeRun({begun->id, state, {}, calibration, "the text"}).ok());
    Look();
  };
  run(records::RunState::kFailed, {});
  ASSERT_EQ(Open(EventKind::kRoutineFailed).size(), 1u);
  EXPECT_EQ(Open(EventKind::kRoutineFailed)[0].content.subject, "nightly");
  EXPECT_THAT(Open(EventKind::kRoutineFailed)[0].content.text, HasSubstr("routine nightly failed (run 1): the text"));
  const CalibrationId candidate = Calibrate(10, 0, "{}", false);
  run(records::RunState::kProposed, candidate);
  EXPECT_TRUE(Open(EventKind::kRoutineFailed).empty());
  ASSERT_EQ(Open(EventKind::kRoutineProposes).size(), 1u);
  EXPECT_EQ(Open(EventKind::kRoutineProposes)[0].content.calibration, candidate);
  ASSERT_TRUE(database->ApproveCalibration(candidate, 0, Cell("")).ok());
  Look();
  EXPECT_TRUE(Open(EventKind::kRoutineProposes).empty());
  run(records::RunState::kFailed, {});
  ASSERT_EQ(Open(EventKind::kRoutineFailed).size(), 1u);
  ASSERT_TRUE(database->StopRoutine("nightly", kMt, true, "", Cell("")).ok());
  Look();
  EXPECT_TRUE(Open(EventKind::kRoutineFailed).empty());
  ASSERT_TRUE(database->StopRoutine("nightly", kMt, false, "", Cell("")).ok());
  Look();
  ASSERT_EQ(Open(EventKind::kRoutineFailed).size(), 1u);
  ASSERT_TRUE(database->RemoveRoutine("nightly", 0, Cell("")).ok());
  Look();
  EXPECT_TRUE(Open(EventKind::kRoutineFailed).empty());
}

// A calibration in use that stands on a session which does not count is told of until another is in use; it counts in
// no history.
TEST_F(Watch, ACalibrationOnARejectedSessionIsTold) {
  Expect({kMt, {{"EX0C", -20, 20}}, {}, {}, false});
  Calibrate(10, 0);
  Week();
  const CalibrationId bad = Calibrate(40, 0);
  Look();
  ASSERT_EQ(Open(EventKind::kOutOfTolerance).size(), 1u);
  const SessionId session = database->GetCalibration(bad)->content.sessions[0];
  ASSERT_TRUE(database->RejectSession(session, true, "the probe was loose", Cell("")).ok());
  Look();
  const std::vector<Event> told = Open(EventKind::kSessionRejected);
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].content.calibration, bad);
  EXPECT_THAT(told[0].content.text, HasSubstr("stands on session 2, which was rejected"));
  EXPECT_TRUE(Open(EventKind::kOutOfTolerance).empty());
  Week();
  Calibrate(11, 0);
  Look();
  EXPECT_TRUE(Open(EventKind::kSessionRejected).empty());
}

// An error far from that of the others of the group; not from those of another group, nor where there are too few.
TEST_F(Watch, AMachineUnlikeItsGroupIsTold) {
  const auto calibrate_peer = [&](int number, double ex0c_um) {
    const MachineId peer("peer" + std::to_string(number));
    DEMAND(database->CreateMachine(peer, kMachineJson, Cell("")).ok());
    storage::NewCalibration calibration;
    calibration.machine = peer;
    calibration.machine_revision = 1;
    calibration.measured_at = database.clock.UtcNow();
    calibration.options_json = calibration.report_json = calibration.model_json = "{}";
    calibration.estimates = {{"EX0C", records::EstimateUnit::kUm, true, ex0c_um, 1.0}};
    calibration.created_by = "test";
    DEMAND(database->CreateCalibration(calibration).ok());
    DEMAND(database->ChangeGroup("hall", peer, true, Cell("")).ok());
  };
  DEMAND(database->ChangeGroup("hall", kMt, true, Cell("")).ok());
  for (int i = 0; i < 4; ++i) calibrate_peer(i, i);
  Calibrate(300, 0);
  Look();
  EXPECT_TRUE(Open(EventKind::kUnlikeGroup).empty());  // four others tell nothing
  for (int i = 4; i < 8; ++i) calibrate_peer(i, i);
  Week();
  Calibrate(300, 0);
  Look();
  const std::vector<Event> told = Open(EventKind::kUnlikeGroup);
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].content.subject, "EX0C");
  EXPECT_THAT(told[0].content.text,
              HasSubstr("EX0C is 300 +- 1 um; the 8 others of group hall have 3.5, standard deviation 2.4 um"));
  EXPECT_GT(*told[0].content.certainty, 0.99);
  Week();
  Calibrate(5, 0);
  Look();
  EXPECT_TRUE(Open(EventKind::kUnlikeGroup).empty());
}

}  // namespace
}  // namespace axiscal::watch
