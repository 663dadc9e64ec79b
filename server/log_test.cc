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

TEST(Log, LevelsHaveNames) {
  for (const auto& [name, level] : records::kLogLevels) {
    EXPECT_EQ(records::LogLevelNamed(name), level);
    EXPECT_EQ(records::NameOf(level), name);
  }
  EXPECT_EQ(records::LogLevelNamed("loud"), std::nullopt);
}

}  // namespace
}  // namespace axiscal::server
