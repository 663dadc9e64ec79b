// What Yao 2022 says of probing (chapter 5) and of reading polar traces (chapter 2) beside the tables: formulas that no
// datum moves, what a fixed radius leaks, how far commanded directions are off the normal, what two tools tell.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/testing/source_path.h"
#include "core/identify/identify.h"
#include "core/instruments/eccentricity/eccentricity_run.h"
#include "core/instruments/evaluation.h"
#include "core/instruments/registry.h"
#include "core/instruments/touch/sphere_fit.h"
#include "core/machine/error_json.h"
#include "core/synthetic/simulate.h"
#include "tests/known_answers/published.h"
#include "tests/known_answers/yao_machine.h"
#include "tests/known_answers/yao_tables.h"

namespace axiscal::known_answers {
namespace {

constexpr double kToolMm = 382.95;

// Sphere centres at B = 0 and 90 as the probe finds them on a machine with `errors` (um, urad), mm.
Eigen::Matrix<double, 3, 2> Centres(const std::string& errors) {
  const machine::Machine machine = YaoMachine();
  session::Session planned;
  planned.header = {{"machine", machine.id},
                    {"session", "B"},
                    {"instrument", "centres"},
                    {"sigma_um", "1"},
                    {"tool_tip_mm", absl::StrCat("0 0 ", -kToolMm)},
                    {"table_ball_mm", "0 0 60"}};
  planned.columns = {{"t_s", {0, 1}, {}}, {"B_deg", {0, 90}, {}}, {"C_deg", {0, 0}, {}}};
  synthetic::NoiseOptions exact;
  exact.sigma_scale = 0.0;
  exact.draw_setup = false;
  const session::Session read =
      synthetic::Simulate(machine, machine::ReadErrors(errors, machine).value(), planned, exact).value();
  return instruments::BindSession(read, machine).value().measured_mm;
}

struct Differences {
  double lateral_um, length_um, y_um;
};
Differences Of(const std::string& errors) {
  const Eigen::Matrix<double, 3, 2> centres_mm = Centres(errors);
  const Eigen::Vector3d change_um = base::kUmPerMm * (centres_mm.col(1) - centres_mm.col(0));
  return {0.5 * (change_um.x() + change_um.z()), 0.5 * (change_um.z() - change_um.x()), -change_um.y()};
}

// lateral = dxBT - R b, length = dzBT, Y1 - Y2 = -R (aXB + gXB): whatever the datum, the sphere's place drops out.
// (5.19) prints the sum with the other sign, and (5.17) has no gXB.
TEST(YaoProbe, TheDatumFreeDifferences) {
  constexpr double kSecondOrderUm = 0.02;
  EXPECT_NEAR(Of(R"({"EX0T": 20})").lateral_um, 20.0, kSecondOrderUm);
  EXPECT_NEAR(Of(R"({"EB0B": 50})").lateral_um, -kToolMm * 0.05, kSecondOrderUm);
  EXPECT_NEAR(Of(R"({"EZ0T": 30})").length_um, 30.0, kSecondOrderUm);
  for (const char* const alone : {R"({"EA0B": 40})", R"({"EC0B": 40})"}) {
    EXPECT_NEAR(Of(alone).y_um, -kToolMm * 0.04, kSecondOrderUm) << alone;
    EXPECT_NEAR(Of(alone).lateral_um, 0.0, kSecondOrderUm) << alone;
  }
  // What is no part of them: where the table and its ball stand.
  const Differences place = Of(R"({"EX0C": 100, "EY0C": -80, "EA0C": 60, "EX0W": 30, "EZ0W": 25})");
  for (const double um : {place.lateral_um, place.length_um, place.y_um}) EXPECT_NEAR(um, 0.0, kSecondOrderUm);
}

// On a quarter turn a radius that is fixed leaks 0.78 of its error into both components; ours is free.
TEST(YaoProbe, AFixedRadiusLeaksIntoBothComponents) {
  constexpr int kSteps = 900;
  Eigen::MatrixX2d fixed(kSteps + 1, 2);
  for (int i = 0; i <= kSteps; ++i) {
    const double q = 90.0 * i / kSteps * base::kRadPerDeg;
    fixed.row(i) << std::sin(q), std::cos(q);
  }
  const Eigen::Vector2d leak = fixed.colPivHouseholderQr().solve(Eigen::VectorXd::Ones(kSteps + 1));
  constexpr double kPrinted = 0.005;
  ExpectPublished(leak[0], 0.78, kPrinted, "Yao 2022, ch. 2: leak of a fixed radius into sin, um per um");
  ExpectPublished(leak[1], 0.78, kPrinted, "Yao 2022, ch. 2: leak of a fixed radius into cos, um per um");

  const machine::Machine machine = YaoMachine();
  session::Session session;
  session.header = {{"machine", "mt"},
                    {"session", "BX"},
                    {"instrument", "eccentricity"},
                    {"sigma_um", "0.3"},
                    {"tool_tip_mm", "0 0 -356.4"},
                    {"table_ball_mm", "0 0 65.5"},
                    {"bar_length_mm", "100"},
                    {"path BX", "B 0 90 fixed 1 0 0"}};
  session.columns = {
      {"run", {}, {"BX"}}, {"sense", {1}, {}}, {"ex_um", {0}, {}}, {"ey_um", {NAN}, {}}, {"ez_um", {0}, {}}};
  const auto run = instruments::BindSession(session, machine);
  ASSERT_TRUE(run.ok()) << run.status();
  ASSERT_EQ(run->path_readings->readings.size(), 2u);
  for (const eccentricity::Reading& reading : run->path_readings->readings)
    EXPECT_NEAR(reading.weight.sum(), 0.0, 1e-12);
}

// Fig 5.13: the commanded directions meet at the nominal centre, 0.47 mm off the real one.
TEST(YaoProbe, CommandedDirectionsAreUpToThreeDegreesOffTheNormal) {
  std::ifstream file(base::SourcePath("/deploy/examples/integrex/fig-5.13-touch-log.txt"));
  ASSERT_TRUE(file.is_open());
  std::vector<Eigen::Vector3d> points_mm;
  for (std::string line; std::getline(file, line);) {
    std::erase(line, ' ');
    std::erase(line, '\r');
    Eigen::Vector3d point_mm;
    const size_t y = line.find('Y'), z = line.find('Z'), b = line.find('B');
    if (line[0] != 'X' || y == std::string::npos || z == std::string::npos) continue;
    point_mm << Number(line.substr(1, y - 1)), Number(line.substr(y + 1, z - y - 1)),
        Number(line.substr(z + 1, b - z - 1));
    points_mm.push_back(point_mm);
  }
  ASSERT_EQ(points_mm.size(), 21u);
  const auto sphere = touch::FitSphere(points_mm);
  ASSERT_TRUE(sphere.has_value());
  double largest_deg = 0.0;
  for (const Eigen::Vector3d& point_mm : points_mm) {
    const Eigen::Vector3d commanded = Eigen::Vector3d(-390, 0, -472) - point_mm, normal = sphere->centre_mm - point_mm;
    const double angle_rad = std::atan2(commanded.cross(normal).norm(), commanded.dot(normal));
    largest_deg = std::max(largest_deg, angle_rad * base::kDegPerRad);
  }
  constexpr double kPrinted = 0.05;
  ExpectPublished(largest_deg, 3.4, kPrinted, "Yao 2022, Fig 5.13: commanded directions off the normal, deg");
}

// "dxBT and dxCZ cannot be separated" is false with two tools: dxBT is what is left of BX at a tool of length 0. But
// poor: 10 um per um of noise.
TEST(YaoProbe, TwoToolsSeparateTheSpindlesOffsetPoorly) {
  const double tool_mm[] = {356.3945, 406.4608};  // Table 4.3
  Eigen::Matrix2d rows;                           // second eccentricity of BX: dxBT - R_B (bXB + bYZ)
  for (int i = 0; i < 2; ++i) rows.row(i) << 1.0, -tool_mm[i];
  const Eigen::Matrix2d covariance = (rows.transpose() * rows).inverse();
  EXPECT_NEAR(std::sqrt(covariance(0, 0)), 10.0, 1.5);

  const machine::Machine machine = YaoMachine();
  std::vector<session::Session> sessions;
  for (const double length_mm : tool_mm) {
    session::Session session;
    session.header = {{"machine", "mt"},
                      {"session", absl::StrCat("BX", length_mm)},
                      {"instrument", "eccentricity"},
                      {"sigma_um", "1"},
                      {"tool_tip_mm", absl::StrCat("0 0 ", -length_mm)},
                      {"table_ball_mm", "0 0 65.5"},
                      {"bar_length_mm", "100"},
                      {"path BX", "B 0 90 fixed 1 0 0"}};
    session.columns = {
        {"run", {}, {"BX"}}, {"sense", {1}, {}}, {"ex_um", {NAN}, {}}, {"ey_um", {NAN}, {}}, {"ez_um", {0}, {}}};
    sessions.push_back(std::move(session));
  }
  auto runs = identify::BindSessions(machine, sessions);
  ASSERT_TRUE(runs.ok()) << runs.status();
  for (instruments::MeasuringRun& run : *runs) {
    for (instruments::SetupParameter& parameter :
         run.setup) {  // the balls are set against each other, as the thesis does
      parameter.prior_sigma = 1e-9;
      parameter.is_weak = false;
    }
  }
  identify::Options options;
  options.model = machine::ReadErrors(R"({"EX0T": 0, "EB0B": 0})", machine).value();
  const auto fit = identify::FitRuns(machine, *runs, options);
  ASSERT_TRUE(fit.ok()) << fit.status();
  ASSERT_TRUE(fit->result.estimates[0].identifiable);
  EXPECT_NEAR(base::kUmPerMm * fit->result.estimates[0].sigma, std::sqrt(covariance(0, 0)), 0.01);
}

// Two tool lengths stand in the compensated program and in Table 4.3, 27.2 um apart: no printed digit of Table 4.5
// moves.
TEST(YaoProbe, TheTwoToolLengthsOfTable43) {
  const YaoTables m = ReadYaoTables();
  const double tool_mm = m.setups.at("BX").tool_length_mm, compensated_mm = 356.3673;
  ExpectPublished(base::kUmPerMm * (tool_mm - compensated_mm), 27.2, 0.05,
                  "Yao 2022, Table 4.3 and Fig 4.30: two tool lengths apart, um");
  const double e_mm = base::kMmPerUm * m.MeanUm("BX ez");
  EXPECT_NEAR(base::kArcsecPerRad * e_mm / tool_mm, base::kArcsecPerRad * e_mm / compensated_mm, 0.005);
}

}  // namespace
}  // namespace axiscal::known_answers
