#include "core/loop/clustered_readings.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/units.h"
#include "core/decide/close_loop.h"
#include "core/identify/testing/scenario.h"

namespace axiscal::loop {
namespace {

using identify::testing::Errors;
using identify::testing::Measure;

const machine::Machine kMachine = machine::testing::MultiTasking();
constexpr char kTruth[] = R"({"EA0B": 82.1, "EC0B": -61.0, "EX0C": -22.2, "EY0C": 15.3, "EX0T": -2.0, "EZ0T": 29.9})";

Report Close(const std::vector<session::Session>& sessions) {
  return decide::CloseLoop(kMachine, *identify::BindSessions(kMachine, sessions), {}).value();
}

// A burr on the rotary axis throws one reading of each pass over it, far beyond the noise and never two at once: each
// looks like a chip.
TEST(ClusteredReadings, ABurrThatEveryPassMeetsIsStructure) {
  auto sessions = Measure(kMachine, Errors(kMachine, kTruth), {});
  int thrown = 0;
  for (session::Session& session : sessions) {
    const session::Column* const b_deg = session::FindColumn(session, "B_deg");
    std::vector<double>& length_mm = session.columns.back().values;
    bool was_near = false;
    for (size_t k = 0; k < length_mm.size(); ++k) {
      const bool is_near = b_deg != nullptr && std::abs(b_deg->values[k] - 41.0 - thrown % 3) < 0.6;
      if (is_near && !was_near) length_mm[k] += ++thrown % 2 == 0 ? 0.012 : -0.015;
      was_near = is_near;
    }
  }
  ASSERT_GE(thrown, 4);  // two patterns turn B, there and back
  const Report report = Close(sessions);
  EXPECT_EQ(report.verdict, Verdict::kUnexplained);
  ASSERT_EQ(report.unexplained.size(), 1u);
  const Unexplained& burr = report.unexplained[0];
  EXPECT_EQ(burr.kind, Unexplained::kBadReadings);
  // A linear axis goes with B in these patterns: which of them it is, the readings do not say.
  if (burr.variable == "B") {
    EXPECT_NEAR(burr.from * base::kDegPerRad, 41.0, 2.0);
    EXPECT_NEAR(burr.to * base::kDegPerRad, 43.0, 2.0);
  }
  EXPECT_GT(burr.rms_mm, 0.010);
  EXPECT_TRUE(report.effects.empty());
  EXPECT_EQ(report.fitted.outliers.size(), static_cast<size_t>(thrown));
}

// As many bad readings, and more, anywhere: chips.
TEST(ClusteredReadings, ScatteredBadReadingsAreChips) {
  for (const uint64_t seed : {1, 2, 3, 4, 5}) {
    synthetic::NoiseOptions noise;
    noise.seed = seed;
    noise.bad_share = 0.01;
    const Report report = Close(Measure(kMachine, Errors(kMachine, kTruth), noise));
    EXPECT_GT(report.fitted.outliers.size(), 10u);
    EXPECT_TRUE(report.unexplained.empty()) << "seed " << seed;
  }
}

}  // namespace
}  // namespace axiscal::loop
