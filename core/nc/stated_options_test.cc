#include "core/nc/stated_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/nc/testing/yao.h"

namespace axiscal::nc {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Axes X, Y, Z, B, C.
const machine::Machine& Machine() {
  static const machine::Machine machine = machine::testing::MultiTasking();
  return machine;
}

machine::ProgramProfile Profile() {
  machine::ProgramProfile words;
  words.tool_tip = "0 0 -150.5";
  words.dialect = "haas";
  words.unit = "inch";
  words.integer_words = "increments";
  words.decimals = "3";
  words.block_delete = "skipped";
  words.harmless_m = "47,120-122";
  words.start = "B=90";
  words.tool_change_keeps = "B C";
  words.offsets = {"g54.1P05 X=-490 C=90", "G55 Y=1"};
  words.tool_lengths = {"H1=120.5", "T5D1=80"};
  words.tool_radii = {"D1=5"};
  return words;
}

StatedOptions Nothing() { return *ReadStated({}, StatedBy::kOptions, Machine()); }

TEST(StatedOptions, AProfileSaysAllThatIsOpen) {
  StatedOptions stated = Nothing();
  const auto taken = TakeProfile(Profile(), Machine(), &stated);
  ASSERT_TRUE(taken.ok()) << taken.status();
  EXPECT_EQ(*taken,
            "--tool-tip, --dialect, --unit, --integer-words, --decimals, --block-delete, --harmless-m, --start, "
            "--tool-change-keeps, --offset G54.1 P5, G55, --tool-length 1, T5D1, --tool-radius 1");
  EXPECT_EQ(stated.tool_tip_mm, Eigen::Vector3d(0, 0, -150.5));
  const RewriteOptions& options = stated.options;
  EXPECT_EQ(options.dialect, "haas");
  EXPECT_EQ(options.unit, ProgramUnit::kInch);
  EXPECT_EQ(options.integer_words, IntegerWords::kLeastIncrement);
  EXPECT_EQ(options.decimals_mm, 3);
  EXPECT_EQ(options.decimals_inch, 4);
  EXPECT_EQ(options.block_delete, BlockDelete::kSkipped);
  EXPECT_THAT(options.harmless_m, ElementsAre(47, 120, 121, 122));
  ASSERT_EQ(options.initial_position.size(), 1u);
  EXPECT_NEAR(options.initial_position[0].value, EIGEN_PI / 2, 1e-15);
  EXPECT_THAT(options.tool_change_keeps, ElementsAre("B", "C"));
  ASSERT_EQ(options.work_offsets.size(), 2u);
  EXPECT_EQ(options.work_offsets[0].code, "G54.1 P5");
  EXPECT_EQ(options.work_offsets[0].offsets[0].value, -490);
  EXPECT_NEAR(options.work_offsets[0].offsets[1].value, EIGEN_PI / 2, 1e-15);
  ASSERT_EQ(options.tool_lengths.size(), 2u);
  EXPECT_EQ(options.tool_lengths[1].number, NumberOfEdge(5, 1));
  EXPECT_EQ(options.tool_radii[0].radius_mm, 5);
  EXPECT_EQ(*TakeProfile(Profile(), Machine(), &stated), "") << "nothing is open any more";
}

TEST(StatedOptions, WhatIsStatedGoesBeforeTheProfile) {
  machine::ProgramProfile words;
  words.tool_tip = "1 2 3";
  words.dialect = "fanuc";
  words.unit = "mm";
  words.decimals = "4";
  words.integer_words = "units";
  words.harmless_m = "9";
  words.offsets = {"G55 Y=7"};
  words.tool_lengths = {"H1=3"};
  StatedOptions stated = *ReadStated(words, StatedBy::kOptions, Machine());
  const auto taken = TakeProfile(Profile(), Machine(), &stated);
  ASSERT_TRUE(taken.ok()) << taken.status();
  EXPECT_EQ(*taken,
            "--block-delete, --start, --tool-change-keeps, --offset G54.1 P5, --tool-length T5D1, "
            "--tool-radius 1");
  EXPECT_EQ(stated.tool_tip_mm, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(stated.options.dialect, "fanuc");
  EXPECT_EQ(stated.options.unit, ProgramUnit::kMillimetre);
  EXPECT_EQ(stated.options.decimals_mm, 4);
  EXPECT_EQ(stated.options.integer_words, IntegerWords::kWholeUnits);
  EXPECT_THAT(stated.options.harmless_m, ElementsAre(9));
  EXPECT_EQ(stated.options.work_offsets[0].offsets[0].value, 7);
  EXPECT_EQ(stated.options.tool_lengths[0].length_mm, 3);
}

TEST(StatedOptions, AWholeToolTableLeavesNoToolsToTheProfile) {
  StatedOptions stated = Nothing();
  stated.open.tools = false;
  ASSERT_TRUE(TakeProfile(Profile(), Machine(), &stated).ok());
  EXPECT_TRUE(stated.options.tool_lengths.empty());
  EXPECT_TRUE(stated.options.tool_radii.empty());
}

TEST(StatedOptions, WhatDoesNotGoTogetherIsRefused) {
  const auto with = [](const auto& change) {
    machine::ProgramProfile words;
    change(words);
    StatedOptions stated = *ReadStated(words, StatedBy::kOptions, Machine());
    return std::string(TakeProfile(Profile(), Machine(), &stated).status().message());
  };
  EXPECT_THAT(with([](auto& words) { words.offsets = {"G54.1 P5 X=1"}; }),
              HasSubstr("--offset: 'G54.1 P5' does not state all that the machine's profile states of it (C)"));
  EXPECT_THAT(with([](auto& words) { words.decimals = "4"; }), HasSubstr("--decimals is stated"));
  EXPECT_THAT(with([](auto& words) { words.integer_words = "increments"; }), HasSubstr("--integer-words is stated"));
  machine::ProgramProfile words;
  words.integer_words = "increments";
  StatedOptions stated = *ReadStated(words, StatedBy::kOptions, Machine());
  EXPECT_THAT(std::string(TakeProfile({}, Machine(), &stated).status().message()), HasSubstr("needs --decimals"));
}

TEST(StatedOptions, ErrorsNameWhoSaidIt) {
  const auto error = [](StatedBy by, const auto& change) {
    machine::ProgramProfile words;
    change(words);
    return std::string(ReadStated(words, by, Machine()).status().message());
  };
  const StatedBy options = StatedBy::kOptions, profile = StatedBy::kProfile;
  EXPECT_THAT(error(options, [](auto& words) { words.tool_tip = "1 2"; }), HasSubstr("--tool-tip: '1 2', expected"));
  EXPECT_THAT(error(profile, [](auto& words) { words.tool_tip = "1 2"; }), HasSubstr("programs.tool_tip: '1 2'"));
  EXPECT_THAT(error(profile, [](auto& words) { words.unit = "feet"; }),
              HasSubstr("programs.unit: 'feet', expected one of inch, mm"));
  EXPECT_THAT(error(profile, [](auto& words) { words.decimals = "7"; }), HasSubstr("programs.decimals: '7'"));
  EXPECT_THAT(error(profile, [](auto& words) { words.harmless_m = "5-3"; }), HasSubstr("programs.harmless_m: '5-3'"));
  EXPECT_THAT(error(options, [](auto& words) { words.start = "W=1"; }), HasSubstr("--start: 'W=1', expected an axis"));
  EXPECT_THAT(error(profile, [](auto& words) { words.tool_change_keeps = "X"; }),
              HasSubstr("programs.tool_change_keeps: 'X', expected rotary axes"));
  EXPECT_THAT(error(options,
                    [](auto& words) {
                      words.offsets = {"G54 X=1", "g54 Y=2"};
                    }),
              HasSubstr("--offset: G54 stands twice"));
  EXPECT_THAT(error(profile, [](auto& words) { words.offsets = {"G54=1 2"}; }),
              HasSubstr("programs.offsets: 'G54=1 2'"));
  EXPECT_THAT(error(profile, [](auto& words) { words.tool_lengths = {"H1"}; }),
              HasSubstr("programs.tool_lengths: 'H1', expected a number"));
  EXPECT_THAT(error(profile, [](auto& words) { words.tool_radii = {"D1=-2"}; }),
              HasSubstr("programs.tool_radii: 'D1=-2'"));
}

}  // namespace
}  // namespace axiscal::nc
