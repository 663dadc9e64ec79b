// Programs that state the tool's direction as a vector: G43.5 with I, J and K, TRAORI with A3=, B3= and C3=, LN.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "absl/strings/str_format.h"
#include "core/base/units.h"
#include "core/nc/testing/rewritten.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::Outcome;
using testing::Rewritten;

const Eigen::Vector3d kGaugeMm(0, 0, 200.0 - testing::kToolMm);

RewriteOptions Options(const std::string& dialect) {
  RewriteOptions options = testing::kAtZero;
  options.dialect = dialect;
  options.tool_lengths = {{1, 200.0}};
  options.work_offsets = {{dialect == "heidenhain" ? "PRESET" : "G54", {{"X", 100.0}, {"Y", -50.0}, {"Z", 30.0}}}};
  return options;
}

// B turns the head, C the table: both turn the tool as the table sees it.
compensate::Compensator Leaning(std::optional<double> b_limit_deg = std::nullopt) {
  machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  if (b_limit_deg) {
    machine::Axis& b = machine.axes[static_cast<size_t>(machine::FindAxis(machine, "B"))];
    b.min_position = -1e-3;
    b.max_position = *b_limit_deg * base::kRadPerDeg;
  }
  return testing::MustCreate(machine, testing::ConstantErrors(machine, {{"EB0B", testing::kTiltRad}, {"EX0C", 0.03}}),
                             kGaugeMm);
}

// The words of the direction from the tool's tip to the spindle at B and C, by hand.
std::string Vector(const std::string& dialect, double b_deg, double c_deg) {
  const double b = b_deg * base::kRadPerDeg, c = c_deg * base::kRadPerDeg;
  const double x = std::cos(c) * std::sin(b), y = -std::sin(c) * std::sin(b), z = std::cos(b);
  if (dialect == "sinumerik") return absl::StrFormat(" A3=%.9f B3=%.9f C3=%.9f", x, y, z);
  if (dialect == "heidenhain") return absl::StrFormat(" TX%+.9f TY%+.9f TZ%+.9f", x, y, z);
  return absl::StrFormat(" I%.9f J%.9f K%.9f", x, y, z);
}

std::string WithVectors(const std::string& dialect) {
  const auto at = [&](double b_deg, double c_deg) { return Vector(dialect, b_deg, c_deg); };
  if (dialect == "sinumerik") {
    return "G90 G54 D1\nTRAORI\nG54 ORIAXES\nG0 X10 Y20 Z30 B20 C40\nG1 X11 Y21" + at(22, 45) + " F100\nX12" +
           at(35, 60) + "\nZ31\n";
  }
  if (dialect == "heidenhain") {
    return "BEGIN PGM A MM\nTOOL CALL 1 Z S100\nL X+10 Y+20 Z+30 B+20 C+40 FMAX M128\nLN X+11 Y+21" + at(22, 45) +
           " F100\nLN X+12 NX+0 NY+0 NZ+1" + at(35, 60) + "\nL Z+31\nM129\nEND PGM A MM\n";
  }
  return "G90 G0 X0. Y0. Z200. B20. C40.\nG43.5 H1 X10. Y20. Z30.\nG1 X11. Y21." + at(22, 45) + " F100\nX12." +
         at(35, 60) + "\nZ31.\n";
}

std::string WithAngles(const std::string& dialect) {
  if (dialect == "sinumerik")
    return "G90 G54 D1\nTRAORI\nG54 ORIAXES\nG0 X10 Y20 Z30 B20 C40\nG1 X11 Y21 B22 C45 F100\nX12 B35 C60\nZ31\n";
  if (dialect == "heidenhain") {
    return "BEGIN PGM A MM\nTOOL CALL 1 Z S100\nL X+10 Y+20 Z+30 B+20 C+40 FMAX M128\nL X+11 Y+21 B+22 C+45 F100\n"
           "L X+12 B+35 C+60\nL Z+31\nM129\nEND PGM A MM\n";
  }
  return "G90 G0 X0. Y0. Z200. B20. C40.\nG43.4 H1 X10. Y20. Z30.\nG1 X11. Y21. B22. C45. F100\nX12. B35. C60.\nZ31.\n";
}

// The words of X, Y and Z in order.
std::string Places(const std::string& text) {
  std::string places;
  for (size_t at = 0; at < text.size(); ++at) {
    const bool is_word = (text[at] == 'X' || text[at] == 'Y' || text[at] == 'Z') && at > 0 && text[at - 1] == ' ';
    if (!is_word) continue;
    while (at < text.size() && text[at] != ' ' && text[at] != '\n') places += text[at++];
    places += ' ';
  }
  return places;
}

TEST(ToolVector, LinearWordsAreThoseOfTheSameProgramInAngles) {
  for (const std::string dialect : {"fanuc", "mazak", "sinumerik", "heidenhain"}) {
    RewriteOptions options = Options(dialect);
    options.tolerance_mm = 1.0;  // no pieces
    const Outcome vectors = Rewritten(WithVectors(dialect), options, Leaning());
    const Outcome angles = Rewritten(WithAngles(dialect), options, Leaning());
    ASSERT_TRUE(vectors.status.ok()) << dialect << " " << vectors.status;
    ASSERT_TRUE(angles.status.ok()) << dialect << " " << angles.status;
    EXPECT_EQ(Places(vectors.text), Places(angles.text)) << vectors.text << angles.text;
    EXPECT_NE(Places(vectors.text), Places(WithVectors(dialect)));
    // The direction stays to the byte.
    EXPECT_THAT(vectors.text, HasSubstr(Vector(dialect, 22, 45)));
    EXPECT_THAT(vectors.text, HasSubstr(Vector(dialect, 35, 60)));
  }
}

// Between the pieces of a move the tool stands where the axes would stand at that share of the move.
TEST(ToolVector, PiecesStateTheDirectionAtTheirEnds) {
  for (const std::string dialect : {"fanuc", "sinumerik", "heidenhain"}) {
    RewriteOptions options = Options(dialect);
    options.tolerance_mm = 2e-4;
    const compensate::Compensator leaning = Leaning();
    const std::string source = WithVectors(dialect);
    const Outcome outcome = Rewritten(source, options, leaning);
    ASSERT_TRUE(outcome.status.ok()) << dialect << " " << outcome.status;
    EXPECT_GE(outcome.report.blocks_split, 1) << outcome.text;
    EXPECT_THAT(outcome.text, Not(HasSubstr("B23"))) << outcome.text;
    EXPECT_EQ(outcome.text.find("\nLN X+") != std::string::npos, dialect == "heidenhain") << outcome.text;
    VerifyOptions verify;
    verify.tool_tip_mm = kGaugeMm;
    verify.reading = options;
    const machine::Machine& machine = leaning.machine();
    const auto report =
        VerifyText(source, outcome.text, machine,
                   testing::ConstantErrors(machine, {{"EB0B", testing::kTiltRad}, {"EX0C", 0.03}}), verify);
    ASSERT_TRUE(report.ok()) << report.status();
    EXPECT_EQ(report->moves_unknown, 0);
    EXPECT_GT(report->end_before.max_mm, 0.01);
    EXPECT_LT(report->end_after.max_mm, 2e-4);
    EXPECT_LT(report->path_after.max_mm, 4e-4);
  }
}

// The tool point stands, and its words are inserted where the control reads them.
TEST(ToolVector, AVectorAloneGetsTheWordsThatTheCorrectionNeeds) {
  const Outcome klartext = Rewritten(
      "TOOL CALL 1 Z S100\nL X+10 Y+20 Z+30 B+20 C+40 FMAX M128\nLN" + Vector("heidenhain", 35, 60) + " FMAX\n",
      Options("heidenhain"), Leaning());
  ASSERT_TRUE(klartext.status.ok()) << klartext.status;
  EXPECT_THAT(klartext.text, ::testing::ContainsRegex("\nLN X\\+10[.][0-9]+ .*TX.*TZ.* FMAX\n"));
  const Outcome fanuc = Rewritten("G90 G0 X0. Y0. Z200. B20. C40.\nG43.5 H1 X10. Y20. Z30.\nG0" +
                                      Vector("fanuc", 35, 60) + "\nG93 G1" + Vector("fanuc", 20, 40) + " F9.\n",
                                  Options("fanuc"), Leaning());
  ASSERT_TRUE(fanuc.status.ok()) << fanuc.status;
  EXPECT_THAT(fanuc.text, ::testing::ContainsRegex("\nG0 I.* K0[.][0-9]+ X"));
  EXPECT_THAT(fanuc.text, ::testing::ContainsRegex("\nG93 G1 I.* K0[.][0-9]+ X.* F9"));
}

TEST(ToolVector, WhatTheControlWouldChooseIsRefusedByName) {
  const std::string begin = "G90 G0 X0. Y0. Z200. B20. C40.\nG43.5 H1 X10. Y20. Z30.\n";
  const std::string tcpm = "TOOL CALL 1 Z S100\nL X+10 Y+20 Z+30 B+20 C+40 FMAX M128\n";
  struct Case {
    std::string dialect, program, reason;
  };
  const Case cases[] = {
      // B turns through zero, or C by half a turn.
      {"fanuc", begin + "G1 X11." + Vector("fanuc", -20, 40) + " F9\n", "several positions of the rotary axes"},
      {"heidenhain", "TOOL CALL 1 Z S100\nM128\nLN X+1 Y+1 Z+1" + Vector("heidenhain", 21, 40) + " FMAX\n",
       "where the rotary axes stand is not known"},
      {"fanuc", begin + "G1 X11. I0. J0. K1. F9\n", "the tool stands along the axis C"},
      {"fanuc", "G90 G0 X0. Y0. Z200. B0. C130.\nG43.5 H1 X10. Y20. Z30." + Vector("fanuc", 20, 40) + "\n",
       "several positions"},
      {"fanuc", begin + "G1 X11. I0.5 K0.5 F9\n", "not all of I, J and K"},
      {"fanuc", begin + "G1 X11. I0. J0. K0. F9\n", "the vector of the tool's direction is zero"},
      {"fanuc", begin + "G1 X11. I0.5 I0.5 J0. K1. F9\n", "two words"},
      {"fanuc", begin + "G1 X11. B21. F9\n", "word B under G43.5"},
      {"fanuc", begin + "G91 G1 X1." + Vector("fanuc", 21, 40) + " F9\n", "in G91"},
      {"fanuc", begin + "G2 X11. Y21. I5. F9\n", "a circular move under tool centre point control"},
      {"fanuc", begin + "G1" + Vector("fanuc", 21, 40) + " F9\n", "program the move in G93"},
      {"haas", "G43.5 H1\nG1 X1. F9\n", "tool centre point control"},
      {"sinumerik", "G54 D1\nG0 X1 Y1 Z1 B0 C0\nG1 A3=0 B3=0 C3=1 F9\n", "no tool centre point control"},
      {"sinumerik", "G54 D1\nTRAORI\nG54\nG0 X1 Y1 Z1 B20 C40\nG1 X2" + Vector("sinumerik", 30, 60) + " F9\n",
       "state ORIAXES"},
      {"sinumerik", "G54 D1\nTRAORI\nG54 ORIAXES\nG0 X1 Y1 Z1 B20 C40\nG1 C45" + Vector("sinumerik", 21, 40) + " F9\n",
       "word C and A3=, B3= and C3= in one block"},
      {"heidenhain", tcpm + "LN X+1 Y+1 Z+1 NX+0 NY+0 NZ+1 F9\n", "without TX, TY and TZ"},
      {"heidenhain", tcpm + "L X+1" + Vector("heidenhain", 21, 40) + " F9\n", "without LN"},
      {"heidenhain", tcpm + "L X+1 NX+0 NY+0 NZ+1 F9\n", "NX, NY and NZ without LN"},
      {"heidenhain", tcpm + "LN X+1 TX+0.5 TY+0 TZ+0.5 F9\n", "has not the length 1"},
      {"heidenhain",
       "TOOL CALL 1 Z DR+0.1\nL X+1 Y+1 Z+1 B+20 C+40 FMAX M128\nLN X+1" + Vector("heidenhain", 21, 40) + "\n",
       "difference of the tool's radius"},
      {"heidenhain", "TOOL CALL 1 Z\nL X+1 Y+1 Z+1 B+20 C+40 FMAX\nLN X+1" + Vector("heidenhain", 21, 40) + "\n",
       "no tool centre point control"},
  };
  for (const Case& known : cases) {
    const Outcome outcome = Rewritten(known.program, Options(known.dialect), Leaning());
    EXPECT_FALSE(outcome.status.ok()) << known.program << outcome.text;
    std::string reasons;
    for (const Finding& finding : outcome.report.refused) reasons += finding.reason + "\n";
    EXPECT_THAT(reasons, HasSubstr(known.reason)) << known.program;
  }
  RewriteOptions turned = Options("fanuc");
  turned.orientation = true;
  const Outcome outcome = Rewritten(begin, turned, Leaning());
  EXPECT_THAT(std::string(outcome.status.message()), HasSubstr("with --orientation it is not followed"));
}

// What makes it known: a tool that stands along the vector stays, and travel limits leave one place.
TEST(ToolVector, TheToolThatStandsSoStaysAndLimitsLeaveOnePlace) {
  const Outcome stays = Rewritten("G90 G0 X0. Y0. Z200. B0. C90.\nG43.5 H1 X10. Y20. Z30. I0. J0. K1.\nG1 X11. F100\n",
                                  Options("fanuc"), Leaning());
  ASSERT_TRUE(stays.status.ok()) << stays.status;
  const Outcome angles = Rewritten("G90 G0 X0. Y0. Z200. B0. C90.\nG43.4 H1 X10. Y20. Z30. B0. C90.\nG1 X11. F100\n",
                                   Options("fanuc"), Leaning());
  EXPECT_EQ(Places(stays.text), Places(angles.text));
  const std::string crossing = "G90 G0 X0. Y0. Z200. B20. C40.\nG43.5 H1 X10. Y20. Z30.\nG0 X11." +
                               Vector("fanuc", -20, 80) + "\nG1 X12. F100\n";
  EXPECT_FALSE(Rewritten(crossing, Options("fanuc"), Leaning()).status.ok());
  // B- 20 is beyond its travel: B20 C260 alone is left, or C-100, which is nearer.
  const Outcome limited = Rewritten(crossing, Options("fanuc"), Leaning(100.0));
  EXPECT_TRUE(limited.status.ok()) << limited.status;
}

}  // namespace
}  // namespace axiscal::nc
