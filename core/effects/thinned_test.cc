#include "core/effects/thinned.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>

#include "core/effects/catalogue.h"
#include "core/identify/identify.h"
#include "core/identify/testing/scenario.h"
#include "core/objective/scorer.h"

namespace axiscal::effects {
namespace {

const machine::Machine kSwept = machine::testing::MultiTasking();
constexpr char kSweptErrors[] =
    R"({"EX0C": 20, "terms": [{"symbol": "EXX", "shape": "backlash", "amplitude": 0.6},
                              {"symbol": "EXC", "shape": "harmonic", "order": 3, "amplitude": 0.4, "phase_deg": 30}]})";

// `noise` of every session is the one that is given.
identify::Fit SweptFit(double step_deg, const std::vector<identify::testing::Measured>& patterns,
                       std::pair<double, double> memory) {
  ballbar::PatternOptions options;
  options.step_deg = step_deg;
  const machine::ErrorModel truth = identify::testing::Errors(kSwept, kSweptErrors);
  identify::Problem problem =
      identify::MakeProblem(
          kSwept, *identify::BindSessions(
                      kSwept, identify::testing::Measure(kSwept, truth, synthetic::NoiseOptions(), patterns, options)))
          .value();
  for (identify::Noise& noise : problem.noise) noise = {noise.sigma_mm, memory.first, memory.second};
  identify::Options fit_options;
  fit_options.set_outliers_aside = false;
  return identify::FitProblem(std::move(problem), machine::DeclaredModel(kSwept), fit_options).value();
}

Linearised RowsOf(const identify::Fit& fit) {
  return Linearise(fit.problem, fit.point, static_cast<int>(machine::DeclaredModel(kSwept).terms.size()));
}

// The squares that each flat effect alone explains, by name.
std::map<std::string, double> ExplainedBy(const Linearised& linearised) {
  Catalogue catalogue = MakeCatalogue(linearised, machine::DeclaredModel(kSwept), {}, {});
  objective::Scorer scorer(linearised.rows, std::move(catalogue.sources), objective::Policy());
  for (int g = 0; g < scorer.group_count(); ++g) {  // scans, which take long
    const int family = scorer.group(g).family;
    if (family == static_cast<int>(loop::Family::kFineHarmonic) || family == static_cast<int>(loop::Family::kPitch))
      scorer.Exclude(g);
  }
  const objective::Score none = scorer.ScoreOf({}, 1.0);
  std::map<std::string, double> explained;
  for (const objective::Move& move : scorer.AdditionsWithin({}, 1.0, INFINITY)) {
    const int g = move.member.group;
    const Effect& effect = catalogue.effects[g];
    if (effect.bad_row >= 0 || !loop::IsTerm(effect.candidate.family) || scorer.group(g).IsBlock()) continue;
    const double gain = move.objective - none.objective - scorer.PriceOf(g, 1.0);
    explained[machine::NameOf(kSwept, effect.candidate.term)] =
        -none.squares * std::expm1(gain / scorer.degrees_of_freedom());
  }
  return explained;
}

// What sums of neighbours cannot hold of an effect is small beside it, and of those that are not there noise shows more
// or less (chi-square units). Where noise remembers, the jumps of a backlash that no state holds yet pass for fine
// harmonics in the sums: what explains much is compared there.
TEST(Thinned, RowsSayOfEveryNameWhatTheReadingsSay) {
  constexpr double kStepDeg = 0.2, kMuch = 100.0;
  for (const auto& memory : {std::pair(0.0, 0.0), std::pair(0.8, 0.4)}) {
    const identify::Fit fit = SweptFit(kStepDeg, identify::testing::FivePatterns(), memory);
    const Linearised readings = RowsOf(fit);
    const std::optional<Linearised> rows = Thinned(readings, {});
    ASSERT_TRUE(rows);
    EXPECT_LT(rows->count(), readings.count() / 2);
    EXPECT_GE(rows->count(), 2000);
    const std::map<std::string, double> all = ExplainedBy(readings), thin = ExplainedBy(*rows);
    EXPECT_GT(all.at("EXX:backlash"), 200.0);
    int compared = 0;
    for (const auto& [name, squares] : thin) {
      const auto its = all.find(name);
      if (its == all.end() || (memory.first > 0.0 && its->second < kMuch)) continue;
      ++compared;
      EXPECT_NEAR(squares, its->second, 10.0 + 0.05 * its->second) << name;
    }
    EXPECT_GT(compared, 50);
  }
}

TEST(Thinned, NeighboursThatAreSparedNeitherTurnNorReachFar) {
  const identify::Fit fit = SweptFit(0.1, identify::testing::FivePatterns(), {0.0, 0.0});
  const Linearised readings = RowsOf(fit);
  const std::optional<Linearised> rows = Thinned(readings, {});
  ASSERT_TRUE(rows);
  for (int at = 1; at < rows->count(); ++at) {
    if (rows->run[at] != rows->run[at - 1]) continue;
    const shapes::State here = rows->StateAt(at), before = rows->StateAt(at - 1);
    for (size_t axis = 0; axis < here.axes.size(); ++axis)
      EXPECT_LE(std::abs(here.axes[axis].position - before.axes[axis].position), 2.0 * rows->step[axis] + 1e-9);
  }
}

TEST(Thinned, FineHarmonicsAndAccelerationsAreNotTold) {
  const identify::Fit fit = SweptFit(0.1, identify::testing::FivePatterns(), {0.0, 0.0});
  const std::optional<Linearised> rows = Thinned(RowsOf(fit), {});
  ASSERT_TRUE(rows);
  const int c = machine::FindAxis(kSwept, "C");
  EXPECT_TRUE(rows->Tells(shapes::Harmonic{c, 20.0}));
  EXPECT_FALSE(rows->Tells(shapes::Harmonic{c, 390.0}));
  EXPECT_TRUE(rows->Tells(shapes::Backlash{c}));
  EXPECT_FALSE(rows->Tells(shapes::Acceleration{c}));
  EXPECT_TRUE(RowsOf(fit).Tells(shapes::Acceleration{c}));
  EXPECT_TRUE(RowsOf(fit).Tells(shapes::Harmonic{c, 390.0}));
}

TEST(Thinned, SparseReadingsStayAsTheyAre) {
  EXPECT_FALSE(Thinned(RowsOf(SweptFit(2.0, identify::testing::FivePatterns(), {0.0, 0.0})), {}));
}

// A bad reading is in no row, nor is the one whose whitening remembers it.
TEST(Thinned, BadReadingsAreInNoRow) {
  identify::Fit fit = SweptFit(0.1, identify::testing::FivePatterns(), {0.6, 0.0});
  constexpr int kBad = 500;
  const std::optional<Linearised> sound = Thinned(RowsOf(fit), {{0, kBad}});
  fit.problem.runs[0].measured_mm(0, kBad) += 1.0;
  const std::optional<Linearised> bad = Thinned(RowsOf(fit), {{0, kBad}});
  ASSERT_TRUE(sound && bad);
  EXPECT_EQ(sound->rows.y, bad->rows.y);
  const std::optional<Linearised> kept = Thinned(RowsOf(fit), {});
  ASSERT_TRUE(kept);
  EXPECT_GT((kept->rows.y - Thinned(RowsOf(SweptFit(0.1, identify::testing::FivePatterns(), {0.6, 0.0})), {})->rows.y)
                .cwiseAbs()
                .maxCoeff(),
            100.0);
}

}  // namespace
}  // namespace axiscal::effects
