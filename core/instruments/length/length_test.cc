#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/instruments/direction/direction_model.h"
#include "core/instruments/length/length_model.h"
#include "core/instruments/plausible.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"

namespace axiscal::instruments {
namespace {

using ::testing::HasSubstr;

machine::Machine Mt() { return machine::testing::MultiTasking(); }

// X from -200 to 200 mm by 100 mm; `key: value` beside the common header, `reading` for all.
session::Session Along(const std::string& instrument, const std::vector<session::HeaderEntry>& keys,
                       const std::string& column, const std::vector<double>& readings) {
  session::Session session;
  session.header = {
      {"machine", "mt"}, {"session", "S"}, {"instrument", instrument}, {"sigma_um", "1"}, {"tool_tip_mm", "0 0 -150"}};
  session.header.insert(session.header.end(), keys.begin(), keys.end());
  for (const machine::Axis& axis : Mt().axes)
    session.columns.push_back({axis.name + (axis.kind == machine::AxisKind::kLinear ? "_mm" : "_deg"), {}, {}});
  for (size_t k = 0; k < readings.size(); ++k)
    for (session::Column& of : session.columns)
      of.values.push_back(of.name == "X_mm" ? -200.0 + 100.0 * static_cast<double>(k) : 0.0);
  session.columns.push_back({column, readings, {}});
  return session;
}

absl::StatusOr<MeasuringRun> Bound(const session::Session& session) { return BindSession(session, Mt()); }

double Read(const MeasuringRun& run, int reading, const std::string& errors) {
  const machine::ErrorModel model = *machine::ReadErrors(errors, Mt());
  const double no_setup[kMaxSetupParameters] = {};
  double out_mm = NAN;
  Predict(Mt(), run, reading, machine::ErrorsAt(Mt(), model, run.StateOf(reading)), no_setup, &out_mm);
  return out_mm;
}

// The anchor lies 300 mm beside the line of the tool: L = hypot(300, x).
TEST(Length, FromAnAnchorByHand) {
  const auto run = Bound(Along("length", {{"anchor_mm", "0 300 -150"}, {"zero_sigma_um", "1"}}, "L_mm",
                               {360.5, 316.2, 300.0, 316.2, 360.5}));
  ASSERT_TRUE(run.ok()) << run.status();
  for (int k = 0; k < 5; ++k) EXPECT_NEAR(Read(*run, k, "{}"), std::hypot(300.0, -200.0 + 100.0 * k), 1e-9);
  // A tool 10 um towards the anchor, seen at right angles.
  EXPECT_NEAR(Read(*run, 2, R"({"EY0T": 10})"), 300.0 - 0.010, 1e-6);
  // A table that stands 10 um towards +Y carries the anchor along, one on the bed stays.
  EXPECT_NEAR(Read(*run, 2, R"({"EY0C": 10})"), 300.010, 1e-6);
  auto on_bed = Bound(Along("length", {{"anchor_mm", "0 300 -150"}, {"anchor_on", "bed"}, {"zero_sigma_um", "1"}},
                            "L_mm", {360.5, 316.2, 300.0, 316.2, 360.5}));
  ASSERT_TRUE(on_bed.ok());
  EXPECT_NEAR(Read(*on_bed, 2, R"({"EY0C": 10})"), 300.0, 1e-9);
}

// Along the motion a beam reads positioning, across it straightness; the zero starts at the middle reading.
TEST(Length, AlongABeamByHand) {
  const auto run = Bound(Along("length", {{"beam", "1 0 0"}}, "L_mm", {-1200, -1100, -1000, -900, -800}));
  ASSERT_TRUE(run.ok()) << run.status();
  EXPECT_NEAR(run->length.zero_mm, -1000.0, 1e-9);
  const std::string errors = R"({"terms": [{"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 20},
      {"symbol": "EYX", "shape": "linear", "variable": "X", "amplitude": 30}]})";
  EXPECT_NEAR(Read(*run, 4, errors), -800.0 + 0.2 * 20e-3, 1e-6);
  const auto across = Bound(Along("length", {{"beam", "0 1 0"}}, "L_mm", {0, 0, 0, 0, 1e-3}));
  EXPECT_NEAR(Read(*across, 4, errors), 0.2 * 30e-3, 1e-6);
}

// EBX turns the tool about y by 50 urad: 0.05 mm/m; a squareness of C's table turns the reference.
TEST(Direction, ByHand) {
  const std::vector<double> readings = {0, 0, 0.001, 0, 0};
  const auto run = Bound(Along("direction", {{"about", "0 1 0"}}, "turn_mm_per_m", readings));
  ASSERT_TRUE(run.ok()) << run.status();
  const std::string pitch = R"({"terms": [{"symbol": "EBX", "shape": "linear", "variable": "X", "amplitude": 250}]})";
  EXPECT_NEAR(Read(*run, 4, pitch), 0.2 * 0.250, 1e-7);
  EXPECT_NEAR(Read(*run, 4, R"({"EB0C": 50})"), -0.050, 1e-7);
  EXPECT_NEAR(Read(*run, 4, R"({"EA0C": 50})"), 0.0, 1e-9);
  const auto level = Bound(Along("direction", {{"about", "0 1 0"}, {"reference", "bed"}}, "turn_mm_per_m", readings));
  ASSERT_TRUE(level.ok());
  EXPECT_NEAR(Read(*level, 4, R"({"EB0C": 50})"), 0.0, 1e-9);
  EXPECT_NEAR(Read(*level, 4, pitch), 0.050, 1e-7);
}

TEST(Length, WhatIsMissingOrContradictsIsNamed) {
  const std::vector<double> readings = {1, 2, 3, 4, 5};
  const auto message = [&](const std::string& instrument, const std::vector<session::HeaderEntry>& keys) {
    return std::string(
        Bound(Along(instrument, keys, instrument == "length" ? "L_mm" : "turn_mm_per_m", readings)).status().message());
  };
  EXPECT_THAT(message("length", {}), HasSubstr("expected either the header 'anchor_mm: x y z' or the header 'beam"));
  EXPECT_THAT(message("length", {{"anchor_mm", "0 0 0"}, {"beam", "1 0 0"}}), HasSubstr("expected either"));
  EXPECT_THAT(message("length", {{"beam", "1 1 0"}}), HasSubstr("'beam' has length 1.41421, expected a unit vector"));
  EXPECT_THAT(message("length", {{"beam", "1 0 0"}, {"anchor_on", "wall"}}),
              HasSubstr("'anchor_on: wall', expected table or bed"));
  EXPECT_THAT(message("direction", {{"about", "0 0 2"}}), HasSubstr("expected a unit vector"));
  EXPECT_THAT(message("direction", {{"about", "0 0 1"}, {"reference", "air"}}), HasSubstr("expected table or bed"));
}

// Readings in metres, or along another axis, are none of this machine.
TEST(Length, AnotherUnitIsRefused) {
  const auto check = [](const std::vector<double>& readings) {
    return CheckPlausible(Along("length", {{"beam", "1 0 0"}}, "L_mm", readings), Mt());
  };
  EXPECT_TRUE(check({-1200.01, -1100, -1000, -900, -800}).ok());
  EXPECT_THAT(std::string(check({-1.2, -1.1, -1.0, -0.9, -0.8}).message()), HasSubstr("are the units (mm, deg)"));
  EXPECT_THAT(std::string(check({1200, 1100, 1000, 900, 800}).message()), HasSubstr("anchor_mm or beam"));
}

}  // namespace
}  // namespace axiscal::instruments
