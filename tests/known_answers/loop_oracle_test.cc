// Cases of another simulator (tests/data/loop): with the declared model, and with what went in declared by hand, the
// engine reaches the residual that a fit which knows the truth reaches, on the sessions fitted and on those kept back.
#include <gtest/gtest.h>

#include "core/base/units.h"
#include "core/identify/identify.h"
#include "tests/known_answers/loop_truth.h"
#include "tests/known_answers/published.h"

namespace axiscal::known_answers {
namespace {

using loop_truth::IsDirty;
using loop_truth::TermOf;
using nlohmann::json;

struct Numbers {
  identify::Result fit, check;
};

Numbers FitAndCheck(const session::Case& c, const machine::ErrorModel& model) {
  identify::Options options;
  options.model = model;
  const auto fit = identify::FitRuns(c.machine, identify::BindSessions(c.machine, c.fit).value(), options);
  EXPECT_TRUE(fit.ok()) << fit.status();
  const auto check = identify::CheckRuns(c.machine, identify::BindSessions(c.machine, c.check).value(),
                                         fit.value().result.model, options);
  EXPECT_TRUE(check.ok()) << check.status();
  return {fit.value().result, check.value().result};
}

class LoopOracle : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    case_ = loop_truth::ReadCase(GetParam());
    truth_ = loop_truth::ReadTruth(GetParam());
    model_ = machine::DeclaredModel(case_.machine);
  }
  double OracleUm(const std::string& key) const { return truth_["oracle"][key]; }
  // Adds the effects; false where one of them is not an error term.
  bool DeclareEffects() {
    for (const json& effect : truth_["effects"]) {
      const std::optional<machine::ErrorTerm> term = TermOf(effect, case_.machine);
      if (!term) return false;
      model_.terms.push_back(*term);
    }
    return true;
  }

  session::Case case_;
  json truth_;
  machine::ErrorModel model_;
};

TEST_P(LoopOracle, DeclaredModelFitsAsWellAsTheOracle) {
  const identify::Result fit = FitAndCheck(case_, model_).fit;
  const double oracle_um = OracleUm("fit_before_um");
  ExpectPublished(base::kUmPerMm * fit.fit.rms_mm, oracle_um, 0.01 * oracle_um,
                  absl::StrCat("independent simulator, ", GetParam(), ": rms of the declared model, um"));
}

TEST_P(LoopOracle, TrueEffectsDeclaredByHandFitAsWellAsTheOracle) {
  if (!DeclareEffects()) GTEST_SKIP() << "an effect that is no error term: " << truth_["effects"].dump();
  const Numbers numbers = FitAndCheck(case_, model_);
  const double fit_um = OracleUm("fit_after_um"), check_um = OracleUm("check_after_um");
  ExpectPublished(base::kUmPerMm * numbers.fit.fit.rms_mm, fit_um, 0.02 * fit_um,
                  absl::StrCat("independent simulator, ", GetParam(), ": rms with the true effects, um"));
  if (IsDirty(truth_)) return;
  EXPECT_NEAR(base::kUmPerMm * numbers.check.fit.rms_mm, check_um, 0.02 * check_um);
}

// Truth files hold um and urad, rad for phases.
TEST_P(LoopOracle, ErrorsAreTheTrueOnesWithinTheirUncertainty) {
  if (!DeclareEffects()) GTEST_SKIP() << "an effect that is no error term: " << truth_["effects"].dump();
  if (IsDirty(truth_)) GTEST_SKIP() << "readings are correlated, the stated sigma is wrong";
  constexpr double kSigmas = 4.0;
  const identify::Result fit = FitAndCheck(case_, model_).fit;
  for (const identify::Estimate& estimate : fit.estimates) {
    if (!truth_["base"].contains(estimate.name)) continue;
    const double true_value = truth_["base"][estimate.name].get<double>() * estimate.factor;
    EXPECT_LT(std::abs(estimate.value - true_value), kSigmas * estimate.sigma) << estimate.name;
  }
  size_t at = machine::DeclaredModel(case_.machine).terms.size();
  for (const json& effect : truth_["effects"]) {
    const double amplitude = effect["amp"], phase = effect.value("phase", 0.0);
    const bool is_harmonic = effect["shape"] == "harmonic";
    const double expected[] = {is_harmonic ? amplitude * std::cos(phase) : amplitude, amplitude * std::sin(phase)};
    for (int basis = 0; basis < (is_harmonic ? 2 : 1); ++basis, ++at) {
      const identify::Estimate& estimate = fit.estimates[at];
      EXPECT_TRUE(estimate.identifiable) << estimate.name;
      EXPECT_LT(std::abs(estimate.value - expected[basis] * estimate.factor), kSigmas * estimate.sigma)
          << estimate.name << ": " << estimate.value / estimate.factor << " against " << expected[basis];
    }
    for (const char* nonlinear : {"length", "tau_s"}) {
      if (at >= fit.estimates.size() || !effect.contains(nonlinear)) continue;
      const identify::Estimate& estimate = fit.estimates[at++];
      EXPECT_LT(std::abs(estimate.value - effect[nonlinear].get<double>()), kSigmas * estimate.sigma) << estimate.name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, LoopOracle, testing::ValuesIn(loop_truth::CaseNames()), loop_truth::NameOf);

}  // namespace
}  // namespace axiscal::known_answers
