#include "server/handlers/core.h"

#include <gtest/gtest.h>

namespace axiscal::handlers {
namespace {

TEST(TraceParent, HasFourGroupsOfHexadecimalDigits) {
  EXPECT_TRUE(IsTraceParent("00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01"));
  for (const char* other : {"", "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-0",
                            "00-4BF92F3577B34DA6A3CE929D0E0E4736-00f067aa0ba902b7-01",
                            "00-4bf92f3577b34da6a3ce929d0e0e473600-f067aa0ba902b7-01",
                            "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7\n01"})
    EXPECT_FALSE(IsTraceParent(other)) << other;
}

}  // namespace
}  // namespace axiscal::handlers
