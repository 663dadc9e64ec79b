// Sphere centres that a probe measured on an INTEGREX i-200 (Yao 2022, Table 5.2; deploy/examples/integrex): the ladder
// from the nominal machine to the one that explains the readings, and what the C set-up says.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/testing/source_path.h"
#include "core/base/units.h"
#include "core/identify/identify.h"
#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"
#include "core/session/case.h"
#include "tests/known_answers/published.h"

namespace axiscal::known_answers {
namespace {

using base::kUmPerMm;

const std::string& Folder() {
  static const auto& folder = *new std::string(base::SourcePath("/deploy/examples/integrex/"));
  return folder;
}

class Integrex : public testing::Test {
 protected:
  void SetUp() override { machine_ = machine::ReadMachineFile(Folder() + "machine.json").value(); }

  std::vector<instruments::MeasuringRun> Runs(const std::vector<std::string>& names) const {
    std::vector<session::Session> sessions;
    for (const std::string& name : names) {
      sessions.push_back(session::ReadSessionFileOf(Folder() + name + ".csv", machine_).value());
    }
    return identify::BindSessions(machine_, sessions).value();
  }
  std::vector<instruments::MeasuringRun> BRuns() const {
    return Runs({"B-short-run1", "B-short-run2", "B-long-run1", "B-long-run2"});
  }
  identify::Fit Fit(const std::vector<instruments::MeasuringRun>& runs, const std::string& errors) const {
    identify::Options options;
    options.model = machine::ReadErrors(errors, machine_).value();
    return identify::FitRuns(machine_, runs, options).value();
  }
  double RmsUm(const std::string& errors) const { return kUmPerMm * Fit(BRuns(), errors).result.fit.rms_mm; }

  machine::Machine machine_;
};

constexpr double kShare = 0.01;
void ExpectRms(double ours_um, double published_um, const std::string& what) {
  ExpectPublished(ours_um, published_um, kShare * published_um, "Yao 2022, Table 5.2, rms: " + what + ", um");
}

TEST_F(Integrex, NominalMachineAndNominalSphere) {
  const identify::Problem problem = identify::MakeProblem(machine_, BRuns()).value();
  double squares = 0.0;
  int numbers = 0;
  for (const Eigen::MatrixXd& residual : identify::ResidualsOf(problem, identify::StartingPoint(problem, {}))) {
    squares += residual.squaredNorm();
    numbers += static_cast<int>(residual.size());
  }
  EXPECT_EQ(numbers, 24);
  ExpectRms(kUmPerMm * std::sqrt(squares / numbers), 1840.0, "nominal machine, nominal sphere");
}

TEST_F(Integrex, LadderOfTheBSetUps) {
  ExpectRms(RmsUm("{}"), 1299.0, "sphere free");
  ExpectRms(RmsUm(R"({"EZ0T": 0})"), 19.6, "and EZ0T");
  ExpectRms(RmsUm(R"({"EZ0T": 0, "EX0T": 0})"), 12.2, "and EX0T");
  ExpectRms(RmsUm(R"({"EZ0T": 0, "EX0T": 0, "EA0B": 0, "EC0B": 0})"), 2.97, "and EA0B, EC0B");
}

// The rungs below the sphere's place: one error of the machine alone, the sphere where it is stated.
TEST_F(Integrex, OneErrorAloneOnTheNominalSphere) {
  std::vector<instruments::MeasuringRun> runs = BRuns();
  for (instruments::MeasuringRun& run : runs) {
    for (instruments::SetupParameter& parameter : run.setup) {
      parameter.prior_sigma = 1e-9;
      parameter.is_weak = false;
    }
  }
  ExpectRms(kUmPerMm * Fit(runs, R"({"EX0B": 0, "EZ0B": 0})").result.fit.rms_mm, 1299.0, "B's place alone");
  ExpectRms(kUmPerMm * Fit(runs, R"({"EZ0T": 0})").result.fit.rms_mm, 1589.0, "tool or pivot length alone");
}

// Two probes, two lengths. A session's temperature says which probe it was (one degree more with the long one), so that
// a thermal EZ0T is the difference of their lengths: the published model of two lengths without a second joint.
TEST_F(Integrex, LengthsOfTheTwoProbesApart) {
  std::vector<instruments::MeasuringRun> runs = BRuns();
  for (instruments::MeasuringRun& run : runs) {
    const bool is_long = run.session.starts_with("B-long");
    run.has_temperature = true;
    run.temperature_celsius.assign(run.temperature_celsius.size(),
                                   shapes::kReferenceTemperatureCelsius + (is_long ? 1.0 : 0.0));
  }
  const identify::Fit fit = Fit(runs, R"({"EZ0T": 0, "EX0T": 0, "EA0B": 0, "EC0B": 0,
      "terms": [{"symbol": "EZT", "shape": "thermal", "amplitude": 0}]})");
  ExpectRms(kUmPerMm * fit.result.fit.rms_mm, 2.53, "and the probes' lengths apart");
}

// A place of the sphere for each run (it wandered by up to 10.6 um from one run to the next) and each probe's own
// errors leave what the runs do not repeat.
TEST_F(Integrex, DriftFromRunToRun) {
  std::vector<session::Session> sessions;
  for (const char* name : {"B-short-run1", "B-short-run2", "B-long-run1", "B-long-run2"}) {
    sessions.push_back(session::ReadSessionFileOf(Folder() + name + ".csv", machine_).value());
    std::erase_if(sessions.back().header, [](const session::HeaderEntry& entry) { return entry.key == "setup"; });
  }
  std::vector<instruments::MeasuringRun> runs = identify::BindSessions(machine_, sessions).value();
  double largest_mm = 0.0;
  for (const int run : {0, 2})
    largest_mm = std::max(largest_mm, (runs[run + 1].measured_mm - runs[run].measured_mm).cwiseAbs().maxCoeff());
  ExpectPublished(kUmPerMm * largest_mm, 10.6, 0.05, "Yao 2022, Table 5.2: largest drift from run to run, um");
  for (instruments::MeasuringRun& run : runs) {
    const bool is_long = run.session.starts_with("B-long");
    run.has_temperature = true;
    run.temperature_celsius.assign(run.temperature_celsius.size(),
                                   shapes::kReferenceTemperatureCelsius + (is_long ? 1.0 : 0.0));
  }
  const identify::Fit fit = Fit(runs, R"({"EZ0T": 0, "EX0T": 0, "EA0B": 0, "EC0B": 0,
      "terms": [{"symbol": "EZT", "shape": "thermal", "amplitude": 0},
                {"symbol": "EXT", "shape": "thermal", "amplitude": 0},
                {"symbol": "EAB", "shape": "thermal", "amplitude": 0}]})");
  ExpectPublished(kUmPerMm * fit.result.fit.rms_mm, 0.25, 0.01,
                  "Yao 2022, Table 5.2, rms: and each run's place, each probe's own errors, um");
}

// Differences between B = 0 and 90 that no datum moves, mean of all runs:
//   lateral dxBT = [(X2-X1)+(Z2-Z1)]/2    length dzBT = [(Z2-Z1)-(X2-X1)]/2    Y1-Y2 = -R (aXB + gXB)
TEST_F(Integrex, EstimatesFollowFromTheDifferences) {
  const auto runs = BRuns();
  double lateral_mm = 0.0, length_mm = 0.0, turn = 0.0, weight = 0.0;
  for (const instruments::MeasuringRun& run : runs) {
    ASSERT_EQ(run.reading_count(), 2);
    const Eigen::Vector3d change_mm = run.measured_mm.col(1) - run.measured_mm.col(0);
    lateral_mm += 0.5 * (change_mm.x() + change_mm.z()) / static_cast<double>(runs.size());
    length_mm += 0.5 * (change_mm.z() - change_mm.x()) / static_cast<double>(runs.size());
  }
  for (const instruments::MeasuringRun& run : runs) {
    const double radius_mm = -run.tip_mm.z() - length_mm;  // the length error is a hundredth of it
    turn += radius_mm * (run.measured_mm(1, 1) - run.measured_mm(1, 0));
    weight += radius_mm * radius_mm;
  }
  const identify::Result result = Fit(runs, R"({"EZ0T": 0, "EX0T": 0, "EA0B": 0, "EC0B": 0})").result;
  constexpr double kToleranceMm = 5e-5, kToleranceRad = 2e-8;  // 0.1 mrad of the length error, and the weak priors
  EXPECT_NEAR(result.estimates[0].value, length_mm, kToleranceMm);
  EXPECT_NEAR(result.estimates[1].value, lateral_mm, kToleranceMm);
  // From two positions of B their sum only: named, not split.
  ASSERT_EQ(result.determined.size(), 1u);
  EXPECT_EQ(result.determined[0].name, "EA0B + EC0B");
  EXPECT_EQ(result.not_separable, std::vector<std::string>{"EA0B - EC0B"});
  EXPECT_FALSE(result.estimates[2].identifiable);
  EXPECT_NEAR(result.determined[0].value, turn / weight, kToleranceRad);
}

// The C set-up: where the circle's centre stands at the sphere's height, its radius and the tilt of C.
TEST_F(Integrex, CentreRadiusAndTiltOfTheCSetUp) {
  const identify::Result result =
      Fit(Runs({"C-run1", "C-run2"}), R"({"EX0C": 0, "EY0C": 0, "EA0C": 0, "EB0C": 0})").result;
  EXPECT_EQ(result.rank, 4);
  const double x_mm = result.estimates[0].value, y_mm = result.estimates[1].value;
  const double a_rad = result.estimates[2].value, b_rad = result.estimates[3].value;
  constexpr double kSphereHeightMm = -472.0, kCentreXMm = -490.0, kRadiusMm = 100.0;
  constexpr double kPrintedMm = 5e-5, kPrintedArcsec = 0.005 + 0.01;  // half the last digit; the sphere's mounting
  const std::string table = "Yao 2022, Table 5.2, C set-up: ";
  ExpectPublished(kCentreXMm + x_mm + b_rad * kSphereHeightMm, -489.7202, kPrintedMm, table + "circle's centre X, mm");
  ExpectPublished(y_mm - a_rad * kSphereHeightMm, -0.0188, kPrintedMm, table + "circle's centre Y, mm");
  ExpectPublished(a_rad * base::kArcsecPerRad, 4.40, kPrintedArcsec, table + "tilt about X, arcsec");
  ExpectPublished(b_rad * base::kArcsecPerRad, -30.46, kPrintedArcsec, table + "tilt about Y, arcsec");
  const auto& setup = result.sessions[0].setup;
  EXPECT_EQ(setup[0].name, "ball_x");
  ExpectPublished(std::hypot(kRadiusMm + setup[0].value, setup[1].value), 99.7194, kPrintedMm,
                  table + "circle's radius, mm");
  EXPECT_LT(kUmPerMm * result.fit.rms_mm, 1.0);
}

}  // namespace
}  // namespace axiscal::known_answers
