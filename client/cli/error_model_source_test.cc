#include "client/cli/error_model_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace axiscal::cli {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(ErrorModelSource, DeclaredErrorsAreSplitAtCommasOutsideOfBraces) {
  EXPECT_THAT(SplitErrors({}), IsEmpty());
  EXPECT_THAT(SplitErrors({"EZ0T,EX0T"}), ElementsAre("EZ0T", "EX0T"));
  EXPECT_THAT(SplitErrors({"EX0C", R"({"symbol": "EBB", "knots": [1, 2]},EA0C)"}),
              ElementsAre("EX0C", R"({"symbol": "EBB", "knots": [1, 2]})", "EA0C"));
}

}  // namespace
}  // namespace axiscal::cli
