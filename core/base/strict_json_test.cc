#include "core/base/strict_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

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

// An object of `keys` distinct keys, and about the same text as objects of ten.
std::string WideObject(int keys) {
  std::string text = "{";
  for (int i = 0; i < keys; ++i) absl::StrAppend(&text, i == 0 ? "" : ",", "\"k", i, "\":1");
  return text + "}";
}
std::string ManyObjects(int keys) {
  std::string text = "[";
  for (int i = 0; i < keys; i += 10) absl::StrAppend(&text, i == 0 ? "" : ",", WideObject(10));
  return text + "]";
}

TEST(StrictJson, TheCostOfAnObjectGrowsNoFasterThanItsText) {
  constexpr int kKeys = 250'000;         // 3.4 MB: a search of all keys for each is 3e10 comparisons
  constexpr int kManyTimesTheCost = 60;  // sorting and caches cost a few times as much as small objects do
  std::atomic<bool> is_read = false;
  std::thread wide([&is_read, text = WideObject(kKeys)] {
    const auto document = ParseStrictJson(text);
    EXPECT_TRUE(document.ok() && document->size() == kKeys) << document.status();
    is_read = true;
  });
  const std::string many = ManyObjects(kKeys);
  int rounds = 0;
  for (; !is_read && rounds < kManyTimesTheCost; ++rounds) EXPECT_TRUE(ParseStrictJson(many).ok());
  EXPECT_LT(rounds, kManyTimesTheCost) << "the wide object is not read yet";
  wide.join();
}

TEST(StrictJson, AMessageCutsNoCharacterInTwo) {
  const nlohmann::ordered_json value = absl::StrCat(std::string(55, 'a'), "\xC3\xBC\xC3\xBC and more");
  EXPECT_EQ(ShortJson(value), absl::StrCat("\"", std::string(55, 'a'), "..."));
}

TEST(StrictJson, DepthCountsOpenObjectsAndArrays) {
  const auto nested = [](int levels) { return absl::StrCat(std::string(levels, '['), "1", std::string(levels, ']')); };
  EXPECT_TRUE(ParseStrictJson(nested(16)).ok());
  EXPECT_EQ(Problem(nested(17)), "nested deeper than 16 levels");
}

TEST(StrictJson, LimitsAreStated) {
  EXPECT_EQ(Problem(std::string(100000, '[') + std::string(100000, ']')), "nested deeper than 16 levels");
  EXPECT_THAT(Problem(std::string(kMaxJsonBytes + 1, ' ')), HasSubstr("at most 4194304 are read"));
}

}  // namespace
}  // namespace axiscal::base
