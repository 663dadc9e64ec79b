#include "core/figures/figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "core/base/units.h"
#include "core/figures/axis_sessions.h"
#include "core/figures/circular.h"
#include "core/figures/line.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"
#include "core/synthetic/simulate.h"

namespace axiscal::figures {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kUm = 1e-3;

machine::Machine Mt() { return machine::testing::MultiTasking(); }

// ---- positioning

// Two targets, two approaches each way, um: target 0: up 1, 3 (mean 2, s = sqrt 2), down 5, 5 (mean 5, s = 0); target
// 100: up -2, -2 (mean -2, s = 0), down 1, 1 (mean 1, s = 0).
TEST(Positioning, ByHand) {
  const Positioning of = PositioningOf({{0, 1 * kUm, 1},
                                        {0, 3 * kUm, 1},
                                        {0, 5 * kUm, -1},
                                        {0, 5 * kUm, -1},
                                        {100, -2 * kUm, 1},
                                        {100.0005, -2 * kUm, 1},
                                        {100, 1 * kUm, -1},
                                        {100, 1 * kUm, -1}});
  const double s = std::sqrt(2.0) * kUm;
  ASSERT_THAT(of.targets, SizeIs(2));
  EXPECT_EQ(of.fewest_approaches, 2);
  EXPECT_NEAR(*of.targets[0].up->deviation_mm, s, 1e-12);
  EXPECT_NEAR(*of.reversal_mm, 3 * kUm, 1e-12);
  EXPECT_NEAR(*of.mean_reversal_mm, -3 * kUm, 1e-12);  // upwards it stops short
  EXPECT_NEAR(*of.up.repeatability_mm, 4 * s, 1e-12);
  EXPECT_NEAR(*of.down.repeatability_mm, 0.0, 1e-12);
  EXPECT_NEAR(*of.repeatability_mm, std::max(4 * s, 2 * s + 3 * kUm), 1e-12);
  EXPECT_NEAR(*of.up.systematic_mm, 4 * kUm, 1e-12);
  EXPECT_NEAR(*of.down.systematic_mm, 4 * kUm, 1e-12);
  EXPECT_NEAR(*of.systematic_mm, 7 * kUm, 1e-12);  // 5 to -2
  EXPECT_NEAR(*of.mean_mm, 4 * kUm, 1e-12);        // 3.5 and -0.5
  EXPECT_NEAR(*of.up.accuracy_mm, 2 * kUm + 2 * s + 2 * kUm, 1e-12);
  EXPECT_NEAR(*of.accuracy_mm, std::max(5 * kUm, 2 * kUm + 2 * s) + 2 * kUm, 1e-12);
}

// A place that was approached once from below, while all else was repeated, is no target of that side.
TEST(Positioning, WhatWasApproachedOnceAmongRepeatsIsLeftOut) {
  const Positioning of =
      PositioningOf({{-10, 90 * kUm, 1}, {0, 1 * kUm, 1}, {0, 1 * kUm, 1}, {0, 1 * kUm, -1}, {0, 1 * kUm, -1}});
  EXPECT_EQ(of.approached_once, 1);
  EXPECT_EQ(of.fewest_approaches, 2);
  EXPECT_FALSE(of.targets[0].up.has_value());
  EXPECT_NEAR(*of.up.systematic_mm, 0.0, 1e-12);
  EXPECT_NEAR(*of.up.repeatability_mm, 0.0, 1e-12);
}

TEST(Positioning, OneApproachTellsNoRepeatability) {
  const Positioning of = PositioningOf({{0, 1 * kUm, 1}, {0, 2 * kUm, -1}, {100, 4 * kUm, 1}, {100, 3 * kUm, -1}});
  EXPECT_FALSE(of.repeatability_mm || of.accuracy_mm || of.up.repeatability_mm);
  EXPECT_NEAR(*of.reversal_mm, 1 * kUm, 1e-12);
  const Positioning one_way = PositioningOf({{0, 1 * kUm, 1}, {0, 2 * kUm, 1}});
  EXPECT_FALSE(one_way.reversal_mm || one_way.down.systematic_mm);
  EXPECT_TRUE(one_way.up.repeatability_mm);
  EXPECT_THAT(PositioningOf({}).targets, IsEmpty());
}

// ---- circles

std::vector<CirclePoint> Around(const std::function<double(double)>& deviation_mm, int count = 720) {
  std::vector<CirclePoint> points;
  for (int i = 0; i < count; ++i) {
    const double t = 2.0 * M_PI * i / count;
    points.push_back({t, deviation_mm(t)});
  }
  return points;
}

TEST(Circular, ACentreThatIsOffIsNoDeviation) {
  const Envelope envelope =
      EnvelopeOf(Around([](double t) { return 0.007 + 0.030 * std::cos(t) - 0.020 * std::sin(t); }));
  EXPECT_NEAR(envelope.width_mm, 0.0, 1e-9);
  EXPECT_NEAR(envelope.mean_mm, 0.007, 1e-9);
  EXPECT_NEAR(envelope.max_mm, 0.007, 1e-9);
}

// Axes out of square by c on a radius R: d = (c R / 2) sin 2t, an ellipse; the width of its envelope is c R.
TEST(Circular, OfSquarenessByHand) {
  const double c = 50e-6, radius = 150.0;
  const Envelope envelope = EnvelopeOf(Around([&](double t) { return 0.5 * c * radius * std::sin(2.0 * t); }));
  EXPECT_NEAR(envelope.width_mm, c * radius, 1e-7);
  EXPECT_NEAR(envelope.min_mm, -0.5 * c * radius, 1e-7);
}

// A round bump of 4 um on one side: the least-squares centre is not that of the least envelope.
TEST(Circular, TheLeastEnvelopeIsNoWiderThanTheLeastSquaresOne) {
  const auto points = Around([](double t) {
    return 4 * kUm * std::max(0.0, std::cos(2.0 * std::min(M_PI_4, std::abs(std::remainder(t - 1.0, 2.0 * M_PI)))));
  });
  const Envelope envelope = EnvelopeOf(points);
  EXPECT_LT(envelope.width_mm, envelope.about_least_squares_mm - 0.1 * kUm);
  // No centre of a fine grid has less.
  double best = 1.0;
  for (double a = -4 * kUm; a < 4 * kUm; a += 0.05 * kUm) {
    for (double b = -4 * kUm; b < 4 * kUm; b += 0.05 * kUm) {
      double low = 1.0, high = -1.0;
      for (const CirclePoint& point : points) {
        const double d = point.deviation_mm - a * std::cos(point.angle_rad) - b * std::sin(point.angle_rad);
        low = std::min(low, d);
        high = std::max(high, d);
      }
      best = std::min(best, high - low);
    }
  }
  EXPECT_LE(envelope.width_mm, best + 1e-9);
  EXPECT_GE(envelope.width_mm, best - 0.2 * kUm);
}

TEST(Circular, BothSensesShareOneCentre) {
  // Backlash in X of 6 um: the centre of each sense lies 3 um to its side in Y's half of the way.
  const auto of_sense = [](double sign) {
    return Around([sign](double t) { return sign * 3 * kUm * (std::sin(t) > 0.0 ? -1.0 : 1.0) * std::cos(t); });
  };
  const Circular circular = CircularOf(of_sense(1.0), of_sense(-1.0));
  EXPECT_NEAR(circular.ccw->width_mm, circular.cw->width_mm, 1e-6);
  EXPECT_GE(circular.both->width_mm, circular.ccw->width_mm - 1e-9);
  EXPECT_FALSE(CircularOf(of_sense(1.0), {}).both.has_value());
}

TEST(SpanOf, FindsGaps) {
  EXPECT_NEAR(SpanOf(Around([](double) { return 0.0; })), 1.0, 1e-9);
  std::vector<CirclePoint> half = Around([](double) { return 0.0; });
  half.resize(361);
  EXPECT_NEAR(SpanOf(half), 0.5, 1e-6);
  EXPECT_EQ(SpanOf({}), 0.0);
}

// ---- lines

TEST(Straightness, IsTheRangeAboutTheLeastSquaresLine) {
  std::vector<double> positions, across;
  for (int i = -10; i <= 10; ++i) {
    positions.push_back(25.0 * i);
    across.push_back(0.5 + 1e-3 * 25.0 * i + (i % 2 == 0 ? 2 * kUm : -2 * kUm));
  }
  EXPECT_NEAR(StraightnessOf(positions, across), 4 * kUm, 0.1 * kUm);
}

// ---- sessions

session::Session Empty(const std::string& name, const std::string& instrument, double sigma_um) {
  session::Session session;
  session.header = {{"machine", "mt"},
                    {"session", name},
                    {"instrument", instrument},
                    {"sigma_um", absl::StrCat(sigma_um)},
                    {"tool_tip_mm", "0 0 -150"}};
  session.columns = {{"t_s", {}, {}}};
  for (const machine::Axis& axis : Mt().axes)
    session.columns.push_back({axis.name + (axis.kind == machine::AxisKind::kLinear ? "_mm" : "_deg"), {}, {}});
  return session;
}

void Go(session::Session* session, const std::map<std::string, double>& positions) {
  session->columns[0].values.push_back(static_cast<double>(session->columns[0].values.size()));
  for (size_t i = 1; i < session->columns.size(); ++i) {
    const auto at = positions.find(session->columns[i].name);
    session->columns[i].values.push_back(at == positions.end() ? 0.0 : at->second);
  }
}

// A circle in XY of a bar of 150 mm about a ball at the tool's place.
session::Session CircleXy(const std::string& name, bool ccw, double turn_deg = 360.0) {
  session::Session session = Empty(name, "ballbar", 0.1);
  session.header.push_back({"table_ball_mm", "0 0 -150"});
  session.header.push_back({"bar_length_mm", "150"});
  for (int i = 0; i <= 360; ++i) {
    const double t = (ccw ? 1.0 : -1.0) * i / 360.0 * turn_deg * base::kRadPerDeg;
    Go(&session, {{"X_mm", 150.0 * std::cos(t)}, {"Y_mm", 150.0 * std::sin(t)}});
  }
  return session;
}

// Targets every 50 mm from -250 to 250, `cycles` times there and back with an overrun at the ends that has no row.
session::Session LineX(int cycles, double sigma_um, bool says_sense = true) {
  session::Session session = Empty("X", "tracker", sigma_um);
  if (says_sense) session.columns.push_back({"X_sense", {}, {}});
  for (int cycle = 0; cycle < cycles; ++cycle) {
    for (int i = -5; i <= 5; ++i) Go(&session, {{"X_mm", 50.0 * i}, {"X_sense", 1}});
    for (int i = 5; i >= -5; --i) Go(&session, {{"X_mm", 50.0 * i}, {"X_sense", -1}});
  }
  return session;
}

Figures FiguresOfSessions(const std::string& errors, const std::vector<session::Session>& planned, double noise = 1.0) {
  const machine::ErrorModel truth = *machine::ReadErrors(errors, Mt());
  std::vector<instruments::MeasuringRun> runs;
  for (const session::Session& plan : planned) {
    synthetic::NoiseOptions options;
    options.sigma_scale = noise;
    options.seed = 5;
    const auto measured = synthetic::Simulate(Mt(), truth, plan, options);
    EXPECT_TRUE(measured.ok()) << measured.status();
    runs.push_back(*instruments::BindSession(*measured, Mt()));
  }
  return FiguresOf(Mt(), runs);
}

double ValueOf(const MeasuredTest& test, const std::string& symbol) {
  for (const Figure& figure : test.figures)
    if (figure.symbol == symbol) return figure.value_mm;
  ADD_FAILURE() << symbol << " is not there";
  return NAN;
}

// The set-up of the simulation (ball and run-out off by tens of um) is a centre that is off: no deviation.
TEST(FiguresOf, CirclesOfAMachineOutOfSquare) {
  const Figures figures = FiguresOfSessions(R"({"EC0X": 60})", {CircleXy("ccw", true), CircleXy("cw", false)}, 0.0);
  ASSERT_THAT(figures.tests, SizeIs(1));
  const MeasuredTest& test = figures.tests[0];
  EXPECT_THAT(test.sessions, ElementsAre("ccw", "cw"));
  EXPECT_THAT(test.what, HasSubstr("circle XY, radius 150 mm"));
  constexpr double kSecondOrder = 0.15 * kUm;  // (60 um)^2 / 300 mm and the ball off the path's centre
  EXPECT_NEAR(ValueOf(test, "G ccw"), 60e-6 * 150, kSecondOrder);
  EXPECT_NEAR(ValueOf(test, "G cw"), 60e-6 * 150, kSecondOrder);
  EXPECT_GE(ValueOf(test, "G(b)"), ValueOf(test, "G cw") - 1e-9);
  EXPECT_THAT(test.notes, IsEmpty());
}

// A range of readings with noise is too large: the figures say by how much on a machine without errors.
TEST(FiguresOf, NoiseIsSaid) {
  const MeasuredTest test = FiguresOfSessions("{}", {CircleXy("ccw", true)}).tests.at(0);
  EXPECT_NEAR(test.figures[0].of_noise_mm, test.figures[0].value_mm, 5.0 * test.figures[0].sigma_mm + 1e-6);
  EXPECT_GT(test.figures[0].of_noise_mm, 4.0 * 0.1 * kUm);  // 361 readings of 0.1 um span about 6 sigma
  EXPECT_LT(test.figures[0].of_noise_mm, 8.0 * 0.1 * kUm);
  EXPECT_THAT(test.notes, ElementsAre("not measured clockwise"));
}

TEST(FiguresOf, AnArcHasNone) {
  const MeasuredTest test = FiguresOfSessions("{}", {CircleXy("arc", true, 220.0)}).tests.at(0);
  EXPECT_THAT(test.figures, IsEmpty());
  EXPECT_THAT(test.notes, ::testing::Contains(HasSubstr("span 220 deg")));
}

// A scale error of 20 um/m over 0.5 m, backlash of 6 um, a bow of Y of 8 um at 250 mm; no noise. The line's own length
// is 20 um/m more than the position says.
TEST(FiguresOf, ALineByItsParts) {
  const std::string errors = R"({"terms": [
      {"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 20},
      {"symbol": "EXX", "shape": "backlash", "variable": "X", "amplitude": 6},
      {"symbol": "EYX", "shape": "quadratic", "variable": "X", "amplitude": 8}]})";
  const Figures figures = FiguresOfSessions(errors, {LineX(3, 0.5)}, 0.0);
  ASSERT_THAT(figures.tests, SizeIs(1)) << ::testing::PrintToString(figures.left_out);
  const MeasuredTest& test = figures.tests[0];
  constexpr double kSmall = 0.02 * kUm;
  EXPECT_THAT(test.what, HasSubstr("axis X from -250 to 250 mm"));
  ASSERT_TRUE(test.positioning.has_value());
  EXPECT_THAT(test.positioning->targets, SizeIs(11));
  EXPECT_EQ(test.positioning->fewest_approaches, 3);
  EXPECT_NEAR(ValueOf(test, "M"), 10 * kUm, kSmall);
  EXPECT_NEAR(ValueOf(test, "B"), 6 * kUm, kSmall);
  EXPECT_NEAR(ValueOf(test, "B mean"), 6 * kUm, kSmall);
  EXPECT_NEAR(ValueOf(test, "E"), 16 * kUm, kSmall);
  EXPECT_NEAR(ValueOf(test, "E(up)"), 10 * kUm, kSmall);
  EXPECT_NEAR(ValueOf(test, "R"), 6 * kUm, kSmall);
  EXPECT_NEAR(ValueOf(test, "R(up)"), 0.0, kSmall);
  EXPECT_NEAR(ValueOf(test, "A"), 16 * kUm, kSmall);
  // A parabola 8 (q / 250)^2 less its mean line: from 0 to 8.
  EXPECT_NEAR(ValueOf(test, "EYX"), 8 * kUm, 5 * kSmall);
  EXPECT_NEAR(ValueOf(test, "EZX"), 0.0, 5 * kSmall);
}

// R is 4 s: with sigma 0.5 um and thirty approaches the mean of R_i is 2 um, its largest of 11 a little more.
TEST(FiguresOf, RepeatabilityIsThatOfTheReadings) {
  const MeasuredTest test = FiguresOfSessions("{}", {LineX(30, 0.5)}).tests.at(0);
  EXPECT_NEAR(ValueOf(test, "R(up)"), 2.35 * kUm, 0.5 * kUm);
  EXPECT_NEAR(ValueOf(test, "B"), 0.0, 0.6 * kUm);
}

TEST(StopsOf, AnOverrunWithoutARowIsSeenByTheStatedSense) {
  const auto stops_of = [](bool says_sense) {
    const auto run = instruments::BindSession(
        *synthetic::Simulate(Mt(), {}, LineX(2, 0.5, says_sense), synthetic::NoiseOptions()), Mt());
    return StopsOf(*run, machine::FindAxis(Mt(), "X"));
  };
  const std::vector<Stop> stops = stops_of(true);
  ASSERT_THAT(stops, SizeIs(44));
  EXPECT_EQ(stops[0].sense, 1.0);
  EXPECT_EQ(stops[10].sense, 1.0);
  EXPECT_EQ(stops[11].sense, -1.0);
  EXPECT_EQ(stops[11].position, 250.0);
  EXPECT_EQ(stops[21].sense, -1.0);
  EXPECT_EQ(stops[22].sense, 1.0);
  const std::vector<Stop> unsaid = stops_of(false);
  ASSERT_THAT(unsaid, SizeIs(41));
  EXPECT_EQ(unsaid[10].readings, (std::vector<int>{10, 11}));
  EXPECT_EQ(unsaid[10].sense, 1.0);
}

// Without the column the ends are targets of one direction, and a note says what may be meant.
TEST(FiguresOf, AnOverrunThatNothingSaysIsAskedFor) {
  const std::string backlash =
      R"({"terms": [{"symbol": "EXX", "shape": "backlash", "variable": "X", "amplitude": 6}]})";
  const MeasuredTest test = FiguresOfSessions(backlash, {LineX(5, 0.5, false)}, 0.0).tests.at(0);
  EXPECT_THAT(test.notes, ::testing::Contains(HasSubstr("say so in a column X_sense")));
  EXPECT_NEAR(ValueOf(test, "B"), 6 * kUm, 0.02 * kUm);
  EXPECT_NEAR(ValueOf(test, "R(up)"), 0.0, 0.02 * kUm);
  EXPECT_TRUE(test.positioning->targets.front().down && test.positioning->targets.back().up);
  EXPECT_FALSE(test.positioning->targets.back().down);
}

// ---- lengths and directions

// As LineX, of another instrument.
session::Session XBy(const std::string& instrument, const std::vector<session::HeaderEntry>& keys, double sigma_um) {
  session::Session session = LineX(5, sigma_um);
  session.header[2].value = instrument;
  session.header.insert(session.header.end(), keys.begin(), keys.end());
  return session;
}

const char kPartsOfX[] = R"({"terms": [
    {"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 20},
    {"symbol": "EXX", "shape": "backlash", "variable": "X", "amplitude": 6},
    {"symbol": "EYX", "shape": "quadratic", "variable": "X", "amplitude": 8},
    {"symbol": "EBX", "shape": "quadratic", "variable": "X", "amplitude": 60}]})";

// The same errors as a tracker sees, of a beam the one way and the other: signs of the axis, not of the beam.
TEST(FiguresOf, PositioningByAnInterferometer) {
  const std::string errors = R"({"terms": [
      {"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 20},
      {"symbol": "EXX", "shape": "backlash", "variable": "X", "amplitude": 6}]})";
  for (const char* beam : {"1 0 0", "-1 0 0"}) {
    session::Session session = XBy("length", {{"beam", beam}, {"scale_sigma_um", "2"}}, 0.05);
    synthetic::NoiseOptions still;
    still.sigma_scale = 0.0;
    still.draw_setup = false;
    const auto measured = synthetic::Simulate(Mt(), *machine::ReadErrors(errors, Mt()), session, still);
    ASSERT_TRUE(measured.ok()) << measured.status();
    const Figures figures = FiguresOf(Mt(), {*instruments::BindSession(*measured, Mt())});
    ASSERT_THAT(figures.tests, SizeIs(1)) << ::testing::PrintToString(figures.left_out);
    const MeasuredTest& test = figures.tests[0];
    EXPECT_NEAR(ValueOf(test, "M"), 10 * kUm, 0.02 * kUm) << beam;
    EXPECT_NEAR(ValueOf(test, "B mean"), 6 * kUm, 0.02 * kUm) << beam;
    EXPECT_NEAR(ValueOf(test, "A"), 16 * kUm, 0.02 * kUm) << beam;
    EXPECT_GT(test.positioning->targets.back().up->mean_mm, 0.0) << beam;  // too far at the upper end
    // 2 um/m of the scale over half a metre: 1 um in M, nothing in B.
    for (const Figure& figure : test.figures) {
      if (figure.symbol == "M") {
        EXPECT_NEAR(figure.sigma_mm, 1.0 * kUm, 0.3 * kUm);
      } else if (figure.symbol == "B mean") {
        EXPECT_LT(figure.sigma_mm, 0.05 * kUm);
      }
    }
  }
}

TEST(FiguresOf, StraightnessAndPitchByDirection) {
  const Figures figures = FiguresOfSessions(
      kPartsOfX,
      {XBy("length", {{"beam", "0 1 0"}, {"beam_a_sigma_urad", "1"}, {"beam_b_sigma_urad", "1"}}, 0.5),
       XBy("direction", {{"about", "0 1 0"}, {"reference", "bed"}}, 1.0)},
      0.0);
  ASSERT_THAT(figures.tests, SizeIs(2)) << ::testing::PrintToString(figures.left_out);
  EXPECT_EQ(figures.tests[0].unit, "um");
  for (const char* symbol : {"EYX", "EYX(up)", "EYX(down)"})
    EXPECT_NEAR(ValueOf(figures.tests[0], symbol), 8 * kUm, 0.1 * kUm) << symbol;
  EXPECT_EQ(figures.tests[1].unit, "urad");
  for (const char* symbol : {"EBX", "EBX(up)", "EBX(down)"})
    EXPECT_NEAR(ValueOf(figures.tests[1], symbol), 60 * kUm, 0.1 * kUm) << symbol;
}

// C carries the table: an autocollimator on the table sees the tool turn the other way. Positioning of C, urad.
TEST(FiguresOf, PositioningOfARotaryAxis) {
  session::Session session = Empty("C", "direction", 1.0);
  session.header.push_back({"about", "0 0 1"});
  session.columns.push_back({"C_sense", {}, {}});
  for (int cycle = 0; cycle < 5; ++cycle) {
    for (int i = 0; i <= 12; ++i) Go(&session, {{"C_deg", 30.0 * i}, {"C_sense", 1}});
    for (int i = 12; i >= 0; --i) Go(&session, {{"C_deg", 30.0 * i}, {"C_sense", -1}});
  }
  const Figures figures = FiguresOfSessions(R"({"terms": [
      {"symbol": "ECC", "shape": "harmonic", "variable": "C", "order": 1, "amplitude": 40, "phase_deg": 0},
      {"symbol": "ECC", "shape": "backlash", "variable": "C", "amplitude": 12}]})",
                                            {session}, 0.0);
  ASSERT_THAT(figures.tests, SizeIs(1)) << ::testing::PrintToString(figures.left_out);
  const MeasuredTest& test = figures.tests[0];
  EXPECT_EQ(test.kind, "turn");
  EXPECT_EQ(test.what, "axis C from 0 to 360 deg");
  EXPECT_NEAR(ValueOf(test, "M"), 80 * kUm, 0.1 * kUm);
  EXPECT_NEAR(ValueOf(test, "B mean"), 12 * kUm, 0.1 * kUm);
  EXPECT_GT(test.positioning->targets.front().up->mean_mm, test.positioning->targets[6].up->mean_mm);
}

TEST(FiguresOf, ABeamAskewHasNone) {
  const Figures figures = FiguresOfSessions("{}", {XBy("length", {{"beam", "0.8 0.6 0"}}, 0.5)}, 0.0);
  EXPECT_THAT(figures.left_out, ElementsAre(HasSubstr("neither along the motion nor square to it")));
}

TEST(FiguresOf, OtherSessionsAreLeftOutWithAReason) {
  session::Session turning = Empty("B", "tracker", 1.0);
  for (int i = 0; i < 20; ++i) Go(&turning, {{"B_deg", 2.0 * i}, {"X_mm", 3.0 * i}});
  const Figures figures = FiguresOfSessions("{}", {turning});
  EXPECT_THAT(figures.tests, IsEmpty());
  EXPECT_THAT(figures.left_out, ElementsAre(HasSubstr("session B: ")));
}

}  // namespace
}  // namespace axiscal::figures
