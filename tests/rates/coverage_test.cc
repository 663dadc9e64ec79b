// 95 % intervals hold the true value in 93 to 97 % of simulated machines: setup offsets, errors, effects and noise are
// drawn, seeds are fixed. The machines are drawn as described in simulated_case.h.
#include "tests/rates/coverage.h"

#include <gtest/gtest.h>

#include <cmath>

namespace axiscal::rates {
namespace {

constexpr double kLeast = 0.93, kMost = 0.97;

CoverageByKind Identified(Kind kind, int machines, int keep_every) {
  CoverageByKind coverage;
  int refused = 0;
  for (int seed = 1; seed <= machines; ++seed) refused += !AddIdentified(Draw(kind, seed), keep_every, &coverage);
  EXPECT_EQ(refused, 0);
  return coverage;
}

void ExpectHonest(const CoverageByKind& coverage, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    ASSERT_TRUE(coverage.contains(name)) << ToText(coverage);
    const double share = coverage.at(name).share();
    EXPECT_TRUE(share >= kLeast && share <= kMost) << name << "\n" << ToText(coverage);
  }
}

// About 5,800 intervals, 650 of them of an effect's amplitudes (its term known, not searched for).
TEST(Coverage, ErrorsAndEffectsOfFiveHundredMachines) {
  ExpectHonest(Identified(Kind::kOne, 500, 1),
               {"all", "length", "angle", "effect", "machine mt", "machine tt", "machine ht"});
}

TEST(Coverage, FewReadingsPerSession) {
  ExpectHonest(Identified(Kind::kNull, 500, 16), {"all", "length", "angle"});
  ExpectHonest(Identified(Kind::kNull, 500, 40), {"all"});
  // Three to five readings a session: what only the set-ups' priors show is freed but gets no number.
  const CoverageByKind fewest = Identified(Kind::kNull, 500, 80);
  ExpectHonest(fewest, {"all"});
  EXPECT_LT(fewest.at("all").squares, 1.3 * fewest.at("all").intervals) << ToText(fewest);
}

// Scatter above the stated sigma widens the intervals, scatter clearly below it narrows them.
TEST(Coverage, AMisstatedSigmaIsCorrectedEitherWay) {
  CoverageByKind louder, quieter;
  for (int seed = 1; seed <= 500; ++seed) {
    const SimulatedCase simulated = Draw(Kind::kMisstated, seed);
    ASSERT_TRUE(AddIdentified(simulated, 1, simulated.sigma_scale > 1.0 ? &louder : &quieter));
  }
  ExpectHonest(louder, {"all", "angle", "effect"});
  ExpectHonest(quieter, {"all", "angle", "effect"});
}

// Ball-bar readings that remember their neighbours (correlation 0.6), bad readings, a stated sigma off by up to two.
TEST(Coverage, CorrelatedNoiseAndBadReadings) {
  ExpectHonest(Identified(Kind::kDirty, 300, 1), {"all", "length", "angle", "effect"});
}

// The loop chose these effects by their size in the same readings, and an effect counts only where it was named in its
// own terms: its interval is conditional on the choice and knows nothing of it. What remains here (about fifty) is too
// few for the band above; three standard deviations of a binomial count are allowed.
TEST(Coverage, EffectsThatTheLoopNamed) {
  CoverageByKind coverage;
  for (int seed = 1; seed <= 60; ++seed) AddClosed(Draw(Kind::kOne, seed), &coverage);
  const Coverage& effects = coverage.at("effect");
  EXPECT_GE(effects.intervals, 40);
  EXPECT_GE(effects.share(), 0.95 - 3.0 * std::sqrt(0.95 * 0.05 / effects.intervals)) << ToText(coverage);
}

}  // namespace
}  // namespace axiscal::rates
