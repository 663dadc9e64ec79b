#include "core/logs/line_pattern.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace axiscal::logs {
namespace {

using ::testing::HasSubstr;

LinePattern Pattern(const std::string& text) {
  auto pattern = ParsePattern(text);
  EXPECT_TRUE(pattern.ok()) << pattern.status();
  return pattern.ok() ? *pattern : LinePattern();
}

double Number(const LinePattern& pattern, const Match& match, const std::string& field) {
  for (size_t i = 0; i < pattern.pieces.size() && match.is_match; ++i) {
    if (pattern.pieces[i].field == field) return match.fields[i].number;
  }
  return NAN;
}

TEST(LinePattern, TaggedFieldsComeInAnyOrderWithBlanksAnywhereBeforeDigits) {
  const LinePattern pattern = Pattern("X{X_mm} Y{Y_mm} B{B_deg}");
  ASSERT_TRUE(pattern.is_any_order);
  for (const char* line : {"X-390.0000 Y0.2500 B30.0000", "B30.0000 Y0.2500 X-390.0000", "X-390.0000Y0.2500B30.0000",
                           "  X  -390.0000   Y   0.2500 B 30.0000  ", "X-  390.0000 Y+.25 B30."}) {
    const Match match = MatchLine(pattern, line);
    ASSERT_TRUE(match.is_match) << line << ": column " << match.column << " expected " << match.expected;
    EXPECT_EQ(Number(pattern, match, "X_mm"), -390.0) << line;
    EXPECT_EQ(Number(pattern, match, "Y_mm"), 0.25) << line;
    EXPECT_EQ(Number(pattern, match, "B_deg"), 30.0) << line;
  }
}

TEST(LinePattern, AFailureNamesColumnAndWhatWasExpected) {
  const LinePattern pattern = Pattern("X{X_mm} Y{Y_mm}");
  const struct {
    const char* line;
    size_t column;
    const char* expected;
  } rows[] = {{"X1.0 Q2.0", 5, "a field of 'X{X_mm} Y{Y_mm}'"},
              {"X1.0 X2.0", 5, "X once"},
              {"X1.0 Yabc", 6, "a number for Y_mm"},
              {"X1.0", 4, "also Y with a number for Y_mm"},
              {"X1.0 Y-", 7, "a number for Y_mm"},
              {"X1.0 Y2.0,5", 9, "a field of"},
              {"X1.0.0 Y2", 4, "a field of"}};
  for (const auto& row : rows) {
    const Match match = MatchLine(pattern, row.line);
    EXPECT_FALSE(match.is_match) << row.line;
    EXPECT_EQ(match.column, row.column) << row.line;
    EXPECT_THAT(match.expected, HasSubstr(row.expected)) << row.line;
  }
}

TEST(LinePattern, FieldsWithoutTagsStandInOrder) {
  const LinePattern numbers = Pattern("{X_mm} {Y_mm} {Z_mm}");
  EXPECT_FALSE(numbers.is_any_order);
  const Match match = MatchLine(numbers, "-390.000000 0.000000 -464.511800");
  ASSERT_TRUE(match.is_match);
  EXPECT_EQ(Number(numbers, match, "Z_mm"), -464.5118);
  EXPECT_EQ(match.fields[2].decimals, 6);
  EXPECT_FALSE(MatchLine(numbers, "1 2").is_match);
  EXPECT_FALSE(MatchLine(numbers, "1 2 3 4").is_match);
  EXPECT_FALSE(MatchLine(numbers, "1a 2 3").is_match);
  EXPECT_FALSE(MatchLine(numbers, "1.2.3 4").is_match);  // no blank behind a number

  const LinePattern cells = Pattern("{*},{B_deg},1,{cx_mm};{feature}");
  const Match row = MatchLine(cells, "B-short, 90 ,1,-493.2167; top face ");
  ASSERT_TRUE(row.is_match) << row.column << row.expected;
  EXPECT_EQ(Number(cells, row, "B_deg"), 90.0);
  EXPECT_EQ(Number(cells, row, "cx_mm"), -493.2167);
  EXPECT_EQ(row.fields[3].text, "top face");
  EXPECT_FALSE(MatchLine(cells, "B-short,90,2,-493.2167;top").is_match);
  EXPECT_TRUE(MatchLine(Pattern("Feature Model {*}"), "Feature Model PLANE").is_match);
  EXPECT_TRUE(MatchLine(Pattern("Feature Model {*}"), "Feature  Model").is_match);
  EXPECT_FALSE(MatchLine(Pattern("Feature Model"), "Feature Model PLANE").is_match);
}

// Tables of columns with blanks between: a text is then one word.
TEST(LinePattern, ATextEndsAtABlankWhereNothingElsePartsTheFields) {
  const LinePattern table = Pattern("{*} {L_mm} {*} {temp_C}");
  const Match match = MatchLine(table, "  -270.000\t-267.88475  ok 18.00");
  ASSERT_TRUE(match.is_match) << match.column << match.expected;
  EXPECT_EQ(Number(table, match, "L_mm"), -267.88475);
  EXPECT_EQ(Number(table, match, "temp_C"), 18.0);
  EXPECT_FALSE(MatchLine(table, "-270.000 -267.88475 18.00").is_match);
  const Match rod = MatchLine(Pattern("{rod} {Z_mm}"), "standard -376.137");
  ASSERT_TRUE(rod.is_match);
  EXPECT_EQ(rod.fields[0].text, "standard");
}

TEST(LinePattern, NumbersMayHaveADecimalCommaOrAnExponent) {
  LinePattern cells = Pattern("{t_s};{L_mm}");
  const Match asked = MatchLine(cells, "1;1615,645");
  EXPECT_FALSE(asked.is_match);
  EXPECT_EQ(asked.column, 6u);
  EXPECT_THAT(asked.expected, HasSubstr("the template says 'decimal: ,'"));
  EXPECT_THAT(MatchLine(Pattern("X{X_mm} Y{Y_mm}"), "X1,5 Y2").expected, HasSubstr("'decimal: ,'"));
  cells.decimal = ',';
  const Match comma = MatchLine(cells, "1,5;- 1615,645");
  ASSERT_TRUE(comma.is_match) << comma.expected;
  EXPECT_EQ(Number(cells, comma, "t_s"), 1.5);
  EXPECT_EQ(Number(cells, comma, "L_mm"), -1615.645);
  EXPECT_EQ(comma.fields[1].decimals, 3);
  EXPECT_FALSE(MatchLine(cells, "1.5;2").is_match);
  // A comma that parts fields has no digit of a decimal behind it, or stands behind one.
  LinePattern parted = Pattern("X{X_mm}, Y{Y_mm}");
  parted.decimal = ',';
  EXPECT_EQ(Number(parted, MatchLine(parted, "X1,25, Y-3"), "Y_mm"), -3.0);
  const LinePattern small = Pattern("{dx_mm} {dy_mm}");
  const Match exponent = MatchLine(small, "-1.25e-03 2E+01");
  ASSERT_TRUE(exponent.is_match) << exponent.expected;
  EXPECT_EQ(Number(small, exponent, "dx_mm"), -0.00125);
  EXPECT_EQ(Number(small, exponent, "dy_mm"), 20.0);
  EXPECT_EQ(exponent.fields[0].decimals, 2);
  const LinePattern tagged = Pattern("X{X_mm} E{E_mm}");
  EXPECT_EQ(Number(tagged, MatchLine(tagged, "X1.5E2"), "E_mm"), 2.0);
}

TEST(LinePattern, BadPatternsAreRefused) {
  for (const char* text : {"X{X_mm", "X}", "X{}", "X{X_mm} Y{X_mm}", "{*}{X_mm}", "{feature}{X_mm}"})
    EXPECT_FALSE(ParsePattern(text).ok()) << text;
}

}  // namespace
}  // namespace axiscal::logs
