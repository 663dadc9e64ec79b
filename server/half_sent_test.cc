#include "server/half_sent.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace axiscal::server {
namespace {

using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

constexpr int64_t kMega = 1 << 20;

class HalfSentTest : public ::testing::Test {
 protected:
  std::set<std::string> Look() {
    return half_sent_.TooMuch(brought_, [this](const std::string& peer) -> std::optional<WaitingCalls> {
      const auto found = waiting_.find(peer);
      return found == waiting_.end() ? std::nullopt : std::optional(found->second);
    });
  }

  HalfSent half_sent_{100 * kMega, 4 * kMega};
  std::map<std::string, Traffic> brought_;
  std::map<std::string, WaitingCalls> waiting_;
};

TEST_F(HalfSentTest, ThoseThatHaveMostAreEnded) {
  brought_ = {{"a", {}}, {"b", {}}, {"c", {}}};
  waiting_ = {{"a", {100}}, {"b", {100}}, {"c", {100}}};
  EXPECT_THAT(Look(), IsEmpty());
  brought_ = {{"a", {30 * kMega}}, {"b", {50 * kMega}}, {"c", {40 * kMega}}};
  EXPECT_THAT(Look(), UnorderedElementsAre("b"));
  brought_.erase("b");
  EXPECT_THAT(Look(), IsEmpty());
  brought_["a"].brought += 30 * kMega;
  EXPECT_THAT(Look(), UnorderedElementsAre("a"));
}

TEST_F(HalfSentTest, OfOneThatComesAllCounts) {
  brought_ = {{"a", {1000 * kMega}}};
  waiting_ = {{"a", {1000}}};
  EXPECT_THAT(Look(), IsEmpty());
  for (const std::string peer : {"b", "c", "d"}) {
    brought_[peer].brought = 40 * kMega;  // at once, and then nothing
    waiting_[peer] = {10};
  }
  EXPECT_EQ(Look().size(), 1u);
  half_sent_.Rest();
  EXPECT_THAT(Look(), IsEmpty());
  // Another connection with the address of one that was heard.
  brought_["a"].brought = 120 * kMega;
  EXPECT_THAT(Look(), UnorderedElementsAre("a"));
}

TEST_F(HalfSentTest, WhatWasHeardCountsNoLonger) {
  brought_ = {{"a", {}}};
  waiting_ = {{"a", {1000}}};
  EXPECT_THAT(Look(), IsEmpty());
  brought_["a"].brought = 200 * kMega;
  waiting_["a"] = {1000, true};
  EXPECT_THAT(Look(), IsEmpty());
  waiting_["a"].was_none = false;
  brought_["a"].brought += 70 * kMega;
  EXPECT_THAT(Look(), IsEmpty());
  brought_["a"].brought += 70 * kMega;
  EXPECT_THAT(Look(), UnorderedElementsAre("a"));
}

TEST_F(HalfSentTest, FewCallsThatWaitAreLittle) {
  for (const char peer : std::string("abcdefgh")) {
    brought_[std::string(1, peer)] = {};
    waiting_[std::string(1, peer)] = {3};
  }
  EXPECT_THAT(Look(), IsEmpty());
  for (auto& [peer, traffic] : brought_) traffic.brought = 1000 * kMega;  // much was heard, though never all
  EXPECT_THAT(Look(), IsEmpty());
}

TEST_F(HalfSentTest, HeadsAloneCount) {
  brought_ = {{"a", {}}, {"b", {}}};
  waiting_ = {{"a", {10'000}}, {"b", {10}}};
  EXPECT_THAT(Look(), UnorderedElementsAre("a"));
}

TEST_F(HalfSentTest, OfWhomNothingIsHeardAllCounts) {
  brought_ = {{"a", {5000 * kMega}}, {"b", {}}};
  EXPECT_THAT(Look(), IsEmpty());  // came before anybody looked
  brought_["b"].brought = 101 * kMega;
  EXPECT_THAT(Look(), UnorderedElementsAre("b"));
}

}  // namespace
}  // namespace axiscal::server
