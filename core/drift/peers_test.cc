#include "core/drift/peers.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"

namespace axiscal::drift {
namespace {

TEST(Peers, AKnownT) {
  // Peers 1 .. 9: mean 5, s^2 = 7.5. A value 10 away, known exactly: t = 10 / sqrt(7.5 * 10 / 9) = 3.4641, of 8 degrees
  // of freedom 0.00852 two-sided (tables of Student's t).
  const auto unlike = UnlikePeers(15.0, 0.0, {1, 2, 3, 4, 5, 6, 7, 8, 9});
  ASSERT_TRUE(unlike);
  EXPECT_DOUBLE_EQ(unlike->usual, 5.0);
  EXPECT_NEAR(unlike->spread, std::sqrt(7.5), 1e-12);
  EXPECT_DOUBLE_EQ(unlike->away, 10.0);
  EXPECT_NEAR(unlike->probability, 0.0085, 0.0004);
  // The same to the other side; and its own uncertainty makes it less sure.
  EXPECT_NEAR(UnlikePeers(-5.0, 0.0, {1, 2, 3, 4, 5, 6, 7, 8, 9})->probability, unlike->probability, 1e-15);
  EXPECT_GT(UnlikePeers(15.0, 3.0, {1, 2, 3, 4, 5, 6, 7, 8, 9})->probability, 2 * unlike->probability);
}

TEST(Peers, NothingIsSaidOfFewOrOfOneValue) {
  EXPECT_FALSE(UnlikePeers(15.0, 1.0, {1, 2, 3, 4}));
  EXPECT_FALSE(UnlikePeers(15.0, 1.0, {2, 2, 2, 2, 2, 2}));
}

// Machines that are like their peers: as many false alarms as the probability says, in groups of any size.
TEST(Peers, AsOftenWrongAsItSays) {
  base::Random random(221);
  for (const int count : {5, 8, 30}) {
    constexpr int kMachines = 20000;
    int told = 0;
    for (int i = 0; i < kMachines; ++i) {
      std::vector<double> peers;
      for (int k = 0; k < count; ++k) peers.push_back(40.0 + 12.0 * random.Normal());
      told += UnlikePeers(40.0 + 12.0 * random.Normal(), 0.0, peers)->probability < 0.01 ? 1 : 0;
    }
    // 200 +- 14 by chance; with four degrees of freedom the distribution function is off by some.
    EXPECT_NEAR(told, 200, 60) << count;
  }
}

}  // namespace
}  // namespace axiscal::drift
