#include "core/base/utf8.h"

#include <gtest/gtest.h>

namespace axiscal::base {
namespace {

constexpr char kReplaced[] = "\xEF\xBF\xBD";

TEST(Utf8, WellFormedTextStays) {
  for (const std::string text : {"", "cell-7", "M\xC3\xBCller", "\xE5\xB7\xA5\xE4\xBD\x9C", "\xF0\x9F\x94\xA7"}) {
    EXPECT_TRUE(IsUtf8(text)) << text;
    EXPECT_EQ(ToUtf8(text), text);
  }
}

TEST(Utf8, WhatIsNoneIsReplacedByteByByte) {
  EXPECT_EQ(ToUtf8("a\xFF z"), std::string("a") + kReplaced + " z");
  EXPECT_EQ(ToUtf8("caf\xE9"), std::string("caf") + kReplaced);       // Latin-1
  EXPECT_EQ(ToUtf8("M\xC3"), std::string("M") + kReplaced);           // cut in the midst of a character
  EXPECT_EQ(ToUtf8("\xC0\x80"), std::string(kReplaced) + kReplaced);  // overlong
  EXPECT_FALSE(IsUtf8("\xED\xA0\x80"));                               // a surrogate
  EXPECT_FALSE(IsUtf8("\xF4\x90\x80\x80"));                           // beyond U+10FFFF
  EXPECT_TRUE(IsUtf8(ToUtf8(std::string("\xED\xA0\x80\xF4\x90\x80\x80\xFE"))));
}

}  // namespace
}  // namespace axiscal::base
