#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "core/base/testing/source_path.h"
#include "core/instruments/evaluation.h"
#include "core/instruments/touch/sphere_fit.h"
#include "core/instruments/touch/touch_bind.h"
#include "core/instruments/touch/touch_model.h"
#include "core/machine/machine_json.h"
#include "core/machine/testing/machines.h"
#include "core/session/read_session.h"

namespace axiscal::touch {
namespace {

using ::testing::HasSubstr;

// Yao 2022, Fig 5.13: X, Y, Z of the 21 touches of a real DPRNT log at B0 C0.
const std::vector<Eigen::Vector3d> kFig513 = {
    {-390.0000, 0.0000, -464.5118},  {-392.3406, 0.0000, -464.7967},  {-394.5199, 0.0000, -465.7790},
    {-396.3313, 0.0000, -467.4001},  {-397.5836, 0.0000, -469.5359},  {-398.1191, 0.0000, -472.0000},
    {-390.0000, 2.3213, -464.8558},  {-390.0000, 4.4467, -465.8796},  {-390.0000, 6.1922, -467.5011},
    {-390.0000, 7.3864, -469.5999},  {-390.0000, 7.8969, -472.0000},  {-387.6988, 0.0000, -464.9178},
    {-385.6247, 0.0000, -465.9779},  {-383.9443, 0.0000, -467.6003},  {-382.7995, 0.0000, -469.6604},
    {-382.3193, 0.0000, -472.0000},  {-390.0000, -2.3213, -464.8558}, {-390.0000, -4.4467, -465.8796},
    {-390.0000, -6.1922, -467.5011}, {-390.0000, -7.3892, -469.5990}, {-390.0000, -7.8969, -472.0000}};

TEST(SphereFit, GivesTheSphereOfYaosLog) {
  const std::optional<Sphere> sphere = FitSphere(kFig513);
  ASSERT_TRUE(sphere.has_value());
  constexpr double kPrintedMm = 6e-5;  // four decimals
  EXPECT_NEAR(sphere->centre_mm.x(), -390.2175, kPrintedMm);
  EXPECT_NEAR(sphere->centre_mm.y(), -0.0005, kPrintedMm);
  EXPECT_NEAR(sphere->centre_mm.z(), -472.4176, kPrintedMm);
  EXPECT_NEAR(sphere->radius_mm, 7.9106, kPrintedMm);
  EXPECT_NEAR(sphere->rms_mm, 1.46e-3, 0.006e-3);
  EXPECT_NEAR(sphere->max_mm, 3.19e-3, 0.006e-3);
}

TEST(SphereFit, PointsOfOneCircleOrAFlatCapAreNoSphere) {
  EXPECT_FALSE(FitSphere({kFig513.begin(), kFig513.begin() + 4}).has_value());
  EXPECT_FALSE(FitSphere({kFig513.begin(), kFig513.begin() + 6}).has_value());  // all at Y = 0
  EXPECT_FALSE(FitSphere(std::vector<Eigen::Vector3d>(6, kFig513[0])).has_value());
}

// On the upper half of a sphere of 8 mm, evenly spread (golden spiral); every `bad_every`-th stands 0.1 mm and more
// inside, each by another amount.
std::vector<Eigen::Vector3d> HalfSphere(int count, int bad_every) {
  std::vector<Eigen::Vector3d> points_mm;
  for (int k = 0; k < count; ++k) {
    const double z = (k + 0.5) / count, turn = 2.39996322972865332 * k;
    const double bad_mm = bad_every > 0 && k % bad_every == bad_every / 2 ? 0.1 + 1.0 * k / count : 0.0;
    const double across = std::sqrt(1.0 - z * z);
    points_mm.push_back((8.0 - bad_mm) * Eigen::Vector3d(across * std::cos(turn), across * std::sin(turn), z));
  }
  return points_mm;
}

// A session may hold as many touches of one ball as it likes, a third of them bad: the number of spheres that are
// fitted for it does not grow with them.
TEST(SphereFit, OfMostFindsAllThatAreOffAtACostThatIsBounded) {
  for (const int count : {21, 64, 65, 1000, 100'000}) {
    const SphereOfMost judged = FitSphereOfMost(HalfSphere(count, 5), 0.020);
    EXPECT_LE(judged.fits, kMostSphereFits) << count;
    ASSERT_TRUE(judged.sphere.has_value()) << count;
    EXPECT_NEAR(judged.sphere->radius_mm, 8.0, 1e-9) << count;
    EXPECT_LT(judged.sphere->max_mm, 1e-9) << count;
    std::vector<size_t> off;
    for (const OffSphere& one : judged.off) {
      off.push_back(one.point);
      EXPECT_NEAR(one.off_mm, 0.1 + 1.0 * static_cast<double>(one.point) / count, 0.2) << count;
    }
    std::sort(off.begin(), off.end());
    std::vector<size_t> bad;
    for (int k = 2; k < count; k += 5) bad.push_back(static_cast<size_t>(k));
    EXPECT_EQ(off, bad) << count;
  }
}

// What agrees with nothing: all are tried, and no more than a third and one of a few are named.
TEST(SphereFit, OfMostOfPointsThatAgreeWithNothingIsBounded) {
  std::mt19937 random(5);
  for (const int count : {4, 5, 6, 9, 40, 64, 5000}) {
    std::vector<Eigen::Vector3d> points_mm;
    for (int k = 0; k < count; ++k) points_mm.push_back(Eigen::Vector3d(random() % 9000, random() % 9000, k) / 1000.0);
    const SphereOfMost judged = FitSphereOfMost(points_mm, 0.020);
    EXPECT_LE(judged.fits, kMostSphereFits) << count;
    EXPECT_LE(judged.off.size(), count <= 64 ? static_cast<size_t>(count / 3 + 1) : points_mm.size()) << count;
  }
  EXPECT_FALSE(FitSphereOfMost({}, 0.020).sphere.has_value());
}

// The log as a session of the machine it came from: the ball nominally at (-390, 0, -472); the stylus centre at home in
// the machine's origin, so that positions are places.
session::Session Fig513(double sphere_mm, double stylus_mm) {
  session::Session session;
  session.header = {{"machine", "mt"},
                    {"session", "log"},
                    {"instrument", "touch"},
                    {"sigma_um", "1.5"},
                    {"tool_tip_mm", "0 0 0"},
                    {"stylus_radius_mm", absl::StrCat(stylus_mm)},
                    {"sphere ball", absl::StrCat("-390 0 -472 ", sphere_mm)}};
  for (const char* name : {"t_s", "X_mm", "Y_mm", "Z_mm", "B_deg", "C_deg", "nx", "ny", "nz", "feature"})
    session.columns.push_back({name, {}, {}});
  for (size_t k = 0; k < kFig513.size(); ++k) {
    const Eigen::Vector3d approach = (Eigen::Vector3d(-390, 0, -472) - kFig513[k]).normalized();
    session.columns[0].values.push_back(static_cast<double>(k));
    for (int i = 0; i < 3; ++i) session.columns[1 + i].values.push_back(kFig513[k][i]);
    for (int i = 0; i < 2; ++i) session.columns[4 + i].values.push_back(0.0);
    for (int i = 0; i < 3; ++i) session.columns[6 + i].values.push_back(approach[i]);
    session.columns[9].texts.push_back("ball");
  }
  return session;
}

std::string Refusal(const session::Session& session) {
  const auto run = instruments::BindSession(session, machine::testing::MultiTasking());
  return run.ok() ? "accepted" : std::string(run.status().message());
}

std::vector<Rejection> Rejected(const session::Session& session) {
  const auto run = instruments::BindSession(session, machine::testing::MultiTasking());
  EXPECT_TRUE(run.ok()) << run.status();
  return run.ok() ? run->touches.rejected : std::vector<Rejection>();
}

TEST(TouchGates, TheRightStylusPassesAndTheWrongOneIsNamed) {
  EXPECT_EQ(Refusal(Fig513(5.0, 2.9106)), "accepted");
  EXPECT_EQ(Refusal(Fig513(5.0, 2.9306)), "accepted");  // at the gate
  EXPECT_THAT(Refusal(Fig513(5.0, 3.0)),
              HasSubstr("the 21 touches of sphere 'ball' from reading 1 lie on a radius of 7.9106 mm, expected 8.0000 "
                        "(sphere 5 + stylus_radius_mm 3) within radius_gate_um = 20"));
  session::Session wider = Fig513(5.0, 3.0);
  wider.header.push_back({"radius_gate_um", "100"});
  EXPECT_EQ(Refusal(wider), "accepted");
  for (const char* text : {"abc", "0", "-20", "nan", "20 um"}) {
    wider.header.back().value = text;
    EXPECT_THAT(Refusal(wider), HasSubstr(absl::StrCat("'radius_gate_um: ", text, "', expected"))) << text;
  }
}

TEST(TouchGates, RepeatsThatScatterAreRejectedAndNamed) {
  session::Session session = Fig513(5.0, 2.9106);
  for (session::Column& column : session.columns) {
    if (column.texts.empty()) column.values.push_back(column.values[5]);
  }
  session.columns[9].texts.push_back("ball");
  EXPECT_TRUE(Rejected(session).empty());
  // Along the approach, which meets X at almost no angle. Of two nobody can say which is wrong.
  for (int i = 0; i < 3; ++i) session.columns[1 + i].values.back() += 0.021 * session.columns[6 + i].values.back();
  std::vector<Rejection> rejected = Rejected(session);
  ASSERT_EQ(rejected.size(), 2u);
  EXPECT_EQ(rejected[0].reading, 5);
  EXPECT_EQ(rejected[1].reading, 21);
  EXPECT_EQ(rejected[1].gate, "repeat");
  EXPECT_NEAR(rejected[1].off_mm, 0.021, 1e-9);
  EXPECT_EQ(rejected[1].limit_mm, 0.020);
  // A third one tells.
  for (session::Column& column : session.columns) {
    if (column.texts.empty()) column.values.push_back(column.values[5]);
  }
  session.columns[9].texts.push_back("ball");
  rejected = Rejected(session);
  ASSERT_EQ(rejected.size(), 1u);
  EXPECT_EQ(rejected[0].reading, 21);
  session.header.push_back({"repeat_gate_um", "25"});
  EXPECT_TRUE(Rejected(session).empty());
}

// A table that moves under the probe: four places on a plate that stands askew, 20 mm apart, are no repeats.
TEST(TouchGates, PlacesThatTheTableMovesToAreNoRepeats) {
  session::Session session;
  session.header = {{"machine", "ht"},        {"session", "plate"},      {"instrument", "touch"},     {"sigma_um", "1"},
                    {"tool_tip_mm", "0 0 0"}, {"stylus_radius_mm", "3"}, {"plane top", "0 0 0 0 0 1"}};
  const double x_mm[] = {-10, 10, -10, 10, -10}, y_mm[] = {-10, -10, 10, 10, -10}, z_mm[] = {3.0, 3.4, 3.1, 3.5, 3.1};
  for (const char* name : {"t_s", "X_mm", "Y_mm", "Z_mm", "B_deg", "C_deg", "nx", "ny", "nz", "feature"})
    session.columns.push_back({name, {}, {}});
  for (int k = 0; k < 5; ++k) {
    const double values[] = {10.0 * k, x_mm[k], y_mm[k], z_mm[k], 0, 0, 0, 0, -1};
    for (int i = 0; i < 9; ++i) session.columns[i].values.push_back(values[i]);
    session.columns[9].texts.push_back("top");
  }
  const auto run = instruments::BindSession(session, machine::testing::SwivelHead());
  ASSERT_TRUE(run.ok()) << run.status();
  // The last is a repeat of the first, 0.1 mm off it.
  ASSERT_EQ(run->touches.rejected.size(), 2u);
  EXPECT_EQ(run->touches.rejected[0].reading, 0);
  EXPECT_EQ(run->touches.rejected[1].reading, 4);
  EXPECT_NEAR(run->touches.rejected[0].off_mm, 0.1, 1e-9);
}

// 900 places 2 mm apart, each touched three times, round after round; the control stands some 4 um aside of its place.
TEST(TouchGates, RepeatsAreFoundAmongManyPlaces) {
  session::Session session;
  session.header = {{"machine", "mt"},        {"session", "plate"},      {"instrument", "touch"},     {"sigma_um", "1"},
                    {"tool_tip_mm", "0 0 0"}, {"stylus_radius_mm", "3"}, {"plane top", "0 0 0 0 0 1"}};
  for (const char* name : {"t_s", "X_mm", "Y_mm", "Z_mm", "B_deg", "C_deg", "nx", "ny", "nz", "feature"})
    session.columns.push_back({name, {}, {}});
  constexpr int kPlaces = 900;
  for (int k = 0; k < 3 * kPlaces; ++k) {
    const int place = k % kPlaces, repeat = k / kPlaces, column = place % 30, row = place / 30;
    const double aside_mm = 0.003 * (repeat - 1);
    const double values[] = {1.0 * k, 2.0 * column + aside_mm, 2.0 * row - aside_mm, 3.0, 0, 0, 0, 0, -1};
    for (int i = 0; i < 9; ++i) session.columns[i].values.push_back(values[i]);
    session.columns[9].texts.push_back("top");
  }
  EXPECT_TRUE(Rejected(session).empty());
  session.columns[3].values[kPlaces + 437] += 0.030;
  const std::vector<Rejection> rejected = Rejected(session);
  ASSERT_EQ(rejected.size(), 1u);
  EXPECT_EQ(rejected[0].reading, kPlaces + 437);
  EXPECT_NEAR(rejected[0].off_mm, 0.030, 1e-9);
}

TEST(TouchGates, OneTouchOfAChipIsRejectedAndNamed) {
  session::Session session = Fig513(5.0, 2.9106);
  for (int i = 0; i < 3; ++i) session.columns[1 + i].values[7] -= 0.060 * session.columns[6 + i].values[7];
  const std::vector<Rejection> rejected = Rejected(session);
  ASSERT_EQ(rejected.size(), 1u);
  EXPECT_EQ(rejected[0].reading, 7);
  EXPECT_EQ(rejected[0].gate, "sphere");
  EXPECT_NEAR(rejected[0].off_mm, 0.060, 0.015);  // the log's own scatter, carried to the touch
  // Many chips are no chips.
  for (const int k : {1, 3, 9, 12, 14, 16, 19}) {
    for (int i = 0; i < 3; ++i) session.columns[1 + i].values[k] -= (0.3 + 0.2 * k) * session.columns[6 + i].values[k];
  }
  EXPECT_THAT(Refusal(session), ::testing::AnyOf(HasSubstr("fail a gate"), HasSubstr("lie on a radius")));
}

TEST(TouchGates, APartOfASessionCountsFromItsBegin) {
  session::Session far = Fig513(5.0, 2.9106);
  far.columns[3].values[4] += 40.0;
  const auto run = instruments::BindSession(far, machine::testing::MultiTasking(), 100);
  EXPECT_THAT(std::string(run.status().message()), HasSubstr("reading 105 stands"));
  far.columns[8].values[0] = 1.0;
  far.columns[3].values[4] -= 40.0;
  EXPECT_THAT(std::string(instruments::BindSession(far, machine::testing::MultiTasking(), 100).status().message()),
              HasSubstr("reading 101 approaches"));
  EXPECT_THAT(
      std::string(instruments::BindSession(Fig513(5.0, 3.0), machine::testing::MultiTasking(), 7).status().message()),
      HasSubstr("from reading 8 lie on a radius"));
}

TEST(TouchGates, TouchesOfAnotherFeatureAreRefused) {
  session::Session far = Fig513(5.0, 2.9106);
  far.columns[3].values[4] += 40.0;
  EXPECT_THAT(Refusal(far), HasSubstr("reading 5 stands"));
  session::Session backwards = Fig513(5.0, 2.9106);
  backwards.columns[8].values[0] = 1.0;
  EXPECT_THAT(Refusal(backwards), HasSubstr("reading 1 approaches feature 'ball' at 180 deg to its inward normal"));
  session::Session unknown = Fig513(5.0, 2.9106);
  unknown.columns[9].texts[2] = "bal";
  EXPECT_THAT(Refusal(unknown), HasSubstr("reading 3: feature 'bal' has no header"));
  session::Session no_unit = Fig513(5.0, 2.9106);
  no_unit.columns[6].values[0] = 0.5;
  EXPECT_THAT(Refusal(no_unit), HasSubstr("expected a unit vector"));
}

// A face 10 mm above the table's origin, a stylus of 3 mm: the gap is what the tip stands above 13 mm.
// Three columns on a tilting table, deploy/examples/ibaraki-columns.
absl::Status BindColumns(const std::function<void(session::Session*)>& change) {
  const std::string folder = base::SourcePath("/deploy/examples/ibaraki-columns/");
  const machine::Machine machine = machine::ReadMachineFile(folder + "machine.json").value();
  session::Session session = session::ReadSessionFile(folder + "fit/columns.csv").value();
  change(&session);
  return instruments::BindSession(session, machine).status();
}

TEST(TouchGates, ATouchOfTheNextColumnsTopIsRefused) {
  const absl::Status status = BindColumns([](session::Session* session) {
    for (session::Column& column : session->columns)
      if (column.name == "X_mm") column.values[0] = 150.0;
  });
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("reading 1 of feature 'column1top' stands 299.8 mm aside"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("'column2top'"));
}

TEST(Touch, APlaneReadsTheGapAlongItsNormal) {
  session::Session session = Fig513(5.0, 3.0);
  session.header.back() = {"plane ball", "1 2 10 0 0 2"};
  for (session::Column& column : session.columns) {
    if (!column.texts.empty()) {
      column.texts.resize(1);
      continue;
    }
    column.values = {column.name == "Z_mm" ? 13.25 : column.name == "nz" ? -1.0 : 0.0};
  }
  const machine::Machine machine = machine::testing::MultiTasking();
  const auto run = instruments::BindSession(session, machine);
  ASSERT_TRUE(run.ok()) << run.status();
  const double setup[] = {0, 0, 0.05, 0, 0, 0};
  double gap_mm = NAN;
  instruments::Predict(machine, *run, 0, {}, setup, &gap_mm);
  EXPECT_NEAR(gap_mm, 0.20, 1e-12);
}

// A header says how well the features are known: each then stands out by a set-up offset of its own, before the
// datum's.
TEST(Touch, FeaturesStandOutByOffsetsOfTheirOwn) {
  const std::string folder = base::SourcePath("/deploy/examples/ibaraki-columns/");
  const machine::Machine machine = machine::ReadMachineFile(folder + "machine.json").value();
  session::Session session = session::ReadSessionFile(folder + "fit/columns.csv").value();
  session.header.push_back({"datum", "free X"});
  const auto exact = instruments::BindSession(session, machine);
  ASSERT_TRUE(exact.ok()) << exact.status();
  EXPECT_EQ(FeatureOffsets(*exact), 0);
  session.header.push_back({"feature_sigma_um", "1.5"});
  const auto run = instruments::BindSession(session, machine);
  ASSERT_TRUE(run.ok()) << run.status();
  const int features = static_cast<int>(run->touches.features.size());
  ASSERT_EQ(features, 15);
  ASSERT_EQ(FeatureOffsets(*run), features);
  ASSERT_EQ(run->setup.size(), exact->setup.size() + 15);
  EXPECT_EQ(run->setup.back().name, "datum_X");
  for (int k = 0; k < features; ++k) {
    const instruments::SetupParameter& offset = run->setup[static_cast<size_t>(kPlaceOffsets + k)];
    EXPECT_EQ(offset.name, "feature_" + run->touches.features[static_cast<size_t>(k)].name);
    EXPECT_EQ(offset.prior_sigma, 1.5e-3);
    EXPECT_FALSE(offset.is_weak);
  }
  double setup[instruments::kMaxSetupParameters] = {0.1, -0.2, 0.3, 0.001, -0.002, 0.003}, before = NAN, after = NAN;
  instruments::Evaluation evaluation;
  for (const int reading : {0, 7, 200}) {
    const int at = kPlaceOffsets + run->touches.feature_of[static_cast<size_t>(reading)];
    instruments::Predict(machine, *run, reading, {}, setup, &before);
    setup[at] = 2e-3;
    instruments::Predict(machine, *run, reading, {}, setup, &after);
    instruments::Evaluate(machine, *run, reading, {}, setup, &evaluation);
    setup[at] = 0.0;
    EXPECT_NEAR(after - before, -2e-3, 1e-12);  // the stylus stops earlier
    EXPECT_NEAR(evaluation.predicted_mm[0], after, 1e-12);
    ASSERT_EQ(evaluation.by_setup.cols(), static_cast<Eigen::Index>(run->setup.size()));
    for (int k = 0; k < features; ++k)
      EXPECT_EQ(evaluation.by_setup(0, kPlaceOffsets + k), kPlaceOffsets + k == at ? -1 : 0);
  }
}

TEST(Touch, HowWellFeaturesAreKnownIsANumberAboveZero) {
  for (const char* value : {"0", "-1", "1 2", "one", "inf"}) {
    const absl::Status status = BindColumns([&](session::Session* session) {
      session->header.push_back({"feature_sigma_um", value});
    });
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << value;
    EXPECT_THAT(std::string(status.message()), HasSubstr(absl::StrCat("feature_sigma_um: ", value)));
  }
}

}  // namespace
}  // namespace axiscal::touch
