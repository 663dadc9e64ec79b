// Numbers that identification gives from poor sessions hold what they state; where it cannot tell, it says so.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "core/identify/identify.h"
#include "tests/rates/poor_session.h"

namespace axiscal::rates {
namespace {

struct Tally {
  int sessions = 0, refused = 0, numbers = 0, held = 0, wrong = 0, loud = 0, absurd = 0;
  std::string text;
};

// No error of the simulated machines comes near (um, urad).
constexpr double kAbsurd = 1000.0;

bool IsNamed(const identify::Result& result, const std::string& name) {
  return std::any_of(result.warnings.begin(), result.warnings.end(), [&](const reports::WarningFacts& facts) {
    const auto* const warning = std::get_if<reports::NoNumber>(&facts);
    return warning != nullptr && std::any_of(warning->errors.begin(), warning->errors.end(),
                                             [&](const reports::NoNumber::Size& one) { return one.error == name; });
  });
}

// Of a combination that is known well the carrier may be large: it stands for the held ones too.
bool IsDetermined(const identify::Result& result, const identify::Estimate& estimate) {
  constexpr double kKnown = 100.0;
  return std::any_of(result.determined.begin(), result.determined.end(), [&](const identify::Combination& one) {
    return one.name.rfind(estimate.name + " ", 0) == 0 && one.sigma < kKnown * one.factor;
  });
}

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
      if (!estimate.identifiable) {
        const double size = std::abs(result->model.terms[i].amplitude[0]) / estimate.factor;
        if (size < kAbsurd || IsDetermined(*result, estimate)) continue;
        ++tally.absurd;
        if (!IsNamed(*result, estimate.name)) {
          absl::StrAppend(&tally.text, instrument, " ", seed, ": ", estimate.name, " at ", size, " in silence\n");
        }
        continue;
      }
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
                  " said to miss, ", tally.absurd, " absurd values without number, ", tally.numbers, " numbers, ",
                  100.0 * tally.held / tally.numbers, " % hold\n");
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
