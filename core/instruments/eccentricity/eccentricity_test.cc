#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/units.h"
#include "core/instruments/eccentricity/eccentricity_bind.h"
#include "core/instruments/eccentricity/eccentricity_path.h"
#include "core/instruments/evaluation.h"
#include "core/instruments/plausible.h"
#include "core/machine/error_model.h"
#include "core/machine/testing/machines.h"
#include "core/session/read_session.h"

namespace axiscal::eccentricity {
namespace {

using ::testing::HasSubstr;

constexpr char kHeader[] =
    "# machine: mt\n# session: runs\n# instrument: eccentricity\n# sigma_um: 0.3\n# tool_tip_mm: 0 0 -356.4\n"
    "# table_ball_mm: 50 0 65.5\n# bar_length_mm: 100\n# path BX: B 0 90 fixed 1 0 0\n"
    "# path CR: C 0 360 turning -1 0 0\n";
constexpr char kRows[] = "run,sense,ex_um,ey_um,ez_um\nBX,1,-51.4,,-41.3\nCR,-1,-48,25.4,\nCR,0,,26,\n";

absl::StatusOr<instruments::MeasuringRun> Bind(const std::string& header, const std::string& rows) {
  const auto session = session::ReadSessionText(header + rows, "runs.csv");
  EXPECT_TRUE(session.ok()) << session.status();
  return instruments::BindSession(*session, machine::testing::MultiTasking());
}

std::string Refusal(const std::string& header, const std::string& rows) {
  const auto run = Bind(header, rows);
  return run.ok() ? "accepted" : std::string(run.status().message());
}

double PredictedUm(const instruments::MeasuringRun& run, int reading, const machine::JointErrors<double>& errors,
                   const double* setup) {
  double predicted_mm = NAN;
  instruments::Predict(machine::testing::MultiTasking(), run, reading, errors, setup, &predicted_mm);
  return predicted_mm * base::kUmPerMm;
}

TEST(Eccentricity, EachSensedCellIsAReading) {
  const auto run = Bind(kHeader, kRows);
  ASSERT_TRUE(run.ok()) << run.status();
  ASSERT_EQ(run->reading_count(), 5);
  EXPECT_DOUBLE_EQ(run->measured_mm(0, 1), -41.3e-3);
  EXPECT_EQ(run->path_readings->readings[1].component, 2);
  EXPECT_EQ(run->path_readings->readings[4].row, 2);
  ASSERT_EQ(run->path_readings->traces.size(), 3u);  // BX, CR back, CR without sense
  EXPECT_EQ(run->path_readings->traces[0].reading_count(), 91);
  EXPECT_EQ(run->path_readings->traces[1].reading_count(), 360);
  const int c = machine::FindAxis(machine::testing::MultiTasking(), "C");
  EXPECT_EQ(run->path_readings->traces[1].StateOf(10).axes[c].sense, -1.0);
  EXPECT_EQ(run->path_readings->traces[2].StateOf(10).axes[c].sense, 0.0);
}

// A perfect machine has its trace's centre in the middle, however the ball and the bar were mounted across a full turn.
TEST(Eccentricity, APerfectMachineReadsZero) {
  const auto run = Bind(kHeader, kRows);
  ASSERT_TRUE(run.ok());
  const double none[instruments::kMaxSetupParameters] = {},
               mounted[instruments::kMaxSetupParameters] = {0.02, -0.03, 0.01, 0, 0, 0.002};
  for (int k = 0; k < run->reading_count(); ++k) {
    EXPECT_NEAR(PredictedUm(*run, k, {}, none), 0.0, 1e-6) << k;
    EXPECT_NEAR(PredictedUm(*run, k, {}, mounted), 0.0, 0.01) << k;  // second order: 0.03^2 / 100 mm
  }
}

// Yao 2022, ch. 2: CR sees dxCZ in ex; BX sees -R_B b_XB in ez.
TEST(Eccentricity, ClosedForms) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const auto run = Bind(kHeader, kRows);
  ASSERT_TRUE(run.ok());
  const double none[instruments::kMaxSetupParameters] = {};
  constexpr double kToleranceUm = 0.02;  // second order
  machine::JointErrors<double> errors;
  errors[machine::FindAxis(machine, "C")][0] = 0.020;
  EXPECT_NEAR(PredictedUm(*run, 2, errors, none), 20.0, kToleranceUm);
  EXPECT_NEAR(PredictedUm(*run, 3, errors, none), 0.0, kToleranceUm);
  errors = {};
  constexpr double kTiltRad = 50e-6;
  errors[machine::FindAxis(machine, "B")][4] = kTiltRad;
  EXPECT_NEAR(PredictedUm(*run, 1, errors, none), -356.4e3 * kTiltRad, kToleranceUm);
}

TEST(Eccentricity, BadPathsAndRowsAreNamed) {
  const auto with = [](const std::string& path) { return absl::StrCat(kHeader, "# path P: ", path, "\n"); };
  const std::string row = "run,sense,ex_um,ey_um,ez_um\nP,1,1,1,\n";
  EXPECT_EQ(Refusal(with("C 0 360 turning -1 0 0 B 30"), row), "accepted");
  EXPECT_THAT(Refusal(with("C 0 360 moving -1 0 0"), row),
              HasSubstr("header 'path P: C 0 360 moving -1 0 0', expected 'AXIS FROM"));
  EXPECT_THAT(Refusal(with("X 0 360 fixed 1 0 0"), row), HasSubstr("has no rotary axis 'X'"));
  EXPECT_THAT(Refusal(with("C 0 20 fixed 1 0 0"), row), HasSubstr("expected TO - FROM of 30 to 360 deg"));
  EXPECT_THAT(Refusal(with("C 0 nan fixed 1 0 0"), row), HasSubstr("expected 'AXIS FROM"));
  EXPECT_THAT(Refusal(with("C 0 90 fixed 0 0 0"), row), HasSubstr("other than 0 0 0"));
  EXPECT_THAT(Refusal(with("C 0 90 fixed 1 0 0 C 5"), row), HasSubstr("expected other axes"));
  EXPECT_THAT(Refusal(kHeader, "run,sense,ex_um,ey_um,ez_um\nCX,1,1,1,\n"),
              HasSubstr("session 'runs': line 11: run 'CX' has no path, expected a header '# path CX:"));
  EXPECT_THAT(Refusal(kHeader, "run,sense,ex_um,ey_um,ez_um\nCR,1,1,1,2\n"),
              HasSubstr("line 11 (ez_um): 2, but C turns about z, expected an empty cell"));
  EXPECT_THAT(Refusal(kHeader, "run,sense,ex_um,ey_um,ez_um\nCR,1,,,\n"), HasSubstr("line 11: no eccentricity"));
  EXPECT_THAT(Refusal(kHeader, "run,sense,ex_um,ey_um,ez_um\nCR,0.5,1,,\n"),
              HasSubstr("sense = 0.5, expected 1, -1 or 0"));
  // Without any path the session is stored all the same.
  std::string without = kHeader;
  without.resize(without.find("# path"));
  const auto session = session::ReadSessionText(without + kRows, "runs.csv");
  ASSERT_TRUE(session.ok());
  EXPECT_TRUE(instruments::CheckPlausible(*session, machine::testing::MultiTasking()).ok());
  EXPECT_THAT(Refusal(without, kRows), HasSubstr("run 'BX' has no path"));
}

}  // namespace
}  // namespace axiscal::eccentricity
