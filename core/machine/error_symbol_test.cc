#include "core/machine/error_symbol.h"

#include <gtest/gtest.h>

namespace axiscal::machine {
namespace {

TEST(ErrorSymbol, ConstantErrorsAreReadInEveryFormAndWrittenInOne) {
  for (const char* text : {"EX0C", "X0C", "XOC", "EXOC"}) {
    const auto symbol = ParseErrorSymbol(text);
    ASSERT_TRUE(symbol.ok()) << text;
    EXPECT_EQ(ToString(*symbol), "EX0C");
    EXPECT_TRUE(symbol->is_constant);
    EXPECT_EQ(symbol->component, Component::kX);
    EXPECT_EQ(symbol->axis, "C");
  }
  EXPECT_EQ(ToString(*ParseErrorSymbol("EA0J12")), "EA0J12");
  EXPECT_EQ(ToString(*ParseErrorSymbol("EZ0T")), "EZ0T");
}

TEST(ErrorSymbol, ComponentFunctionsKeepTheirAxis) {
  const auto symbol = ParseErrorSymbol("EYX");
  ASSERT_TRUE(symbol.ok());
  EXPECT_FALSE(symbol->is_constant);
  EXPECT_EQ(symbol->component, Component::kY);
  EXPECT_EQ(symbol->axis, "X");
  EXPECT_EQ(ToString(*ParseErrorSymbol("EXJ1")), "EXJ1");
  EXPECT_TRUE(IsAngle(ParseErrorSymbol("EBB")->component));
}

TEST(ErrorSymbol, AnythingElseIsRefusedWithWhatWasExpected) {
  for (const char* text : {"", "E", "EX", "EX0", "EQ0C", "YX", "EX0c", "EX0C ", "ex0c", "EX00C", "EX0C1x", "0"}) {
    const auto symbol = ParseErrorSymbol(text);
    EXPECT_EQ(symbol.status().code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_NE(std::string(symbol.status().message()).find("expected E, a component"), std::string::npos);
  }
}

}  // namespace
}  // namespace axiscal::machine
