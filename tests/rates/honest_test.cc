// Numbers that identification gives from poor sessions hold what they state; where it cannot tell, it says so.
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "core/identify/identify.h"
#include "tests/rates/poor_session.h"

namespace axiscal::rates {
namespace {

struct Tally {
  int sessions = 0, refused = 0, numbers = 0, held = 0, wrong = 0, loud = 0;
  std::string text;
};

Tally IdentifyPoorSessions(const std::string& instrument, int count) {
  Tally tally;
  for (int seed = 1; seed <= count; ++seed) {
    const PoorSession poor = DrawPoorSession(instrument, seed);
    identify::Options options;
    options.model = poor.truth;
    for (machine::ErrorTerm& term : options.model->terms) term.amplitude.fill(0.0);
    const auto result = identify::Identify(poor.machine, poor.sessions, options);
    ++tally.sessions;
    if (!result.ok()) {
      ++tally.refused;
      continue;
    }
    for (size_t i = 0; i < result->estimates.size(); ++i) {
      const identify::Estimate& estimate = result->estimates[i];
      if (!estimate.identifiable) continue;
      const double off = std::abs(estimate.value - poor.truth.terms[i].amplitude[0]) / estimate.sigma;
      ++tally.numbers;
      tally.held += off <= result->coverage_factor;
      if (off <= 5.0 * result->coverage_factor / 1.96) continue;
      ++tally.wrong;
      absl::StrAppend(&tally.text, instrument, " ", seed, ": ", estimate.name, " ", off, " sigma off\n");
    }
    // All that acts was asked for: whatever is left over was held or not found.
    if (result->fit.chi2_per_dof > 4.0 || result->fit.rms_mm > 5.0 * poor.sessions.size() * 5e-3) {
      tally.loud += !result->warnings.empty();
      if (result->warnings.empty()) absl::StrAppend(&tally.text, instrument, " ", seed, ": misses in silence\n");
    }
  }
  absl::StrAppend(&tally.text, instrument, ": ", tally.sessions, " cases, ", tally.refused, " refused, ", tally.loud,
                  " said to miss, ", tally.numbers, " numbers, ", 100.0 * tally.held / tally.numbers, " % hold\n");
  return tally;
}

class Honest : public ::testing::TestWithParam<const char*> {};

TEST_P(Honest, NoNumberIsWrongInSilence) {
  const Tally tally = IdentifyPoorSessions(GetParam(), 400);
  EXPECT_EQ(tally.wrong, 0) << tally.text;
  EXPECT_LE(tally.refused, tally.sessions / 20) << tally.text;
  EXPECT_LE(tally.loud, tally.sessions / 100) << tally.text;
  EXPECT_GE(tally.numbers, 100) << tally.text;
  EXPECT_GE(tally.held, 0.93 * tally.numbers) << tally.text;
  EXPECT_EQ(tally.text.find("silence"), std::string::npos) << tally.text;
  std::cout << tally.text;
}

INSTANTIATE_TEST_SUITE_P(Instruments, Honest, ::testing::Values("ballbar", "rtest", "touch", "tracker"),
                         [](const auto& one) { return std::string(one.param); });

}  // namespace
}  // namespace axiscal::rates
