#include "server/log.h"

#include <gtest/gtest.h>

namespace axiscal::server {
namespace {

TEST(Log, KeyValueQuotesWhatWouldBreakTheLine) {
  EXPECT_EQ(FormatFields(LogFormat::kKeyValue, "call", {{"code", "OK"}, {"text", "a b=\"c\"\n"}, {"none", ""}}),
            R"(event=call code=OK text="a b=\"c\"\n" none="")");
}

TEST(Log, JsonEscapesAndNeverBreaksOnBadUtf8) {
  EXPECT_EQ(FormatFields(LogFormat::kJson, "call", {{"text", "\"\n"}}), R"("event":"call","text":"\"\n")");
  EXPECT_NE(FormatFields(LogFormat::kJson, "call", {{"text", "\xff"}}).find("\xEF\xBF\xBD"), std::string::npos);
}

}  // namespace
}  // namespace axiscal::server
