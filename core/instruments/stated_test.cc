// What headers state of warmth and certificates, by hand.
#include "core/instruments/stated.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/instruments/evaluation.h"
#include "core/machine/testing/machines.h"
#include "core/session/validate.h"

namespace axiscal::instruments {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr double kFirstOrderMm = 1e-9;  // nothing here is beyond it

machine::Machine Multi() { return machine::testing::MultiTasking(); }

struct Stated {
  std::string instrument;
  std::vector<session::HeaderEntry> header;
  std::vector<std::pair<std::string, std::vector<double>>> columns;  // axes that are missing stand at 0
  std::vector<std::string> readings;
};

session::Session SessionOf(const Stated& stated) {
  session::Session session;
  session.header = {{"machine", "mt"},
                    {"session", "S"},
                    {"instrument", stated.instrument},
                    {"sigma_um", "1"},
                    {"tool_tip_mm", "0 0 -150"}};
  session.header.insert(session.header.end(), stated.header.begin(), stated.header.end());
  const size_t count = stated.columns.front().second.size();
  for (const machine::Axis& axis : Multi().axes)
    session.columns.push_back(
        {axis.name + (axis.kind == machine::AxisKind::kLinear ? "_mm" : "_deg"), std::vector<double>(count, 0.0), {}});
  for (const auto& [name, values] : stated.columns) {
    const auto found = std::find_if(session.columns.begin(), session.columns.end(),
                                    [&name = name](const session::Column& one) { return one.name == name; });
    if (found != session.columns.end()) {
      found->values = values;
    } else {
      session.columns.push_back({name, values, {}});
    }
  }
  for (const std::string& name : stated.readings)
    session.columns.push_back({name, std::vector<double>(count, 0.0), {}});
  return session;
}

absl::StatusOr<MeasuringRun> BoundOf(const Stated& stated) {
  const session::Session session = SessionOf(stated);
  RETURN_IF_ERROR(session::Validate(session));
  return BindSession(session, Multi());
}

double Difference(const MeasuringRun& run, int reading, int row = 0) {
  MeasuringRun without = run;
  without.stated_mm.resize(0, 0);
  const double no_setup[kMaxSetupParameters] = {};
  double with_mm[kMaxRows], without_mm[kMaxRows];
  Predict(Multi(), run, reading, machine::JointErrors<double>(), no_setup, with_mm);
  Predict(Multi(), without, reading, machine::JointErrors<double>(), no_setup, without_mm);
  Evaluation evaluation;
  Evaluate(Multi(), run, reading, machine::JointErrors<double>(), no_setup, &evaluation);
  EXPECT_NEAR(evaluation.predicted_mm[row], with_mm[row], 1e-12);
  return with_mm[row] - without_mm[row];
}

Stated Bar() {
  return {"ballbar",
          {{"table_ball_mm", "0 0 -150"}, {"bar_length_mm", "150"}},
          {{"X_mm", {150, 0, -150}}, {"Y_mm", {0, 150, 0}}, {"temp_C", {20, 25, 15}}},
          {"dL_mm"}};
}

// A steel bar of 150 mm at 25 deg C is 150 x 11.5e-6 x 5 = 8.625 um longer, and shows so much less; its coefficient is
// known to 0.5: 0.375 um; a thermometer that is off by 0.2 K makes 150 x 11.5e-6 x 0.2 = 0.345 um.
TEST(Stated, ABarThatIsWarm) {
  Stated bar = Bar();
  bar.header.insert(bar.header.end(), {{"expansion bar", "11.5 0.5"}, {"temperature_sigma_K", "0.2"}});
  const auto run = BoundOf(bar);
  ASSERT_TRUE(run.ok()) << run.status();
  EXPECT_NEAR(Difference(*run, 0), 0.0, kFirstOrderMm);
  EXPECT_NEAR(Difference(*run, 1), -8.625e-3, kFirstOrderMm);
  EXPECT_NEAR(Difference(*run, 2), +8.625e-3, kFirstOrderMm);
  ASSERT_THAT(run->stated, SizeIs(2));
  EXPECT_EQ(run->stated[0].of, "expansion of bar, 11.5 +- 0.5 um/(m K)");
  EXPECT_NEAR(run->stated[0].by_sigma_mm(0, 1), -0.375e-3, kFirstOrderMm);
  EXPECT_EQ(run->stated[1].of, "thermometer of temp_C, +- 0.2 K");
  EXPECT_NEAR(run->stated[1].by_sigma_mm(0, 0), -0.345e-3, kFirstOrderMm);
}

TEST(Stated, ATemperatureInFahrenheitIsRefused) {
  Stated bar = Bar();
  bar.header.insert(bar.header.end(), {{"expansion bar", "11.5 0.5"}});
  bar.columns[2].second = {68, 77.6, 59};
  EXPECT_THAT(std::string(BoundOf(bar).status().message()),
              HasSubstr("reading 1: temp_C = 68, expected within 40 K of 20 deg C where a length grows with it "
                        "(expansion of bar, 11.5 +- 0.5 um/(m K)): is it in Fahrenheit"));
}

// The certified length takes the nominal one's place, and is what grows.
TEST(Stated, ABarWithACertificate) {
  Stated bar = Bar();
  bar.header.insert(bar.header.end(), {{"certificate bar_length", "4711 due 2027-01-31 value 150.02 mm U 0.8 um k 2"},
                                       {"started", "2026-06-01T08:00:00Z"},
                                       {"expansion bar", "11.5 0"}});
  const auto run = BoundOf(bar);
  ASSERT_TRUE(run.ok()) << run.status();
  EXPECT_EQ(run->bar_length_mm, 150.02);
  EXPECT_NEAR(run->stated[0].by_sigma_mm(0, 0), -0.4e-3, kFirstOrderMm);
  EXPECT_NEAR(Difference(*run, 1), -150.02 * 11.5e-6 * 5, kFirstOrderMm);
  EXPECT_EQ(run->setup[5].name, "bar_length");
  EXPECT_EQ(run->setup[5].held, 0.0);
  ASSERT_THAT(run->certificates, SizeIs(1));
  EXPECT_LT(*run->started, run->certificates[0].valid_until);
  bar.header.push_back({"bar_length_sigma_um", "0.2"});  // what each mounting adds
  EXPECT_FALSE(BoundOf(bar)->setup[5].held.has_value());
  bar.header[2].value = "4711 due 2027-01-31 value 100.02 mm U 0.8 um k 2";
  EXPECT_THAT(std::string(BoundOf(bar).status().message()), HasSubstr("100.0200 mm, expected within 1 mm of"));
}

// The X scale at 25 deg C puts the tool at 200 (1 + 8e-6 x 5) = 200 mm + 8 um: an R-test shows it along X.
TEST(Stated, AScaleThatIsWarm) {
  const Stated rtest = {"rtest",
                        {{"table_ball_mm", "0 0 -150"}, {"expansion scale X", "8 1 T_x_C"}},
                        {{"X_mm", {200, -100}}, {"T_x_C", {25, 30}}},
                        {"dx_mm", "dy_mm", "dz_mm"}};
  const auto run = BoundOf(rtest);
  ASSERT_TRUE(run.ok()) << run.status();
  EXPECT_NEAR(Difference(*run, 0), 8e-3, kFirstOrderMm);
  EXPECT_NEAR(Difference(*run, 1), -8e-3, kFirstOrderMm);
  EXPECT_NEAR(Difference(*run, 0, 1), 0.0, kFirstOrderMm);
  EXPECT_NEAR(run->stated[0].by_sigma_mm(0, 0), 1e-3, kFirstOrderMm);
  Stated other = rtest;
  other.header[1].key = "expansion scale C";
  EXPECT_THAT(std::string(BoundOf(other).status().message()), HasSubstr("C is no linear axis of machine mt"));
  other.header[1] = {"expansion scale X", "8 1 T_y_C"};
  EXPECT_THAT(std::string(BoundOf(other).status().message()),
              HasSubstr("needs the temperature column T_y_C, which is missing"));
}

// A draw wire of hypot(300, 400) = 500 mm at 30 deg C: 500 x 16e-6 x 10 = 80 um longer, shows so much less; a scale
// that reads 100 um/m too much shows 50 um more.
TEST(Stated, AWireThatIsWarmAndOneWithACertificate) {
  Stated wire = {"length",
                 {{"anchor_mm", "0 300 -150"}, {"expansion instrument", "16 1"}},
                 {{"X_mm", {400}}, {"temp_C", {30}}},
                 {"L_mm"}};
  const auto run = BoundOf(wire);
  ASSERT_TRUE(run.ok()) << run.status();
  EXPECT_NEAR(Difference(*run, 0), -80e-3, kFirstOrderMm);
  EXPECT_NEAR(run->stated[0].by_sigma_mm(0, 0), -5e-3, kFirstOrderMm);
  wire.header[1] = {"certificate scale", "7 due 2027-01-31 value 100 um/m U 20 um/m k 2"};
  const auto certified = BoundOf(wire);
  ASSERT_TRUE(certified.ok()) << certified.status();
  EXPECT_NEAR(Difference(*certified, 0), 50e-3, kFirstOrderMm);
  EXPECT_NEAR(certified->stated[0].by_sigma_mm(0, 0), 5e-3, kFirstOrderMm);
}

// Two faces of an aluminium block 200 mm apart, at 30 deg C: each goes out by 100 x 23e-6 x 10 = 23 um from the middle,
// so that a touch at the nominal place has a gap that is smaller by so much.
TEST(Stated, AnArtefactThatIsWarm) {
  Stated block = {"touch",
                  {{"stylus_radius_mm", "3"},
                   {"plane left", "-100 0 0 -1 0 0"},
                   {"plane right", "100 0 0 1 0 0"},
                   {"expansion artefact", "23 1"}},
                  {{"X_mm", {-103, 103}},
                   {"Z_mm", {150, 150}},
                   {"temp_C", {30, 30}},
                   {"nx", {1, -1}},
                   {"ny", {0, 0}},
                   {"nz", {0, 0}}},
                  {}};
  session::Session session = SessionOf(block);
  session.columns.push_back({"feature", {}, {"left", "right"}});
  ASSERT_TRUE(session::Validate(session).ok()) << session::Validate(session);
  const auto run = BindSession(session, Multi());
  ASSERT_TRUE(run.ok()) << run.status();
  EXPECT_NEAR(Difference(*run, 0), -23e-3, kFirstOrderMm);
  EXPECT_NEAR(Difference(*run, 1), -23e-3, kFirstOrderMm);
  EXPECT_NEAR(run->stated[0].by_sigma_mm(0, 0), -1e-3, kFirstOrderMm);
}

// What is cut is no part of what is read.
TEST(Stated, AWorkpieceMovesNoReading) {
  const auto run = BoundOf({"length",
                            {{"beam", "1 0 0"}, {"expansion workpiece", "11.5 1"}},
                            {{"X_mm", {200, 400}}, {"temp_C", {25, 25}}},
                            {"L_mm"}});
  ASSERT_TRUE(run.ok()) << run.status();
  EXPECT_NEAR(Difference(*run, 1), 0.0, kFirstOrderMm);
  EXPECT_NEAR(run->stated[0].mm(0, 1), 400 * 11.5e-6 * 5, kFirstOrderMm);
}

}  // namespace
}  // namespace axiscal::instruments
