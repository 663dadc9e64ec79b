#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <utility>

#include "core/base/units.h"
#include "core/instruments/evaluation.h"
#include "core/instruments/plausible.h"
#include "core/instruments/tracker/tracker_model.h"
#include "core/machine/testing/machines.h"

namespace axiscal::tracker {
namespace {

using instruments::BindSession;
using instruments::CheckPlausible;
using instruments::MeasuringRun;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct Reading {
  std::string target;
  double x_mm, b_deg;
};

// Readings 10 s apart.
session::Session SessionOf(const std::vector<session::HeaderEntry>& keys, const std::vector<Reading>& readings) {
  session::Session session;
  session.header = {{"machine", machine::testing::MultiTasking().id},
                    {"session", "T"},
                    {"instrument", "tracker"},
                    {"sigma_um", "5"},
                    {"tool_tip_mm", "0 0 -150"}};
  session.header.insert(session.header.end(), keys.begin(), keys.end());
  std::vector<double> t_s, x_mm, b_deg, zero(readings.size(), 0.0);
  std::vector<std::string> target;
  for (const Reading& reading : readings) {
    t_s.push_back(10.0 * static_cast<double>(t_s.size()));
    x_mm.push_back(reading.x_mm);
    b_deg.push_back(reading.b_deg);
    target.push_back(reading.target);
  }
  session.columns = {{"t_s", t_s, {}},     {"X_mm", x_mm, {}},  {"Y_mm", x_mm, {}},     {"Z_mm", zero, {}},
                     {"B_deg", b_deg, {}}, {"C_deg", zero, {}}, {"target", {}, target}, {"px_mm", x_mm, {}},
                     {"py_mm", b_deg, {}}, {"pz_mm", zero, {}}};
  return session;
}

const std::vector<session::HeaderEntry> kTwoOfEach = {{"target A", "0 0 -150"},
                                                      {"target B", "30 0 -120"},
                                                      {"reference R", "900 -500 100"},
                                                      {"reference S", "-800 -600 50"}};

absl::StatusOr<MeasuringRun> Bind(const session::Session& session) {
  return BindSession(session, machine::testing::MultiTasking());
}

const std::vector<Reading> kReadings = {{"R", 0, 0},    {"S", 0, 0},    {"A", 0, 0},   {"B", 100, 40}, {"A", -50, 80},
                                        {"R", -50, 80}, {"S", -50, 80}, {"B", 70, 10}, {"R", 70, 10}};

TEST(Tracker, EveryTargetAndEveryLookHasItsOffsets) {
  const auto run = Bind(SessionOf(kTwoOfEach, kReadings));
  ASSERT_TRUE(run.ok()) << run.status();
  EXPECT_THAT(run->targets.of_reading, ElementsAre(-1, -2, 0, 1, 0, -1, -2, 1, -1));
  EXPECT_THAT(run->targets.looks_s, ElementsAre(5.0, 55.0, 80.0));
  std::vector<std::string> names;
  for (const auto& offset : run->setup) names.push_back(offset.name);
  EXPECT_EQ(names[6], "target_A_x");
  EXPECT_EQ(names[11], "target_B_z");
  EXPECT_EQ(names[12], "reference_R_x");
  EXPECT_EQ(names[18], "moved_2_x");
  EXPECT_EQ(names.back(), "moved_3_c");
  EXPECT_EQ(names.size(), 6u + 4 * 3 + 2 * 6);
}

TEST(Tracker, GoesSteadilyFromLookToLookOrAtOnceWhereItWasKnocked) {
  Targets targets;
  targets.looks_s = {5.0, 55.0, 80.0};
  const auto shares = [&](double time_s) {
    double out[2];
    PoseShares(targets, time_s, out);
    return std::vector<double>(out, out + 2);
  };
  EXPECT_THAT(shares(0.0), ElementsAre(0.0, 0.0));
  EXPECT_THAT(shares(30.0), ElementsAre(0.5, 0.0));
  EXPECT_THAT(shares(55.0), ElementsAre(1.0, 0.0));
  EXPECT_THAT(shares(75.0), ElementsAre(::testing::DoubleNear(0.2, 1e-12), ::testing::DoubleNear(0.8, 1e-12)));
  EXPECT_THAT(shares(99.0), ElementsAre(0.0, 1.0));
  targets.knocked_s = {40.0};
  EXPECT_THAT(shares(39.0), ElementsAre(0.0, 0.0));
  EXPECT_THAT(shares(40.0), ElementsAre(1.0, 0.0));
  EXPECT_THAT(shares(75.0), ElementsAre(::testing::DoubleNear(0.2, 1e-12), ::testing::DoubleNear(0.8, 1e-12)));
}

// A tracker that has gone by 0.1 mm and turned by 50 urad about its z at the second look, with all it sees.
TEST(Tracker, SeesEverythingGoTheOtherWayAsItMoves) {
  auto run = Bind(SessionOf({{"reference R", "1000 0 0"}}, {{"R", 0, 0}, {"tool", 0, 0}, {"R", 0, 0}, {"tool", 0, 0}}));
  ASSERT_TRUE(run.ok()) << run.status();
  run->tracker_from_machine = {};
  std::vector<double> setup(run->setup.size(), 0.0);
  setup[12] = 0.1;    // moved_2_x
  setup[17] = 50e-6;  // moved_2_c
  const machine::Machine machine = machine::testing::MultiTasking();
  const auto predicted = [&](int reading) {
    double out[3];
    instruments::Predict(machine, *run, reading, machine::JointErrors<double>(), setup.data(), out);
    return Eigen::Vector3d(out[0], out[1], out[2]);
  };
  EXPECT_LT((predicted(0) - Eigen::Vector3d(1000, 0, 0)).norm(), 1e-9);
  EXPECT_LT((predicted(2) - Eigen::Vector3d(1000.1, 0.05, 0)).norm(), 2e-6);
  // The tool stands on the line about which the tracker turns; the second look is its pose from 20 s on.
  EXPECT_LT((predicted(3) - Eigen::Vector3d(0.1, 0, -150)).norm(), 1e-6);
  EXPECT_LT((predicted(1) - Eigen::Vector3d(0.05, 0, -150)).norm(), 1e-6);
}

TEST(Tracker, DerivativesAgreeWithDifferences) {
  const machine::Machine machine = machine::testing::MultiTasking();
  auto run = Bind(SessionOf(kTwoOfEach, kReadings));
  ASSERT_TRUE(run.ok()) << run.status();
  run->tracker_from_machine.rotation = geometry::RotationXyz(0.4, -1.0, 2.0);
  std::vector<double> setup;
  for (size_t i = 0; i < run->setup.size(); ++i)
    setup.push_back((run->setup[i].is_angle ? 1e-3 : 1.0) * std::sin(1.0 + static_cast<double>(i)));
  machine::JointErrors<double> errors;
  for (int joint = 0; joint < machine.joint_count(); ++joint) {
    for (int c = 0; c < machine::kComponents; ++c) errors[joint][c] = (c < 3 ? 0.1 : 1e-4) * std::cos(7.0 * joint + c);
  }
  instruments::Evaluation out;
  for (int k = 0; k < run->reading_count(); ++k) {
    instruments::Evaluate(machine, *run, k, errors, setup.data(), &out);
    ASSERT_EQ(out.by_setup.cols(), static_cast<Eigen::Index>(setup.size()));
    for (size_t i = 0; i < setup.size(); ++i) {
      const double step = run->setup[i].is_angle ? 1e-6 : 1e-3;
      Eigen::Vector3d low, high;
      const double at = setup[i];
      setup[i] = at - step;
      instruments::Predict(machine, *run, k, errors, setup.data(), low.data());
      setup[i] = at + step;
      instruments::Predict(machine, *run, k, errors, setup.data(), high.data());
      setup[i] = at;
      EXPECT_LT((out.by_setup.col(static_cast<Eigen::Index>(i)) - (high - low) / (2.0 * step)).norm(),
                run->setup[i].is_angle ? 1e-3 : 1e-7)
          << k << " " << run->setup[i].name;
    }
    const bool is_reference = run->targets.IsReference(k);
    EXPECT_EQ(out.by_error.cwiseAbs().maxCoeff() == 0.0, is_reference) << k;
  }
}

TEST(Tracker, WhatItCannotBeOfIsRefused) {
  const auto refusal = [](const std::vector<session::HeaderEntry>& keys, const std::vector<Reading>& readings) {
    return std::string(Bind(SessionOf(keys, readings)).status().message());
  };
  const std::vector<Reading> two = {{"A", 0, 0}, {"B", 100, 0}, {"A", 50, 10}};
  EXPECT_THAT(refusal({}, two), HasSubstr("session 'T': target A, B: expected '# reference NAME: x y z'"));
  EXPECT_THAT(refusal({{"target A", "0 0 1"}}, two), HasSubstr("target B: expected"));
  EXPECT_THAT(refusal({{"target A", "0 0 1"}, {"reference A", "0 0 1"}, {"target B", "0 0 1"}}, two),
              HasSubstr("'A' stands in '# target' and '# reference'"));
  EXPECT_THAT(refusal({{"reference B", "0 0"}}, two), HasSubstr("'reference B: 0 0', expected its place"));
  EXPECT_THAT(refusal({{"reference B", "0 0 1"}, {"reference C", "0 0 1"}}, two),
              HasSubstr("'reference C' is of a target that no reading is of"));
  EXPECT_THAT(refusal({{"reference A", "0 0 1"}, {"reference B", "0 0 1"}}, two),
              HasSubstr("expected some of the tool"));
  EXPECT_THAT(refusal({{"reference B", "0 0 1"}, {"setup", "one"}}, two), HasSubstr("has a set-up of its own"));
  EXPECT_THAT(refusal({{"reference B", "0 0 1"}, {"knocked_s", "30 20"}}, two), HasSubstr("'knocked_s: 30 20'"));
  EXPECT_THAT(refusal({{"reference B", "0 0 1"}, {"knocked_s", "30300"}}, two),
              AllOf(HasSubstr("'knocked_s: 30300'"), HasSubstr("between the first and the last reading, t_s")));
  EXPECT_THAT(refusal({{"reference B", "0 0 1"}, {"knocked_s", "-5"}}, two), HasSubstr("'knocked_s: -5'"));
  // The same before it is stored: of the whole, as a part cannot tell.
  const auto whole = [&](const std::vector<session::HeaderEntry>& keys) {
    return std::string(instruments::CheckWhole(SessionOf(keys, two)).message());
  };
  EXPECT_EQ(whole({{"reference B", "0 0 1"}, {"knocked_s", "15"}}), "");
  EXPECT_EQ(
      whole({{"reference B", "0 0 1"}, {"knocked_s", "30300"}}),
      "session 'T': header 'knocked_s: 30300', expected times between the first and the last reading, t_s 0 to 20");
  EXPECT_THAT(whole({{"reference B", "0 0 1"}, {"reference C", "0 0 1"}}),
              HasSubstr("session 'T': header 'reference C' is of a target that no reading is of"));
  session::Session without = SessionOf({{"reference B", "0 0 1"}}, two);
  std::erase_if(without.columns, [](const session::Column& column) { return column.name == "target"; });
  EXPECT_THAT(std::string(Bind(without).status().message()), HasSubstr("need the column target"));
  session::Session timeless = SessionOf({{"reference B", "0 0 1"}}, two);
  std::erase_if(timeless.columns, [](const session::Column& column) { return column.name == "t_s"; });
  EXPECT_THAT(std::string(Bind(timeless).status().message()), HasSubstr("need the column t_s"));
}

// What the nominal machine has a tracker read that stands three metres away; targets beside it are not where they are
// said to be.
session::Session Seen(double scale, double sign_of_y) {
  session::Session session = SessionOf(kTwoOfEach, kReadings);
  for (size_t k = 0; k < kReadings.size(); ++k) {  // not in one plane: that would look the same from behind
    session.columns[2].values[k] = 110.0 * static_cast<double>(3 * k % 4);
    session.columns[3].values[k] = -120.0 * static_cast<double>(k % 3);
  }
  auto run = Bind(session);
  EXPECT_TRUE(run.ok()) << run.status();
  run->tracker_from_machine = {Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {3000, 200, -50}};
  const machine::JointErrors<double> no_errors;
  const double no_setup[instruments::kMaxSetupParameters] = {};
  for (int k = 0; k < run->reading_count(); ++k) {
    double place_mm[instruments::kMaxRows];
    Predict(machine::testing::MultiTasking(), *run, k, no_errors, no_setup, place_mm);
    const auto at = static_cast<size_t>(k);
    session.columns[7].values[at] = scale * (place_mm[0] + (run->targets.IsReference(k) ? 300.0 : 0.0));
    session.columns[8].values[at] = scale * sign_of_y * place_mm[1];
    session.columns[9].values[at] = scale * place_mm[2];
  }
  return session;
}

TEST(Tracker, ReadingsInMetresOrAMirroredFrameAreRefused) {
  const machine::Machine machine = machine::testing::MultiTasking();
  EXPECT_TRUE(CheckPlausible(Seen(1.0, 1.0), machine).ok()) << CheckPlausible(Seen(1.0, 1.0), machine);
  for (const auto& [scale, sign] : {std::pair(1e-3, 1.0), {1.0, -1.0}}) {
    EXPECT_THAT(std::string(CheckPlausible(Seen(scale, sign), machine).message()),
                AllOf(HasSubstr("_mm = "), HasSubstr("the nominal machine would read"), HasSubstr("units (mm, deg)"),
                      HasSubstr("(the tracker stands where its readings fit best)")));
  }
}

}  // namespace
}  // namespace axiscal::tracker
