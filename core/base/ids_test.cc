#include "core/base/ids.h"

#include <gtest/gtest.h>

#include <type_traits>
#include <unordered_set>

namespace axiscal {
namespace {

TEST(Ids, AreDistinctTypesThatCompareAndHash) {
  static_assert(!std::is_convertible_v<SessionId, JobId>);
  static_assert(!std::is_convertible_v<std::string, MachineId>);
  EXPECT_LT(SessionId(1), SessionId(2));
  EXPECT_EQ(MachineId("mt"), MachineId("mt"));
  const std::unordered_set<JobId> jobs = {JobId(3), JobId(3), JobId(4)};
  EXPECT_EQ(jobs.size(), 2u);
}

}  // namespace
}  // namespace axiscal
