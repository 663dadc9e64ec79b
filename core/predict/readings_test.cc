#include "core/predict/readings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/instruments/evaluation.h"
#include "core/machine/testing/machines.h"
#include "core/session/read_session.h"
#include "core/session/testing/example.h"

namespace axiscal::predict {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const machine::Machine kMachine = machine::testing::MultiTasking();
constexpr char kErrors[] =
    R"({"EX0C": 53.1, "EA0B": -101.2, "EB0C": 30, "terms": [{"symbol": "EXX", "shape": "backlash", "amplitude": -6},)"
    R"({"symbol": "EZB", "shape": "harmonic", "order": 2, "amplitude": 5, "phase_deg": 20}], "covariance": {"of":)"
    R"( ["EX0C", "EA0B", "EXX:backlash", "EZB:harmonic(2).sin"], "sigma": [2, 3, 0.5, 0.7],)"
    R"( "correlation": [[], [0.3], [0, -0.2], [0, 0.1, 0.4]]}})";

// Positions at which the tool ball stands a bar's length from the table ball, or in it.
const std::string kAxes = "t_s,X_mm,Y_mm,Z_mm,B_deg,C_deg,temp_C",
                  kRows[2] = {"0,100,0,421.9,0,0,20", "1,99,14,421.9,30,20,20"};

std::string Session(const std::string& instrument, const std::string& more, const std::string& columns,
                    const std::string& readings) {
  return "# machine: mt\n# session: a\n# instrument: " + instrument + "\n# sigma_um: 1\n# tool_tip_mm: 0 0 -356.4\n" +
         more + columns + "\n" + readings;
}

const std::string kBar = "# table_ball_mm: 0 0 65.5\n# bar_length_mm: 100\n";

// Beside the instruments' own predictions, with sigmas by finite differences of them.
TEST(Readings, AreThoseOfTheInstrumentWithTheSigmaOfTheErrors) {
  const std::string sessions[] = {
      Session("ballbar", kBar, kAxes + ",dL_mm", kRows[0] + ",0.1\n" + kRows[1] + ",0.2\n"),
      Session("rtest", "# table_ball_mm: 0 0 65.5\n", kAxes + ",dx_mm,dy_mm,dz_mm",
              kRows[0] + ",0,0,0\n" + kRows[1] + ",0,0,0\n"),
      Session("touch", "# stylus_radius_mm: 3\n# plane top: 0 0 40 0 0 1\n", kAxes + ",nx,ny,nz,feature",
              "0,0,0,399.4,0,0,20,0,0,-1,top\n1,1,0,399.4,0,20,20,0,0,-1,top\n"),
      Session("eccentricity", kBar + "# path CR: C 0 360 turning -1 0 0\n", "run,sense,ex_um,ey_um,ez_um",
              "CR,1,1,2,\nCR,-1,1,2,\n")};
  const auto known = machine::ReadKnownErrors(kErrors, kMachine);
  ASSERT_TRUE(known.ok()) << known.status();
  for (const std::string& text : sessions) {
    const auto session = session::ReadSessionText(text, "a");
    ASSERT_TRUE(session.ok()) << session.status();
    const auto made = PredictReadings(*session, kMachine, *known);
    ASSERT_TRUE(made.ok()) << made.status() << text;
    const auto predicted = [&](const machine::ErrorModel& model) {
      machine::KnownErrors other{model, {}};
      return PredictReadings(*session, kMachine, other)->predicted;
    };
    ASSERT_EQ(made->predicted.rows(), 2);
    Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(made->predicted.size(), 4);
    for (int i = 0; i < 4; ++i) {
      machine::ErrorModel up = known->model, down = known->model;
      const machine::ErrorCovariance::Number& number = known->covariance.of[i];
      constexpr double kStep = 1e-7;
      up.terms[number.term].amplitude[number.basis] += kStep;
      down.terms[number.term].amplitude[number.basis] -= kStep;
      slopes.col(i) = Eigen::MatrixXd((predicted(up) - predicted(down)) / (2.0 * kStep)).reshaped();
    }
    const Eigen::VectorXd sigma = (slopes * known->covariance.root).rowwise().norm();
    for (Eigen::Index i = 0; i < made->predicted.size(); ++i) {
      EXPECT_EQ(std::isnan(made->predicted(i)), std::isnan(made->sigma(i)));
      if (std::isnan(made->predicted(i))) continue;
      // Differences of sums of hundreds of lengths of 100 mm, over a step of 1e-7: 1e-6 of what is rounded.
      constexpr double kRounding = 1e-6;
      EXPECT_NEAR(made->sigma(i), sigma[i], kRounding * (1.0 + sigma[i])) << text << i;
    }
    // The same as the one evaluation of all readings, with set-ups as stated.
    const auto run = instruments::BindSession(*session, kMachine);
    for (int k = 0; run->path_readings == nullptr && k < 2; ++k) {
      const std::vector<double> setup(run->setup.size(), 0.0);
      double expected[instruments::kMaxRows];
      instruments::PredictWith(
          kMachine, *run, k,
          [&](const shapes::State& state) { return machine::ErrorsAt(kMachine, known->model, state); }, setup.data(),
          expected);
      for (int row = 0; row < run->row_count; ++row) EXPECT_NEAR(made->predicted(k, row), expected[row], 1e-12);
    }
  }
}

// X0C moves the table ball by 53.1 um to +X, towards a tool ball that stands at +X: the bar reads 53.1 um short.
TEST(Readings, OfAPlanAreTheSameAndAreWrittenByColumn) {
  const auto known = machine::ReadKnownErrors(
      R"({"EX0C": 53.1, "covariance": {"of": ["EX0C"], "sigma": [2], "correlation": [[]]}})", kMachine);
  const auto plan = session::ReadPlanText(Session("ballbar", kBar, kAxes, "0,100,0,421.9,0,0,20\n"), "plan");
  ASSERT_TRUE(plan.ok()) << plan.status();
  const auto made = PredictReadings(*plan, kMachine, *known);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_EQ(ToCsv(*made), "dL_mm,dL_sigma_mm\n-0.053100000,0.002000000\n");
  const auto bare = PredictReadings(*plan, kMachine, {known->model, {}});
  EXPECT_EQ(ToCsv(*bare), "dL_mm,dL_sigma_mm\n-0.053100000,\n");
  const auto runs = session::ReadPlanText(
      Session("eccentricity", kBar + "# path BX: B 0 90 fixed 1 0 0\n", "run,sense", "BX,1\n"), "plan");
  ASSERT_TRUE(runs.ok()) << runs.status();
  const auto traces = PredictReadings(*runs, kMachine, *known);
  ASSERT_TRUE(traces.ok()) << traces.status();
  EXPECT_THAT(traces->columns, ElementsAre("ex_um", "ey_um", "ez_um"));
  EXPECT_TRUE(std::isnan(traces->predicted(0, 1)));
  EXPECT_FALSE(std::isnan(traces->predicted(0, 0)));
}

TEST(Readings, WhatAnErrorNeedsAndTheSessionLacksIsRefused) {
  const auto known =
      machine::ReadKnownErrors(R"({"terms": [{"symbol": "EXX", "shape": "thermal", "amplitude": 5}]})", kMachine);
  const auto plan =
      session::ReadPlanText(Session("ballbar", kBar, "t_s,X_mm,Y_mm,Z_mm,B_deg,C_deg", "0,100,0,421.9,0,0\n"), "plan");
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_THAT(std::string(PredictReadings(*plan, kMachine, *known).status().message()),
              HasSubstr("session 'a': column temp_C is missing: the error EXX:thermal depends on the temperature"));
}

}  // namespace
}  // namespace axiscal::predict
