#include "server/access/crowd.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace axiscal::access {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Crowd, TheFirstOfTheHostThatHasMostGiveWay) {
  EXPECT_THAT(BeyondTheMost({}, 2), IsEmpty());
  EXPECT_THAT(BeyondTheMost({"a", "b"}, 2), IsEmpty());
  EXPECT_THAT(BeyondTheMost({"a", "a", "a"}, 1), ElementsAre(0, 1));
  // A cell that came first keeps its place whatever another host does.
  EXPECT_THAT(BeyondTheMost({"cell", "b", "b", "b", "b"}, 2), ElementsAre(1, 2, 3));
  EXPECT_THAT(BeyondTheMost({"a", "b", "b", "a", "b"}, 3), ElementsAre(1, 2));
  EXPECT_THAT(BeyondTheMost({"a", "b"}, 0), testing::UnorderedElementsAre(0, 1));
}

}  // namespace
}  // namespace axiscal::access
