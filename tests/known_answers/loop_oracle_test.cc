// Cases of another simulator (tests/data/loop): with the declared model, and with what went in declared by hand, the
// engine reaches the residual that a fit which knows the truth reaches, on the sessions fitted and on those kept back.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "core/base/units.h"
#include "core/identify/identify.h"
#include "core/session/case.h"

namespace axiscal::known_answers {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string Folder(const std::string& name) { return AXISCAL_SOURCE_DIR "/tests/data/loop/" + name; }

std::vector<std::string> CaseNames() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(Folder(""))) {
    if (entry.is_directory()) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

// Bad readings (one in a hundred), correlated noise and a wrong stated sigma: 012 and later. Bad readings stay in the
// oracle's figures; how far a fit leans towards them is its own choice.
bool IsDirty(const json& truth) { return truth["category"] == "hard"; }

// The shape of an effect of a truth file, with start values of its own for what is not linear; nothing for `bump` and
// `step`, which are no shapes of error terms.
std::optional<shapes::Shape> ShapeOf(const json& effect, const machine::Machine& machine) {
  const std::string shape = effect["shape"];
  const int axis = machine::FindAxis(machine, effect.value("var", ""));
  const bool is_rotary = axis >= 0 && machine.axes[axis].kind == machine::AxisKind::kRotary;
  if (shape == "constant") return shapes::Constant{};
  if (shape == "linear") {
    return shapes::Linear{axis, is_rotary ? shapes::Linear::kReferenceRad : shapes::Linear::kReferenceMm};
  }
  if (shape == "quad") {
    return shapes::Quadratic{axis, is_rotary ? shapes::Quadratic::kReferenceRad : shapes::Quadratic::kReferenceMm};
  }
  if (shape == "harmonic") return shapes::Harmonic{axis, effect["n"].get<double>()};
  if (shape == "backlash") return shapes::Backlash{axis};
  if (shape == "reversal") return shapes::Reversal{axis};
  if (shape == "drift") return shapes::Drift{};
  if (shape == "drift-exp") return shapes::DriftExp{};
  if (shape == "thermal") return shapes::Thermal{};
  return std::nullopt;
}

std::optional<machine::ErrorTerm> TermOf(const json& effect, const machine::Machine& machine) {
  const std::optional<shapes::Shape> shape = ShapeOf(effect, machine);
  const int joint = machine::FindJoint(machine, effect.value("axis", ""));
  const size_t component = std::string("XYZABC").find(effect.value("comp", "?"));
  if (!shape || joint < 0 || component == std::string::npos) return std::nullopt;
  return machine::ErrorTerm{joint, static_cast<machine::Component>(component), *shape, {}};
}

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
    case_ = session::ReadCase(Folder(GetParam())).value();
    truth_ = json::parse(std::ifstream(Folder(GetParam()) + "/truth.json"));
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
  RecordProperty("fit_before_um", std::to_string(base::kUmPerMm * fit.fit.rms_mm));
  EXPECT_NEAR(base::kUmPerMm * fit.fit.rms_mm, oracle_um, 0.01 * oracle_um);
}

TEST_P(LoopOracle, TrueEffectsDeclaredByHandFitAsWellAsTheOracle) {
  if (!DeclareEffects()) GTEST_SKIP() << "an effect that is no error term: " << truth_["effects"].dump();
  const Numbers numbers = FitAndCheck(case_, model_);
  const double fit_um = OracleUm("fit_after_um"), check_um = OracleUm("check_after_um");
  EXPECT_NEAR(base::kUmPerMm * numbers.fit.fit.rms_mm, fit_um, 0.02 * fit_um);
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

INSTANTIATE_TEST_SUITE_P(Cases, LoopOracle, testing::ValuesIn(CaseNames()), [](const auto& param) {
  std::string name = param.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

}  // namespace
}  // namespace axiscal::known_answers
