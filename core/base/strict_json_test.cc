#include "core/base/strict_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace axiscal::base {
namespace {

using ::testing::HasSubstr;

std::string Problem(const std::string& text) { return std::string(ParseStrictJson(text).status().message()); }

TEST(StrictJson, KeepsTheOrderOfMembers) {
  const auto document = ParseStrictJson(R"({"b": 1, "a": [2.5, "x"]})");
  ASSERT_TRUE(document.ok());
  EXPECT_EQ(document->dump(), R"({"b":1,"a":[2.5,"x"]})");
}

TEST(StrictJson, SyntaxErrorsNameLineAndColumn) {
  EXPECT_THAT(Problem("{\n \"a\": 1,\n}"), HasSubstr("line 3, column 1"));
  EXPECT_THAT(Problem("{\"a\": 1"), HasSubstr("line 1, column 8"));
  EXPECT_THAT(Problem("{\"a\": NaN}"), HasSubstr("line 1, column 7"));
  EXPECT_THAT(Problem("{} trailing"), HasSubstr("expected end of input"));
  EXPECT_EQ(Problem("[1e999]"), "number overflow parsing '1e999'");
  EXPECT_EQ(Problem(""), "is empty, expected a JSON object");
}

TEST(StrictJson, DuplicateKeysAreRefusedAtAnyDepthButNotAcrossObjects) {
  EXPECT_EQ(Problem(R"({"a": 1, "a": 2})"), "'a' is there twice");
  EXPECT_EQ(Problem(R"({"o": [{"k": 1}, {"k": 2, "k": 3}]})"), "'k' is there twice");
  EXPECT_TRUE(ParseStrictJson(R"({"o": {"k": 1}, "p": {"k": 1}})").ok());
}

TEST(StrictJson, LimitsAreStated) {
  EXPECT_EQ(Problem(std::string(100000, '[') + std::string(100000, ']')), "nested deeper than 16 levels");
  EXPECT_THAT(Problem(std::string(kMaxJsonBytes + 1, ' ')), HasSubstr("at most 4194304 are read"));
}

}  // namespace
}  // namespace axiscal::base
