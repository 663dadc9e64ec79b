#include "core/nc/lexer.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <string>
#include <tuple>
#include <vector>

namespace axiscal::nc {
namespace {

Block Lexed(const std::string& text) {
  Block block;
  Lex(text.data(), text.size(), *FindDialect("fanuc"), &block);
  return block;
}

TEST(Lexer, WordsKnowTheirBytesAndNumbers) {
  const std::string text = "N10 g1X-12.50 Y+.5(X9.)Z 1 2.5";
  const Block block = Lexed(text);
  ASSERT_EQ(block.problem, LexProblem::kNone);
  ASSERT_EQ(block.word_count, 5);
  EXPECT_EQ(block.words[1].letter, 'G');
  EXPECT_TRUE(block.words[1].is_lower);
  const Word& x = block.words[2];
  EXPECT_EQ(text.substr(x.number_at, x.end - x.number_at), "-12.50");
  EXPECT_EQ(x.number.mantissa, -1250);
  EXPECT_EQ(x.number.decimals, 2);
  EXPECT_TRUE(block.words[3].number.has_plus);
  EXPECT_EQ(block.words[3].number.mantissa, 5);
  const Word& z = block.words[4];
  EXPECT_EQ(text.substr(z.number_at, z.end - z.number_at), "1 2.5");
  EXPECT_EQ(z.number.mantissa, 125);
}

TEST(Lexer, ProblemsNameTheirColumn) {
  const struct {
    const char* text;
    LexProblem problem;
    uint32_t at;
  } kCases[] = {
      {"(a (b) c)", LexProblem::kNestedComment, 3}, {"G1 (open", LexProblem::kUnclosedComment, 3},
      {"G1 X Y5", LexProblem::kNoNumber, 3},        {"G1 X#5", LexProblem::kExpression, 3},
      {"G1 ,A5", LexProblem::kExpression, 3},       {"X1.2.3", LexProblem::kStrayCharacter, 4},
      {"X--3", LexProblem::kNoNumber, 0},           {"G1 \xFF", LexProblem::kStrayCharacter, 3},
      {"N5 /X1", LexProblem::kSlashInside, 3},      {"X", LexProblem::kNoNumber, 0},
      {"G1\rX5", LexProblem::kStrayCharacter, 2},
  };
  for (const auto& known : kCases) {
    const Block block = Lexed(known.text);
    EXPECT_EQ(block.problem, known.problem) << known.text << ": " << ToString(block.problem, block.problem_at);
    EXPECT_EQ(block.problem_at, known.at) << known.text;
  }
}

TEST(Lexer, NumbersForVariablesAreNoWords) {
  for (const std::string text : {"#100=5", "N10 #100 = -5.2 (depth)", "#1=1. #33=+.5", "#549=0;end"}) {
    const Block block = Lexed(text);
    EXPECT_EQ(block.problem, LexProblem::kNone) << text << ": " << ToString(block.problem, block.problem_at);
    EXPECT_TRUE(block.has_assignment) << text;
    EXPECT_EQ(block.word_count, text[0] == 'N' ? 1 : 0) << text;
  }
  for (const std::string text : {"#100=#101", "#5221=5", "#3000=1", "#100=", "#100=5X1", "#100=1.2.3", "#=5", "#100",
                                 "#[100]=5", "#100=5*2", "#99999999999999999999=5", "G1 X#100=5"})
    EXPECT_EQ(Lexed(text).problem, LexProblem::kExpression) << text;
}

TEST(Lexer, BlankBlocksAndSlashesAreBlocks) {
  EXPECT_EQ(Lexed("").word_count, 0);
  EXPECT_EQ(Lexed(" \t").problem, LexProblem::kNone);
  EXPECT_TRUE(Lexed("/").is_deletable);
  const Block block = Lexed("/3 G1");
  EXPECT_TRUE(block.is_deletable);
  EXPECT_EQ(block.word_count, 1);
  EXPECT_EQ(Lexed("\r\rG1").word_count, 1);  // punched tape: LF CR CR
}

TEST(Lexer, MoreWordsThanABlockHoldsAreAProblem) {
  std::string text;
  for (int i = 0; i < kMaxWords; ++i) text += "X1";
  EXPECT_EQ(Lexed(text).problem, LexProblem::kNone);
  EXPECT_EQ(Lexed(text + "X1").problem, LexProblem::kTooManyWords);
}

TEST(Decimal, PositionsAreExact) {
  EXPECT_EQ(ToTicks({25, 1, 2, true, false}, kTicksPerMm), 25'000'000'000);
  EXPECT_EQ(ToTicks({1, 9, 10, true, false}, kTicksPerInch), 254);  // a billionth of an inch
  EXPECT_FALSE(ToTicks({1, 10, 10, true, false}, kTicksPerMm).has_value());
  EXPECT_FALSE(ToTicks({999'999'999'999'999'999, 0, 18, false, false}, kTicksPerMm).has_value());
  EXPECT_EQ(RoundToGrains(149, 100), 1);
  EXPECT_EQ(RoundToGrains(150, 100), 2);
  EXPECT_EQ(RoundToGrains(-150, 100), -2);
  EXPECT_EQ(RoundToGrains(-49, 100), 0);
  constexpr Ticks kBeyondDouble = (Ticks{1} << 60) + 1;
  EXPECT_EQ(RoundToGrains(kBeyondDouble, 1), kBeyondDouble);
}

TEST(Decimal, FixedNotation) {
  const auto fixed = [](int64_t mantissa, int decimals, bool plus, bool point) {
    std::string text;
    AppendFixed(mantissa, decimals, plus, point, &text);
    return text;
  };
  EXPECT_EQ(fixed(-123456, 4, false, true), "-12.3456");
  EXPECT_EQ(fixed(5, 4, true, true), "+0.0005");
  EXPECT_EQ(fixed(0, 4, false, true), "0.0000");
  EXPECT_EQ(fixed(12, 0, false, true), "12.");
  EXPECT_EQ(fixed(12, 0, false, false), "12");
  EXPECT_EQ(fixed(std::numeric_limits<int64_t>::min(), 3, false, true), "-9223372036854775.808");
}

// A block that is lexed behind another one, whose words lend it their layout, has the words that it has alone.
TEST(Lexer, WhatStoodInTheLineBeforeChangesNothing) {
  std::mt19937 random(7);
  const auto one_of = [&](const std::vector<std::string>& all) { return all[random() % all.size()]; };
  const auto digits = [&](size_t least, size_t most) {
    std::string text;
    for (size_t size = least + random() % (most - least + 1); text.size() < size;)
      text += static_cast<char>('0' + random() % 10);
    return text;
  };
  const Dialect& dialect = *FindDialect("fanuc");
  Block after;
  int plain = 0;
  for (int i = 0; i < 100000; ++i) {
    std::string text;
    for (int words = 0; words < 4; ++words) {
      const std::string fraction = random() % 4 == 0 ? "" : "." + digits(random() % 8 == 0 ? 0 : 3, 4);
      text += one_of({"X", "Y", "F", "G", "x"}).substr(random() % 40 == 0) + one_of({"", "-", "+", "-"}) +
              digits(random() % 20 == 0 ? 0 : 1, random() % 20 == 0 ? 19 : 3) + fraction +
              one_of({"", " ", " ", "  ", " 5", "#", "."}).substr(0, random() % 3);
    }
    Lex(text.data(), text.size(), dialect, &after);
    const Block alone = Lexed(text);
    ASSERT_EQ(after.problem, alone.problem) << text;
    ASSERT_EQ(after.word_count, alone.word_count) << text;
    plain += alone.problem == LexProblem::kNone;
    for (int k = 0; k < alone.word_count; ++k) {
      const Word &a = after.words[static_cast<size_t>(k)], &b = alone.words[static_cast<size_t>(k)];
      ASSERT_EQ(std::tie(a.letter, a.is_lower, a.distance, a.letter_at, a.number_at, a.end),
                std::tie(b.letter, b.is_lower, b.distance, b.letter_at, b.number_at, b.end))
          << text;
      ASSERT_EQ(std::tie(a.number.mantissa, a.number.decimals, a.number.digits, a.number.has_point, a.number.has_plus),
                std::tie(b.number.mantissa, b.number.decimals, b.number.digits, b.number.has_point, b.number.has_plus))
          << text;
    }
  }
  EXPECT_GT(plain, 30000);
}

// Against digits written one by one, at every length and place of the point.
TEST(Decimal, FixedNotationOfEveryLength) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 20000; ++i) {
    const int decimals = static_cast<int>(random() % (kMaxDecimals + 1));
    const auto size = static_cast<int64_t>(random() >> (1 + random() % 63));
    std::string digits = std::to_string(size);
    digits.insert(0, std::max<size_t>(static_cast<size_t>(decimals) + 1, digits.size()) - digits.size(), '0');
    digits.insert(digits.size() - static_cast<size_t>(decimals), decimals > 0 ? "." : "");
    std::string text;
    AppendFixed(-size, decimals, false, false, &text);
    EXPECT_EQ(text, (size == 0 ? "" : "-") + digits);
  }
}

}  // namespace
}  // namespace axiscal::nc
