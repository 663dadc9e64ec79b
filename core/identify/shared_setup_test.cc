// Sessions of one set-up (`# setup: NAME`): its offsets are fitted once, and kept for sessions that check.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "core/identify/identify.h"
#include "core/instruments/evaluation.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"

namespace axiscal::identify {
namespace {

using instruments::MeasuringRun;
using session::Session;
using ::testing::HasSubstr;

const machine::Machine kMachine = machine::testing::MultiTasking();

struct Pose {
  double x_mm, y_mm, z_mm, b_deg, c_deg;
};

// A session whose readings are those of the machine with these errors and set-up offsets, with 0.1 um of noise.
Session Measured(const std::string& name, const std::string& instrument, const std::vector<std::string>& columns,
                 const std::vector<Pose>& poses, const std::string& errors, const std::vector<double>& setup,
                 const geometry::Rigid<double>& tracker = {}) {
  Session session{
      {{"machine", "mt"},
       {"session", name},
       {"instrument", instrument},
       {"sigma_um", "0.1"},
       {"tool_tip_mm", "0 0 -356.4"}},
      {{"t_s", {}, {}}, {"X_mm", {}, {}}, {"Y_mm", {}, {}}, {"Z_mm", {}, {}}, {"B_deg", {}, {}}, {"C_deg", {}, {}}}};
  if (instrument == "rtest") session.header.push_back({"table_ball_mm", "100 0 65.5"});
  for (const Pose& pose : poses) {
    const double values[] = {
        static_cast<double>(session.reading_count()), pose.x_mm, pose.y_mm, pose.z_mm, pose.b_deg, pose.c_deg};
    for (int i = 0; i < 6; ++i) session.columns[i].values.push_back(values[i]);
  }
  for (const std::string& column : columns)
    session.columns.push_back({column, std::vector<double>(poses.size(), 0.0), {}});
  if (instrument == "tracker") {  // something that is not alike, for the starting pose of the first binding
    for (size_t k = 0; k < poses.size(); ++k) {
      session.columns[6].values[k] = poses[k].x_mm;
      session.columns[7].values[k] = poses[k].y_mm;
      session.columns[8].values[k] = poses[k].z_mm;
    }
  }
  MeasuringRun run = instruments::BindSession(session, kMachine).value();
  run.tracker_from_machine = tracker;
  const machine::ErrorModel model = machine::ReadErrors(errors, kMachine).value();
  std::mt19937 random(static_cast<unsigned>(poses.size()));
  std::normal_distribution<double> noise_mm(0.0, 1e-4);
  for (int k = 0; k < run.reading_count(); ++k) {
    double reading_mm[3];
    instruments::PredictWith(
        kMachine, run, k, [&](const shapes::State& state) { return machine::ErrorsAt(kMachine, model, state); },
        setup.data(), reading_mm);
    for (size_t i = 0; i < columns.size(); ++i) session.columns[6 + i].values[k] = reading_mm[i] + noise_mm(random);
  }
  return session;
}

Session Rtest(const std::string& name, double c_deg, const std::string& errors, const std::vector<double>& ball_mm,
              int readings = 8) {
  const double x_mm = c_deg == 0.0 ? 100.0 : -100.0;
  return Measured(name, "rtest", {"dx_mm", "dy_mm", "dz_mm"}, std::vector<Pose>(readings, {x_mm, 0, 421.9, 0, c_deg}),
                  errors, ball_mm);
}

Session On(const std::string& setup, Session session) {
  session.header.push_back({"setup", setup});
  return session;
}

Options Fitting(const std::string& errors) {
  Options options;
  options.model = machine::ReadErrors(errors, kMachine).value();
  return options;
}

// In the table's frame the ball's place b and where C stands, s, read -b - s at C = 0 and -b + s at C = 180 deg.
TEST(SharedSetup, TellsWhatNoSessionAloneTells) {
  const std::string truth = R"({"EX0C": 20})";
  const std::vector<double> ball_mm = {0.03, -0.02, 0.01};
  const Session front = Rtest("front", 0, truth, ball_mm), back = Rtest("back", 180, truth, ball_mm);
  const Options options = Fitting(R"({"EX0C": 0})");
  for (const auto& alone :
       {std::vector<Session>{front}, std::vector<Session>{back}, std::vector<Session>{front, back}}) {
    const auto fit = FitSessions(kMachine, alone, options);
    ASSERT_TRUE(fit.ok()) << fit.status();
    EXPECT_FALSE(fit->result.estimates[0].identifiable && fit->result.estimates[0].sigma < 5e-3) << alone.size();
  }
  const auto fit = FitSessions(kMachine, {On("ball", front), On("ball", back)}, options);
  ASSERT_TRUE(fit.ok()) << fit.status();
  ASSERT_TRUE(fit->result.estimates[0].identifiable);
  EXPECT_NEAR(fit->result.estimates[0].value, 0.02, 4.0 * fit->result.estimates[0].sigma);
  EXPECT_LT(fit->result.estimates[0].sigma, 1e-4);
  EXPECT_EQ(fit->problem.groups.size(), 1u);
}

// Its own set-up would take up all that a single reading shows.
TEST(SharedSetup, OfTheFitIsKeptForASessionThatChecks) {
  const std::string truth = R"({"EX0C": 20})";
  const std::vector<double> ball_mm = {0.03, -0.02, 0.01};
  const auto fit = FitSessions(
      kMachine, {On("ball", Rtest("front", 0, truth, ball_mm)), On("ball", Rtest("back", 180, truth, ball_mm))},
      Fitting(R"({"EX0C": 0})"));
  ASSERT_TRUE(fit.ok()) << fit.status();
  // By now the table stands 5 um further.
  const Session later = Rtest("later", 0, R"({"EX0C": 25})", ball_mm, 1);
  const auto rms_um = [&](const Session& session) {
    const auto runs = BindSessions(kMachine, {session});
    EXPECT_TRUE(runs.ok()) << runs.status();
    const auto check = CheckRuns(kMachine, *runs, *fit, {});
    EXPECT_TRUE(check.ok()) << check.status();
    for (const SetupOffset& offset : check->result.sessions[0].setup) {
      const size_t k = static_cast<size_t>(&offset - check->result.sessions[0].setup.data());
      if (runs->front().setup_name != "ball") continue;
      EXPECT_EQ(offset.sigma, 0.0);
      EXPECT_EQ(offset.value, fit->point.setup[0][static_cast<Eigen::Index>(k)]);
    }
    return check->result.fit.max_mm * 1e3;
  };
  EXPECT_NEAR(rms_um(On("ball", later)), 5.0, 0.5);
  EXPECT_LT(rms_um(later), 0.1);
  EXPECT_LT(rms_um(On("another ball", later)), 0.1);
}

// One that states how well an artefact's faces are known has offsets that the other does not have.
TEST(SharedSetup, SetUpsOfDifferentOffsetsAreRefused) {
  instruments::MeasuringRun first, other;
  first.session = "first";
  other.session = "other";
  first.setup_name = other.setup_name = "columns";
  first.kind = other.kind = instruments::Kind::kTouch;
  for (const char* const name : {"x", "y", "z", "a", "b", "c"}) {
    first.setup.push_back({name, 1.0});
    other.setup.push_back({name, 1.0});
  }
  EXPECT_TRUE(CheckSameSetup(first, other).ok());
  other.setup.push_back({"feature_top", 1e-3});
  for (const bool is_first : {true, false}) {
    const absl::Status refused = is_first ? CheckSameSetup(first, other) : CheckSameSetup(other, first);
    EXPECT_THAT(std::string(refused.message()), HasSubstr("share the setup 'columns' but not the set-up offset "
                                                          "feature_top"));
  }
}

TEST(SharedSetup, HeadersThatContradictEachOtherAreRefused) {
  const Session front = On("ball", Rtest("front", 0, "{}", {0, 0, 0})),
                back = On("ball", Rtest("back", 180, "{}", {0, 0, 0}));
  const auto refusal = [&](const std::string& key, const std::string& value) {
    Session other = back;
    bool has_replaced = false;
    for (session::HeaderEntry& entry : other.header) {
      if (entry.key == key) entry.value = value, has_replaced = true;
    }
    if (!has_replaced) other.header.push_back({key, value});
    return std::string(FitSessions(kMachine, {front, other}, Fitting(R"({"EX0C": 0})")).status().message());
  };
  EXPECT_THAT(
      refusal("table_ball_mm", "100 0 66"),
      HasSubstr("sessions 'front' and 'back' share the setup 'ball' but not table_ball_mm: 100 0 65.5 and 100 0 66"));
  EXPECT_THAT(refusal("ball_x_sigma_um", "2"), HasSubstr("share the setup 'ball' but not ball_x_sigma_um: 60 and 2"));
  EXPECT_THAT(refusal("datum", "free X"), HasSubstr("share the setup 'ball' but not the datum"));
  Session bar = back;
  bar.header[2].value = "ballbar";
  bar.header.push_back({"bar_length_mm", "100"});
  bar.columns.erase(bar.columns.end() - 2, bar.columns.end());
  bar.columns.back() = {"dL_mm", std::vector<double>(8, 0.0), {}};
  for (size_t k = 0; k < 8; ++k) bar.columns.back().values[k] = 1e-4 * static_cast<double>(k);
  EXPECT_THAT(std::string(FitSessions(kMachine, {front, bar}, Fitting("{}")).status().message()),
              HasSubstr("share the setup 'ball' but not the instrument"));
  // The same for a session that checks.
  const auto fit = FitSessions(kMachine, {front}, Fitting("{}"));
  ASSERT_TRUE(fit.ok()) << fit.status();
  Session other = back;
  other.header.back().value = "ball";
  for (session::HeaderEntry& entry : other.header) {
    if (entry.key == "table_ball_mm") entry.value = "100 0 66";
  }
  EXPECT_THAT(std::string(CheckRuns(kMachine, BindSessions(kMachine, {other}).value(), *fit, {}).status().message()),
              HasSubstr("but not table_ball_mm"));
}

// Where each session stood by itself, the best fit to its own readings would be where a shared frame starts from.
TEST(SharedSetup, TrackersOfOneSetUpHaveOneFrame) {
  const std::string truth =
      R"({"EA0B": 300, "EX0C": 40, "EC0B": -200, "terms": [{"symbol": "EXX", "shape": "linear", "amplitude": 200}]})";
  geometry::Rigid<double> tracker;
  tracker.rotation = geometry::RotationXyz(0.1, -0.2, 0.4);
  tracker.translation_mm = {1500, -300, 200};
  const std::vector<double> setup = {0.1, -0.2, 0.3, 1e-4, -2e-4, 1e-4, 0.05, -0.02, 0.01};
  std::vector<Pose> here, there;
  for (int k = 0; k < 30; ++k) {
    const double s = std::sin(1.7 * k), c = std::cos(2.3 * k);
    here.push_back({200 * s, 150 * c, 300 + 100 * std::sin(0.9 * k), 60 * c, 0});
    there.push_back({-400 + 90 * c, 60 * s, 100 + 80 * std::sin(1.1 * k), -50 * s, 0});
  }
  const std::vector<std::string> columns = {"px_mm", "py_mm", "pz_mm"};
  const Session a = Measured("a", "tracker", columns, here, truth, setup, tracker),
                b = Measured("b", "tracker", columns, there, truth, setup, tracker);
  const auto fit = FitSessions(kMachine, {On("station", a), On("station", b)}, Fitting(truth));
  ASSERT_TRUE(fit.ok()) << fit.status();
  EXPECT_LT(fit->result.fit.rms_mm, 2e-4);
  EXPECT_EQ(fit->problem.groups.size(), 1u);
  // A check session of few readings in the frame of the fit.
  Session few = On("station", b);
  for (session::Column& column : few.columns) column.values.resize(3);
  few.header[1].value = "few";
  const auto first = FitSessions(kMachine, {On("station", a)}, Fitting(truth));
  ASSERT_TRUE(first.ok()) << first.status();
  const auto check = CheckRuns(kMachine, BindSessions(kMachine, {few}).value(), *first, {});
  ASSERT_TRUE(check.ok()) << check.status();
  EXPECT_EQ(check->problem.runs[0].tracker_from_machine.translation_mm,
            first->problem.runs[0].tracker_from_machine.translation_mm);
  EXPECT_EQ(check->point.setup[0], first->point.setup[0]);
  // Another target on the tool is another set-up.
  Session named = On("station", a);
  named.header.push_back({"target A", "0 0 -150"});
  named.columns.push_back({"target", {}, std::vector<std::string>(a.reading_count(), "A")});
  EXPECT_THAT(std::string(FitSessions(kMachine, {named, On("station", b)}, Fitting(truth)).status().message()),
              HasSubstr("but not the targets, expected the same lines '# target NAME' in both"));
}

// Without t_s no error may need a clock, and sessions with one stay apart from sessions without.
TEST(Clock, IsOneForAllSessionsOrNone) {
  Session front = On("ball", Rtest("front", 0, "{}", {0, 0, 0})),
          back = On("ball", Rtest("back", 180, "{}", {0, 0, 0}));
  front.columns.erase(front.columns.begin());
  EXPECT_THAT(std::string(FitSessions(kMachine, {front, back}, Fitting(R"({"EX0C": 0})")).status().message()),
              HasSubstr("session 'front' has no column t_s and session 'back' has one"));
  back.columns.erase(back.columns.begin());
  const auto fit = FitSessions(kMachine, {front, back}, Fitting(R"({"EX0C": 0})"));
  ASSERT_TRUE(fit.ok()) << fit.status();
  EXPECT_TRUE(fit->result.estimates[0].identifiable);
  const Options drifting = Fitting(R"({"EX0C": 0, "terms": [{"symbol": "EXT", "shape": "drift", "amplitude": 0}]})");
  EXPECT_THAT(std::string(FitSessions(kMachine, {front, back}, drifting).status().message()),
              HasSubstr("column t_s is missing: the error EXT:drift depends on the time"));
}

// Of a temperature that nobody recorded no error is known: nothing is taken for 20 degrees in silence.
TEST(Temperature, IsRecordedWhereAnErrorDependsOnIt) {
  const Session front = On("ball", Rtest("front", 0, "{}", {0, 0, 0}));
  const Options warming = Fitting(R"({"EX0C": 0, "terms": [{"symbol": "EXT", "shape": "thermal", "amplitude": 0}]})");
  EXPECT_THAT(std::string(FitSessions(kMachine, {front}, warming).status().message()),
              HasSubstr("session 'front': column temp_C is missing: the error EXT:thermal depends on the temperature"));
  const Options late = Fitting(R"({"EX0C": 0, "terms": [{"symbol": "EXT", "shape": "thermal-lag", "amplitude": 0,)"
                               R"( "channel": "T_spindle_C", "tau_s": 600}]})");
  EXPECT_THAT(std::string(FitSessions(kMachine, {front}, late).status().message()),
              HasSubstr("session 'front': column T_spindle_C is missing: the error EXT:thermal-lag(T_spindle_C)"));
}

}  // namespace
}  // namespace axiscal::identify
