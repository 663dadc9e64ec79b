#include "core/loop/growth.h"

#include <gtest/gtest.h>

#include "core/identify/testing/scenario.h"
#include "core/loop/fitting.h"

namespace axiscal::loop {
namespace {

using ballbar::Pattern;

// Fitted beside effects that were dropped later, a spike may have become what its amplitude and length only make up.
TEST(Growth, ASpikeThatOutlastsTheTravelIsABacklash) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const machine::ErrorModel truth =
      identify::testing::Errors(machine, R"({"terms": [{"symbol": "EYY", "shape": "backlash", "amplitude": 0.5}]})");
  const auto runs = identify::BindSessions(machine, identify::testing::Measure(machine, truth, {},
                                                                               {{"CR", Pattern::kCR, 356.4},
                                                                                {"CA", Pattern::kCA, 356.4},
                                                                                {"CT", Pattern::kCT, 356.4},
                                                                                {"BY", Pattern::kBY, 356.4}}));
  ASSERT_TRUE(runs.ok()) << runs.status();
  const machine::ErrorTerm backlash = truth.terms[0];
  machine::ErrorTerm spike = backlash;
  constexpr double kLengthMm = 3000.0;
  spike.shape = shapes::Reversal{*shapes::VariableAxis(backlash.shape), kLengthMm};
  spike.amplitude = {0.5 * backlash.amplitude[0], 0.0};

  Way way;
  way.most_effects = 3;
  Attempt attempt{Extension(machine, *runs), way, {}, {}, false, {}};
  attempt.extension.effects.push_back({{Family::kReversal, spike}, 100.0, {}, {}});
  const Options options;
  const identify::Options identify_options;
  auto fit = FitExtension(machine, attempt.extension, identify_options);
  ASSERT_TRUE(fit.ok()) << fit.status();
  ASSERT_TRUE(Growth(machine, options, identify_options, &attempt).Extend(&*fit).ok());
  ASSERT_EQ(attempt.extension.effects.size(), 1u);
  EXPECT_EQ(attempt.extension.NameOf(0), "EYY:backlash");
}

}  // namespace
}  // namespace axiscal::loop
