#include "core/logs/reduce.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "core/base/error_detail.h"
#include "core/base/testing/source_path.h"
#include "core/instruments/run.h"
#include "core/machine/testing/machines.h"
#include "core/session/read_session.h"
#include "core/session/write_session.h"

namespace axiscal::logs {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

// Yao 2022, Fig 5.13; the stylus centre at home in the machine's origin, so that positions are places.
constexpr char kHeader[] =
    "# machine: mt\n# session: log\n# instrument: touch\n# sigma_um: 1.5\n# tool_tip_mm: 0 0 0\n"
    "# stylus_radius_mm: 2.9106\n# sphere ball: -390 0 -472 5\n";

std::string Fig513() {
  std::stringstream text;
  text << std::ifstream(base::SourcePath("/tests/data/yao/fig-5.13-touch-log.txt"), std::ios::binary).rdbuf();
  return text.str();
}

absl::StatusOr<Reduced> ReduceText(const std::string& log, const std::string& rules,
                                   const machine::Machine* machine = nullptr, const session::Session* plan = nullptr) {
  const auto parsed = ParseTemplate(rules, "t.txt");
  if (!parsed.ok()) return parsed.status();
  std::istringstream in(log);
  return Reduce(in, "probe.log", *parsed, {.machine = machine, .plan = plan});
}

std::string Refusal(const absl::StatusOr<Reduced>& reduced) {
  return reduced.ok() ? "accepted" : std::string(reduced.status().message());
}

TEST(Reduce, YaosLogBecomesATouchSession) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const auto reduced = ReduceText(Fig513(), std::string(kHeader) + "format: dprnt\napproach: feature\n", &machine);
  ASSERT_TRUE(reduced.ok()) << reduced.status();
  EXPECT_EQ(reduced->session.reading_count(), 21u);
  EXPECT_EQ(reduced->lines.front(), 4u);
  EXPECT_FALSE(reduced->cut.has_value());
  EXPECT_THAT(reduced->notes, Contains("line 2 of the log announces 40 readings, 21 are there"));
  const session::Column* const y = session::FindColumn(reduced->session, "Y_mm");
  ASSERT_NE(y, nullptr);
  EXPECT_EQ(y->values[19], -7.3892);
  // The first touch comes along -Z, the last along +Y.
  EXPECT_NEAR(session::FindColumn(reduced->session, "nz")->values[0], -1.0, 1e-12);
  EXPECT_NEAR(session::FindColumn(reduced->session, "ny")->values[20], 1.0, 1e-12);
  const auto text = session::WriteSession(reduced->session);
  ASSERT_TRUE(text.ok()) << text.status();
  const auto read = session::ReadSessionText(*text, "again");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, reduced->session);
  EXPECT_TRUE(instruments::BindSession(*read, machine).ok());
}

TEST(Reduce, FieldsInAnyOrderAndPaddedNumbersGiveTheSameSession) {
  const std::string rules =
      std::string(kHeader) + "line: X{X_mm} Y{Y_mm} Z{Z_mm} B{B_deg} C{C_deg}\napproach: 0 0 -1\n";
  const auto plain = ReduceText("X-390.0000 Y0.0000 Z-464.5118 B0.0000 C0.0000\n", rules);
  const auto padded = ReduceText("%\r\nC   0.0000 Z- 464.5118 B   0.0000   X- 390.0000 Y   0.0000\r\n%\r\n", rules);
  ASSERT_TRUE(plain.ok()) << plain.status();
  ASSERT_TRUE(padded.ok()) << padded.status();
  EXPECT_EQ(plain->session, padded->session);
}

TEST(Reduce, ACutLastLineIsReportedAndNotInvented) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const std::string rules = std::string(kHeader) + "format: dprnt\napproach: feature\n";
  std::string log = Fig513();
  log.resize(log.rfind('%'));  // the line end before it stays
  for (const char* cut : {"X-391.0000 Y0.00", "X-391.0000 Y0.00\n", "X-391.0000 Y0.0000 Z-464.60 B0.0000 C0.0000",
                          "X-391.0000 Y0.0000 Z-464.6000 B0.0000 C0.00\n",
                          "X-391.0000 Y0.0000 Z-464.6000 B0.0000 C0.0000", "X-391.0000 Y-\n", "X"}) {
    const auto reduced = ReduceText(log + cut, rules, &machine);
    ASSERT_TRUE(reduced.ok()) << cut << ": " << reduced.status();
    EXPECT_EQ(reduced->session.reading_count(), 21u) << cut;
    ASSERT_TRUE(reduced->cut.has_value()) << cut;
    EXPECT_EQ(reduced->cut->line, 25u) << cut;
    EXPECT_THAT(reduced->notes, Contains(HasSubstr("cut, and left out: line 25 of the log"))) << cut;
    EXPECT_THAT(session::FindHeader(reduced->session, "cut_line").value_or(""), HasSubstr("line 25")) << cut;
    EXPECT_TRUE(session::WriteSession(reduced->session).ok());
  }
  // What is cut in the middle is no last line.
  EXPECT_THAT(Refusal(ReduceText(log + "X-391.0000 Y0.00\n%\nX-390.0000 Y0.0000 Z-464.5118 B0.0000 C0.0000\n", rules,
                                 &machine)),
              HasSubstr("probe.log: line 25, column 17: the line's end, expected also Z"));
}

// A reading that the machine cannot give, a position beyond its travel: named by the log's line, which the user has.
TEST(Reduce, WhatTheMachineRefusesIsNamedByTheLogsLine) {
  machine::Machine machine = machine::testing::MultiTasking();
  const std::string rules =
      "# machine: mt\n# session: laser\n# instrument: length\n# sigma_um: 1\n# tool_tip_mm: 0 0 -150\n# beam: 1 0 0\n"
      "line: {t_s} {L_mm} {X_mm} {Y_mm} {Z_mm} {B_deg} {C_deg}\nskip: LASER{*}\n";
  const auto log = [](const std::string& length_mm, const std::string& x_mm) {
    return "LASER 1\nLASER 2\n0 0.001 0 0 0 0 0\nLASER 3\nLASER 4\nLASER 5\n1 9.999 10 0 0 0 0\n\nLASER 6\n2 " +
           length_mm + " " + x_mm + " 0 0 0 0\n3 30.002 30 0 0 0 0\n";
  };
  ASSERT_TRUE(ReduceText(log("20.001", "20"), rules, &machine).ok())
      << ReduceText(log("20.001", "20"), rules, &machine).status();
  const auto far = ReduceText(log("120.001", "20"), rules, &machine);
  EXPECT_THAT(Refusal(far), HasSubstr("probe.log: line 10: reading 3 of session 'laser': L_mm = 120.001 mm"));
  const auto detail = base::GetErrorDetail(far.status());
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->reason, "LOG_INVALID");
  EXPECT_EQ(detail->facts.at("line"), "10");
  machine.axes[machine::FindAxis(machine, "X")].min_position = 0.0;
  machine.axes[machine::FindAxis(machine, "X")].max_position = 50.0;
  const auto beyond = ReduceText(log("60.001", "60"), rules, &machine);
  EXPECT_THAT(Refusal(beyond), HasSubstr("probe.log: line 10 (X_mm): 60 is beyond the travel of X"));
}

TEST(Reduce, LinuxCncLogsHaveNineNumbers) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const std::string rules = std::string(kHeader) + "format: linuxcnc-probe\napproach: feature\nseconds: 5\n";
  const std::string line = "-390.000000 0.000000 -464.511800 0.000000 0.000000 0.000000 0.000000 0.000000 0.000000\n";
  const auto reduced = ReduceText(line + line, rules, &machine);
  ASSERT_TRUE(reduced.ok()) << reduced.status();
  ASSERT_EQ(reduced->session.reading_count(), 2u);
  EXPECT_EQ(session::FindColumn(reduced->session, "Z_mm")->values[1], -464.5118);
  EXPECT_EQ(session::FindColumn(reduced->session, "t_s")->values[1], 5.0);
  const auto place = [](const absl::StatusOr<Reduced>& outcome) {
    return base::GetErrorDetail(outcome.status()).value_or(base::ErrorDetail());
  };
  EXPECT_EQ(place(ReduceText(line + "-390 0 -464.5118 12 0 0 0 0 0\n", rules, &machine)),
            (base::ErrorDetail{"LOG_INVALID", {{"line", "2"}, {"name", "A_deg"}}}));
  EXPECT_EQ(place(ReduceText("-390 0 -464.5118 0 0 0\n" + line, rules, &machine)),
            (base::ErrorDetail{"LOG_INVALID", {{"line", "1"}, {"column", "23"}}}));
  EXPECT_THAT(Refusal(ReduceText("-390 0 -464.5118 12 0 0 0 0 0\n", rules, &machine)),
              HasSubstr("probe.log: line 1: A_deg reads 12, but machine mt has no such axis"));
  EXPECT_THAT(Refusal(ReduceText("-390 0 -464.5118 0 0 0\n-390 0 1 0 0 0 0 0 0\n", rules, &machine)),
              HasSubstr("probe.log: line 1, column 23: the line's end, expected a number for U_mm"));
  EXPECT_THAT(Refusal(ReduceText(line, rules)), HasSubstr("expected one of them or 'line:'"));
}

TEST(Reduce, CentresOfATableBecomeACentresSession) {
  const std::string rules =
      "# machine: mt\n# session: C\n# instrument: centres\n# sigma_um: 2\n# tool_tip_mm: 0 0 -382.95\n"
      "# table_ball_mm: -390 0 -472\nline: C,{*},{B_deg},{C_deg},1,{cx_mm},{cy_mm},{cz_mm}\n"
      "skip: setup,{*}\nskip: C,{*},{*},{*},2,{*}\nskip: B-{*}\n";
  std::ifstream in(base::SourcePath("/tests/data/yao/table-5.2-sphere-centres.csv"));
  std::stringstream log;
  log << in.rdbuf();
  const auto reduced = ReduceText(log.str(), rules);
  ASSERT_TRUE(reduced.ok()) << reduced.status();
  ASSERT_EQ(reduced->session.reading_count(), 4u);
  EXPECT_EQ(session::FindColumn(reduced->session, "cy_mm")->values[3], -99.738);
  EXPECT_EQ(session::FindColumn(reduced->session, "C_deg")->values[3], 270.0);
  EXPECT_TRUE(session::WriteSession(reduced->session).ok());
}

TEST(Reduce, WhatTheLogDoesNotSayIsAskedFor) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const std::string header = kHeader, axes = "line: X{X_mm} Y{Y_mm} Z{Z_mm} B{B_deg} C{C_deg}\n",
                    log = "X-390.0 Y0.0 Z-464.5118 B0.0 C0.0\n";
  EXPECT_THAT(Refusal(ReduceText(log, header + axes)), HasSubstr("t.txt: nothing says from where the stylus came"));
  EXPECT_THAT(Refusal(ReduceText(log, header + axes + "approach: feature\n")), HasSubstr("needs the machine"));
  EXPECT_THAT(Refusal(ReduceText(log, header + "# plane top: 0 0 0 0 0 1\n" + axes + "approach: 0 0 -1\n")),
              HasSubstr("probe.log: line 1: nothing says which feature was touched"));
  EXPECT_THAT(Refusal(ReduceText(log, header + axes + "approach: 0 0 -1\nfeature: bal\n")),
              HasSubstr("probe.log: line 1 (feature): 'bal', expected a name that the header describes"));
  EXPECT_THAT(Refusal(ReduceText(log, header + "line: X{X_mm} Y{Y_mm} Z{Z_mm} B{B_deg}\nskip: X{*}\n")),
              HasSubstr("no line is a reading"));
  EXPECT_THAT(Refusal(ReduceText(log, header + "line: X{X_mm} Y{Y_mm} Z{Z_mm} B{B_deg} C{dL_mm}\napproach: 0 0 -1\n")),
              HasSubstr("{dL_mm} is no column of instrument touch"));
  EXPECT_THAT(Refusal(ReduceText("X-390 Y0 Z-464.5 B0\n",
                                 header + "line: X{X_mm} Y{Y_mm} Z{Z_mm} B{B_deg}\napproach: 0 0 -1\n", &machine)),
              HasSubstr("has no field {C_deg}, instrument touch needs it"));
  EXPECT_THAT(Refusal(ReduceText("alarm 3\n" + log, header + axes + "approach: 0 0 -1\n")),
              HasSubstr("probe.log: line 1, column 1: 'alarm 3', expected a field of"));
  EXPECT_THAT(Refusal(ReduceText("", header + axes)), HasSubstr("no line is a reading"));
  EXPECT_THAT(Refusal(ReduceText("X-9390000.0 Y0.0 Z-464.5118 B0.0 C0.0\n", header + axes + "approach: 0 0 -1\n")),
              HasSubstr("probe.log: line 1 (X_mm): -9.39e+06, expected mm from"));
  // With the machine touches are gated: this one is 90 mm off the ball.
  EXPECT_THAT(
      Refusal(ReduceText("X-390.0 Y0.0 Z-374.5118 B0.0 C0.0\n", header + axes + "approach: 0 0 -1\n", &machine)),
      HasSubstr("reading 1 stands 89.578 mm off feature 'ball'"));
}

TEST(Reduce, ScalesAndMarksApply) {
  const std::string rules = std::string(kHeader) +
                            "# plane top: 0 0 0 0 0 1\nline: X{X_mm} Y{Y_mm} Z{Z_mm} B{B_deg} C{C_deg}\n"
                            "mark: Feature {feature}\naxis: X 25.4 -390\naxis: Z 1 0.5\napproach: 0 0 -1\n";
  const auto reduced =
      ReduceText("Feature top\nX1.0 Y0.0 Z2.0 B0.0 C0.0\nFeature ball\nX0.0 Y0.0 Z-464.0 B0.0 C0.0\n", rules);
  ASSERT_TRUE(reduced.ok()) << reduced.status();
  EXPECT_THAT(session::FindColumn(reduced->session, "feature")->texts, ::testing::ElementsAre("top", "ball"));
  EXPECT_NEAR(session::FindColumn(reduced->session, "X_mm")->values[0], -364.6, 1e-9);
  EXPECT_EQ(session::FindColumn(reduced->session, "Z_mm")->values[0], 2.5);
}

// As a spreadsheet or a logger of a German desk writes it.
TEST(Reduce, CommasMomentsAndOtherUnitsOfALogAreRead) {
  const std::string rules = std::string(kHeader) +
                            "line: {*};{t_s};{X_mm};{Y_mm};{Z_mm};{B_deg};{C_deg};{temp_C}\ndecimal: ,\n"
                            "time: %d.%m.%Y %H:%M:%E*S\naxis: Z_mm 1000 0\naxis: temp_C 0.5 -10\n"
                            "approach: 0 0 -1\nfeature: ball\n";
  const std::string log =
      "1;30.11.2026 23:59:59;-390,0;0;-0,467;0;0;60,5\n2;01.12.2026 00:00:01,5;-390,0;0;-0,467;0;0;61\n";
  const auto reduced = ReduceText(log, rules);
  ASSERT_TRUE(reduced.ok()) << reduced.status();
  EXPECT_THAT(session::FindColumn(reduced->session, "t_s")->values, ::testing::ElementsAre(0.0, 2.5));
  EXPECT_THAT(session::FindColumn(reduced->session, "Z_mm")->values, ::testing::ElementsAre(-467.0, -467.0));
  EXPECT_THAT(session::FindColumn(reduced->session, "temp_C")->values, ::testing::ElementsAre(20.25, 20.5));
  EXPECT_EQ(Refusal(ReduceText("1;30/11/2026 23:59:59;-390,0;0;-0,467;0;0;60,5\n", rules)),
            "probe.log: line 1 (t_s): '30/11/2026 23:59:59', expected a time of the form %d.%m.%Y %H:%M:%E*S (template "
            "t.txt)");
  // A comma that the form has is no decimal's.
  const std::string with_comma = std::string(kHeader) +
                                 "line: {t_s};{X_mm};{Y_mm};{Z_mm};{B_deg};{C_deg}\ndecimal: ,\n"
                                 "time: %d.%m.%Y, %H:%M:%E*S\napproach: 0 0 -1\nfeature: ball\n";
  const auto commas = ReduceText(
      "30.11.2026, 23:59:59,5;-390,0;0;-467,0;0;0\n30.11.2026, 23:59:59,75;-390,0;0;-467,0;0;0\n", with_comma);
  ASSERT_TRUE(commas.ok()) << commas.status();
  EXPECT_THAT(session::FindColumn(commas->session, "t_s")->values, ::testing::ElementsAre(0.0, 0.25));
  // The approach is scaled, too: a control that writes where the stylus came from, not where it went.
  const auto turned = ReduceText("X-390.0 Y0.0 Z-467.0 B0.0 C0.0 I0 J0 K1\n",
                                 std::string(kHeader) +
                                     "line: X{X_mm} Y{Y_mm} Z{Z_mm} B{B_deg} C{C_deg} I{nx} J{ny} K{nz}\n"
                                     "axis: nz -1 0\nfeature: ball\n");
  ASSERT_TRUE(turned.ok()) << turned.status();
  EXPECT_EQ(session::FindColumn(turned->session, "nz")->values[0], -1.0);
  const auto ruled = [&](const std::string& rule) { return Refusal(ReduceText(log, rules + rule)); };
  EXPECT_EQ(ruled("axis: px 2 0\n"), "t.txt: axis: px is scaled, but the line has no field {px}, {px_mm} or {px_deg}");
  EXPECT_EQ(ruled("axis: Z 2 0\n"), "t.txt: axis: {Z_mm} is scaled twice, as Z too");
  EXPECT_EQ(ruled("axis: t_s 2 0\n"), "t.txt: axis: t_s is scaled, but {t_s} is no number");
}

// A plan brings the header, the features and where each touch should be.
TEST(Reduce, APlanSaysWhatWasTouched) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const auto planned = ReduceText(Fig513(), std::string(kHeader) + "format: dprnt\napproach: feature\n", &machine);
  ASSERT_TRUE(planned.ok());
  const auto dprnt = FindFormat("dprnt");
  ASSERT_TRUE(dprnt.ok());
  const auto reduce = [&](const std::string& log) {
    std::istringstream in(log);
    return Reduce(in, "probe.log", *dprnt, {.plan = &planned->session, .session = "today", .start_s = 3600.0});
  };
  const auto again = reduce(Fig513());
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(session::FindHeader(again->session, "session"), "today");
  EXPECT_EQ(session::FindColumn(again->session, "t_s")->values[1], 3601.0);
  EXPECT_EQ(*session::FindColumn(again->session, "nx"), *session::FindColumn(planned->session, "nx"));
  const auto fewer = reduce("X-390.0000 Y0.0000 Z-464.5118 B0.0000 C0.0000\n");
  ASSERT_TRUE(fewer.ok()) << fewer.status();
  EXPECT_THAT(fewer->notes, Contains("the plan has 21 readings, the log 1: the rest is missing"));
  EXPECT_THAT(
      Refusal(reduce("X-390.0000 Y0.0000 Z-404.5118 B0.0000 C0.0000\n")),
      HasSubstr("probe.log: line 1: Z_mm = -404.512, but line 1 of the plan is at -464.512, expected within 25"));
  EXPECT_THAT(Refusal(reduce(Fig513() + "X-390.0000 Y-7.8969 Z-472.0000 B0.0000 C0.0000\n%\n")),
              HasSubstr("line 26: reading 22, but the plan has 21"));
}

// C of `machine` counts from 0 to 360 deg, or does not say.
machine::Machine Counting(machine::RollOver roll_over) {
  machine::Machine machine = machine::testing::MultiTasking();
  machine::Axis& c = machine.axes[static_cast<size_t>(machine::FindAxis(machine, "C"))];
  c.min_position = c.max_position = std::nullopt;
  c.roll_over = roll_over;
  return machine;
}

// A control that counts from 0 to 360 deg shows 359.9995 where -0.0005 was commanded.
TEST(Reduce, AnAxisThatRollsOverIsWhereThePlanIs) {
  const std::string line = "line: {B_deg} {C_deg} {cx_mm} {cy_mm} {cz_mm}\n";
  const std::string header =
      "# machine: mt\n# session: C\n# instrument: centres\n# sigma_um: 2\n# tool_tip_mm: 0 0 -382.95\n"
      "# table_ball_mm: -390 0 -472\n";
  const auto planned =
      ReduceText("0 0 -390 0 -472\n0 180 390 0 -472\n0 360 -390 0 -472\n0 -90 0 390 -472\n", header + line);
  ASSERT_TRUE(planned.ok()) << planned.status();
  const std::string log =
      "0 359.9995 -390 0 -472\n0 180.0003 390 0 -472\n0 0.0004 -390 0 -472\n0 270.0001 0 390 -472\n";
  for (const machine::RollOver roll_over :
       {machine::RollOver::kShortest, machine::RollOver::kBySign, machine::RollOver::kByDifference}) {
    const machine::Machine machine = Counting(roll_over);
    const auto reduced = ReduceText(log, line, &machine, &planned->session);
    ASSERT_TRUE(reduced.ok()) << reduced.status();
    const std::vector<double>& c = session::FindColumn(reduced->session, "C_deg")->values;
    const double expected[] = {-0.0005, 180.0003, 360.0004, -89.9999};
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(c[static_cast<size_t>(k)], expected[k], 1e-9) << k;
    EXPECT_THAT(Refusal(ReduceText("0 359.8 -390 0 -472\n", line, &machine, &planned->session)),
                HasSubstr("C_deg = 359.8, but line 1 of the plan is at 0, expected within 0.1"));
  }
  const machine::Machine counts_on = Counting(machine::RollOver::kNone),
                         unstated = Counting(machine::RollOver::kUnstated);
  EXPECT_THAT(Refusal(ReduceText(log, line, &counts_on, &planned->session)), HasSubstr("was a touch missed"));
  EXPECT_THAT(
      Refusal(ReduceText(log, line, &unstated, &planned->session)),
      HasSubstr("whole turns apart; does the axis count from 0 to 360 deg? Then its roll_over in machine.json"));
}

// Without a plan nothing but the position before says the turn: behind 359 deg comes 361.
TEST(Reduce, WithoutAPlanAnAxisThatRollsOverCountsOn) {
  const std::string rules =
      "# machine: mt\n# session: C\n# instrument: centres\n# sigma_um: 2\n# tool_tip_mm: 0 0 -382.95\n"
      "# table_ball_mm: -390 0 -472\nline: {B_deg} {C_deg} {cx_mm} {cy_mm} {cz_mm}\n";
  double travel_deg = 0.0;
  const auto counted = [&](machine::RollOver roll_over, const std::vector<double>& logged) {
    std::string log;
    for (const double c : logged) {
      const double angle = c * M_PI / 180.0;
      absl::StrAppendFormat(&log, "0 %.4f %.4f %.4f -472\n", c, -390.0 * std::cos(angle), -390.0 * std::sin(angle));
    }
    const machine::Machine machine = Counting(roll_over);
    const auto reduced = ReduceText(log, rules, &machine);
    EXPECT_TRUE(reduced.ok()) << reduced.status();
    if (!reduced.ok()) return std::vector<double>();
    const auto is_told = [](const std::string& note) { return note.find("the axis rolls over") != note.npos; };
    const bool is_noted = std::any_of(reduced->notes.begin(), reduced->notes.end(), is_told);
    EXPECT_EQ(is_noted, session::FindColumn(reduced->session, "C_deg")->values != logged);
    const auto run = instruments::BindSession(reduced->session, machine);
    EXPECT_TRUE(run.ok()) << run.status();
    if (run.ok()) {  // sense and travel behind the last reading
      const shapes::AxisState& last = run->AxisStatesOf(run->reading_count() - 1)[machine::FindAxis(machine, "C")];
      travel_deg = last.sense * last.travel_since_reversal * 180.0 / M_PI;
    }
    return session::FindColumn(reduced->session, "C_deg")->values;
  };
  using machine::RollOver;
  using ::testing::ElementsAre;
  for (const RollOver way : {RollOver::kShortest, RollOver::kBySign}) {
    EXPECT_THAT(counted(way, {0, 120, 240, 0, 120, 240, 0}), ElementsAre(0, 120, 240, 360, 480, 600, 720));
    EXPECT_NEAR(travel_deg, 720.0, 1e-9);
    EXPECT_THAT(counted(way, {0, 240, 120, 0, 350}), ElementsAre(0, -120, -240, -360, -370));
    EXPECT_NEAR(travel_deg, -370.0, 1e-9);
    EXPECT_THAT(counted(way, {0, 180, 0, 180}), ElementsAre(0, 180, 0, 180)) << "no way is the nearer";
    EXPECT_THAT(counted(way, {270, 90, 270}), ElementsAre(270, 90, 270));
  }
  EXPECT_THAT(counted(RollOver::kByDifference, {0, 120, 240, 0}), ElementsAre(0, 120, 240, 0)) << "it went back";
  EXPECT_THAT(counted(RollOver::kByDifference, {0, 359.9995, 90}),
              ElementsAre(0, ::testing::DoubleNear(-0.0005, 1e-9), 90));
  for (const RollOver way : {RollOver::kNone, RollOver::kUnstated})
    EXPECT_THAT(counted(way, {0, 120, 240, 0}), ElementsAre(0, 120, 240, 0));
}

// Touches at one pose stay together across 0, and their mean is there.
TEST(Reduce, ACentreIsComputedAcrossZero) {
  const machine::Machine machine = Counting(machine::RollOver::kShortest);
  const std::string rules =
      "# machine: mt\n# session: C\n# instrument: centres\n# sigma_um: 2\n# tool_tip_mm: 0 0 -382.95\n"
      "# table_ball_mm: -390 0 -472\nline: X{X_mm} Y{Y_mm} Z{Z_mm} B{B_deg} C{C_deg}\n";
  constexpr double kRadiusMm = 10.0;
  const double directions[][3] = {{1, 0, 0}, {-1, 0, 0},    {0, 1, 0},    {0, -1, 0},
                                  {0, 0, 1}, {0.6, 0, 0.8}, {0, 0.6, 0.8}};
  std::string log;
  for (const double pose_deg : {0.0, 90.0}) {
    int k = 0;
    for (const auto& n : directions) {
      const double x = (pose_deg == 0.0 ? -390.0 : 0.0) + kRadiusMm * n[0],
                   y = (pose_deg == 0.0 ? 0.0 : -390.0) + kRadiusMm * n[1], z = -89.05 + kRadiusMm * n[2];
      const double c = pose_deg != 0.0 ? pose_deg : ++k % 2 == 0 ? 359.9999 : 0.0001;
      absl::StrAppendFormat(&log, "X%.4f Y%.4f Z%.4f B0.0000 C%.4f\n", x, y, z, c);
    }
  }
  const auto reduced = ReduceText(log, rules, &machine);
  ASSERT_TRUE(reduced.ok()) << reduced.status();
  ASSERT_EQ(reduced->session.reading_count(), 2u);
  EXPECT_NEAR(session::FindColumn(reduced->session, "C_deg")->values[0], 0.0, 2e-4);
  EXPECT_NEAR(session::FindColumn(reduced->session, "cx_mm")->values[0], -390.0, 1e-3);
}

}  // namespace
}  // namespace axiscal::logs
