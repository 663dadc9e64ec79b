#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/effects/catalogue.h"
#include "core/effects/harmonic_scan.h"
#include "core/effects/instrumental.h"
#include "core/effects/shaped.h"
#include "core/identify/errors_of_run.h"
#include "core/identify/identify.h"
#include "core/identify/reduction.h"
#include "core/identify/testing/scenario.h"
#include "core/objective/scorer.h"

namespace axiscal::effects {
namespace {

using identify::testing::Errors;
using identify::testing::Measure;

const machine::Machine kMachine = machine::testing::MultiTasking();
constexpr char kWithBacklash[] = R"({"EX0C": 20, "terms": [{"symbol": "EXX", "shape": "backlash", "amplitude": 0.6}]})";

std::vector<instruments::MeasuringRun> Runs() {
  synthetic::NoiseOptions noise;
  ballbar::PatternOptions options;
  options.step_deg = 2.0;
  const machine::ErrorModel truth = Errors(kMachine, kWithBacklash);
  return *identify::BindSessions(kMachine, Measure(kMachine, truth, noise, identify::testing::FivePatterns(), options));
}

machine::ErrorModel Declared() { return machine::DeclaredModel(kMachine); }

loop::Candidate Backlash() {
  const int x = machine::FindAxis(kMachine, "X");
  return {loop::Family::kBacklash, {x, machine::Component::kX, shapes::Backlash{x}, {}}, -1, 0};
}

// `noise` of every run where it is given.
identify::Fit FitOf(std::vector<instruments::MeasuringRun> runs, const machine::ErrorModel& model,
                    std::optional<std::pair<double, double>> memory = {}) {
  identify::Options options;
  options.set_outliers_aside = false;
  identify::Problem problem = identify::MakeProblem(kMachine, std::move(runs)).value();
  for (identify::Noise& noise : problem.noise)
    if (memory) noise = {noise.sigma_mm, memory->first, memory->second};
  return identify::FitProblem(std::move(problem), model, options).value();
}

double Squares(const identify::Fit& fit) {
  return identify::WhitenedSquares(fit.problem, fit.residuals_mm) + identify::PriorSquares(fit.problem, fit.point);
}

// A catalogue with its scorer.
struct Scored {
  Linearised linearised;
  Catalogue catalogue;
  std::unique_ptr<objective::Scorer> scorer;

  Scored(const identify::Fit& fit, const std::vector<loop::Candidate>& known)
      : linearised(Linearise(fit.problem, fit.point, static_cast<int>(Declared().terms.size()))),
        catalogue(MakeCatalogue(linearised, Declared(), known, {})),
        scorer(
            std::make_unique<objective::Scorer>(linearised.rows, std::move(catalogue.sources), objective::Policy())) {}

  int Find(const std::string& name) const {
    for (size_t g = 0; g < catalogue.effects.size(); ++g) {
      const Effect& effect = catalogue.effects[g];
      if (effect.bad_row < 0 && loop::IsTerm(effect.candidate.family) &&
          machine::NameOf(kMachine, effect.candidate.term) == name)
        return static_cast<int>(g);
    }
    return -1;
  }
};

// The squares that a state leaves are those of the full fit with its effects, in white noise and in noise that
// remembers.
TEST(Effects, WhatAStateLeavesIsWhatTheFullFitWithItLeaves) {
  const std::vector<std::optional<std::pair<double, double>>> memories = {std::nullopt, {{0.5, 0.0}}, {{0.8, 0.5}}};
  for (const auto& memory : memories) {
    machine::ErrorModel extended = Declared();
    extended.terms.push_back(Backlash().term);
    const identify::Fit before = FitOf(Runs(), Declared(), memory), after = FitOf(Runs(), extended, memory);
    const Scored scored(before, {});
    ASSERT_EQ(static_cast<int>(scored.catalogue.effects.size()), scored.scorer->group_count());
    const int group = scored.Find("EXX:backlash");
    ASSERT_GE(group, 0);
    const double without = scored.scorer->ScoreOf({}, 1.0).squares;
    const double with = scored.scorer->ScoreOf({{group, 0.0}}, 1.0).squares;
    EXPECT_GT(without - with, 20.0);
    EXPECT_NEAR(without, Squares(before), 1e-6 * without);
    EXPECT_NEAR(without - with, Squares(before) - Squares(after), 2e-3 * (without - with));  // second order of 1e-4
  }
}

// Where an effect or a slip is in the fitted model, the empty state is that without it, and the state with it the fit.
TEST(Effects, EffectsAndSlipsOfTheFitAreTakenOutOfItAgain) {
  machine::ErrorModel extended = Declared();
  extended.terms.push_back(Backlash().term);
  std::vector<instruments::MeasuringRun> runs = Runs(), slipped = runs;
  constexpr int kMoment = 70;
  loop::Candidate slip;
  slip.family = loop::Family::kStep;
  slip.run = 1;
  slip.first_reading = kMoment;
  for (std::vector<instruments::MeasuringRun>* some : {&runs, &slipped}) {
    for (int k = kMoment; k < (*some)[1].reading_count(); ++k) (*some)[1].measured_mm(0, k) += 2e-3;
  }
  instruments::AddSlip({slip.carrier, kMoment}, &slipped[1]);
  const identify::Fit plain = FitOf(runs, Declared()), fit = FitOf(slipped, extended);
  loop::Candidate backlash = Backlash();
  backlash.term = fit.point.model.terms.back();
  const Scored scored(fit, {backlash, slip});
  const objective::Score none = scored.scorer->ScoreOf({}, 1.0);
  const objective::Score all =
      scored.scorer->ScoreOf({{scored.catalogue.known[0], 0.0}, {scored.catalogue.known[1], 0.0}}, 1.0);
  EXPECT_NEAR(none.squares, Squares(plain), 1e-3 * Squares(plain));
  // The objective holds declared errors by a prior as wide as errors get.
  EXPECT_NEAR(all.squares, Squares(fit), 1e-5 * Squares(fit));
  EXPECT_NEAR(all.amplitude[0][0], backlash.term.amplitude[0], 1e-6);
  // No second group is the same.
  const auto named =
      std::count_if(scored.catalogue.effects.begin(), scored.catalogue.effects.end(), [](const Effect& e) {
        return e.bad_row < 0 && e.candidate.family == loop::Family::kBacklash &&
               loop::IsSameEffect(e.candidate.term, Backlash().term);
      });
  EXPECT_EQ(named, 1);
}

// Products by matrices of shapes and sensitivities, and frequencies by recurrence, are those of the columns written
// out.
TEST(Effects, ShapedColumnsAreSensitivityTimesShape) {
  const identify::Fit fit = FitOf(Runs(), Declared(), {{0.6, 0.2}});
  const Linearised linearised = Linearise(fit.problem, fit.point, static_cast<int>(Declared().terms.size()));
  const int c = machine::FindAxis(kMachine, "C");
  std::vector<ShapedItem> items;
  for (const int order : {1, 2, 3, 4, 200, 201, 202}) {
    for (const int component : {0, 2})
      items.push_back({shapes::Harmonic{c, static_cast<double>(order)}, machine::kComponents * c + component, {}});
  }
  items.push_back({shapes::Backlash{c}, machine::kComponents * c, {}});
  const shapes::Span turn{.is_turn = true}, some_span{-1.0, 2.0};
  for (const int functions : {24, 12, 6}) {  // the coarser ones are beginnings of the finer one
    for (const int component : functions == 12 ? std::vector{2, 3} : std::vector{0, 2})
      items.push_back({shapes::Curve{c, turn, functions}, machine::kComponents * c + component, {}});
  }
  for (const int functions : {12, 6})
    items.push_back({shapes::BacklashCurve{{c, some_span, functions}}, machine::kComponents * c, {}});
  items.push_back({shapes::Curve{c, some_span, 6}, machine::kComponents * c, {}});
  const Shaped source(linearised, items);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const Eigen::MatrixXd u = Eigen::MatrixXd::NullaryExpr(linearised.count(), 2, [&] { return normal(random); });
  const objective::Stretch& second = linearised.rows.stretches[1];
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(source.column_count(), 2), some = products;
  source.AddProducts(0, u, products);
  source.AddProducts(second.begin, u.middleRows(second.begin, second.end - second.begin), some);
  const std::vector<Eigen::MatrixXd> grams = source.Grams(linearised.rows.whitening);
  Eigen::Index at = 0;
  for (size_t i = 0; i < items.size(); ++i) {
    const int width = shapes::BasisCount(items[i].shape);
    Eigen::MatrixXd expected(linearised.count(), width);
    for (int row = 0; row < linearised.count(); ++row) {
      double basis[shapes::kMaxBasisCount];
      shapes::Basis(items[i].shape, linearised.StateAt(row), basis);
      for (int b = 0; b < width; ++b) expected(row, b) = basis[b] * linearised.sensitivity(row, items[i].sensitivity);
    }
    constexpr double kTolerance = 1e-9;  // recurrences of hundreds of turns
    EXPECT_LT((source.Columns(static_cast<int>(i)) - expected).cwiseAbs().maxCoeff(), kTolerance);
    EXPECT_LT((products.middleRows(at, width) - expected.transpose() * u).cwiseAbs().maxCoeff(), 1e3 * kTolerance);
    const auto rows = expected.middleRows(second.begin, second.end - second.begin);
    EXPECT_LT(
        (some.middleRows(at, width) - rows.transpose() * u.middleRows(second.begin, rows.rows())).cwiseAbs().maxCoeff(),
        1e3 * kTolerance);
    linearised.rows.whitening.Apply(0, expected);
    const Eigen::MatrixXd gram = expected.transpose() * expected;
    EXPECT_LT((grams[i] - gram).cwiseAbs().maxCoeff(), kTolerance * (1.0 + gram.maxCoeff()));
    at += width;
  }
}

// Trigonometric sums give the products and Gram matrices of the columns, without one frequency among others, in white
// noise, in noise that remembers, and in noise with an echo.
TEST(Effects, ScansByTrigonometricSumsAreTheirColumns) {
  const std::vector<std::optional<std::pair<double, double>>> memories = {std::nullopt, {{0.6, 0.0}}, {{0.6, 0.2}}};
  for (const auto& memory : memories) {
    const identify::Fit fit = FitOf(Runs(), Declared(), memory);
    const Linearised linearised = Linearise(fit.problem, fit.point, static_cast<int>(Declared().terms.size()));
    const int x = machine::FindAxis(kMachine, "X");
    std::vector<ShapedItem> items;
    for (int periods = 9; periods <= 60; ++periods) {
      if (periods == 20) continue;  // declared, or known
      const double frequency = periods / 3.0 * 2.0 * M_PI / 300.0;
      for (const int component : {0, 4})
        items.push_back({shapes::Harmonic{x, frequency, true}, machine::kComponents * x + component, {}});
    }
    const std::unique_ptr<HarmonicScan> scan = HarmonicScan::Make(linearised, items);
    ASSERT_NE(scan, nullptr);
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    const Eigen::MatrixXd u = Eigen::MatrixXd::NullaryExpr(linearised.count(), 2, [&] { return normal(random); });
    const objective::Stretch& second = linearised.rows.stretches[1];
    Eigen::MatrixXd products = Eigen::MatrixXd::Zero(scan->column_count(), 2), some = products;
    scan->AddProducts(0, u, products);
    scan->AddProducts(second.begin, u.middleRows(second.begin, second.end - second.begin), some);
    const std::vector<Eigen::MatrixXd> grams = scan->Grams(linearised.rows.whitening);
    for (size_t i = 0; i < items.size(); ++i) {
      Eigen::MatrixXd columns = scan->Columns(static_cast<int>(i));
      constexpr double kTolerance = 2e-6;  // of the sum of magnitudes
      const double magnitude = (columns.cwiseAbs().transpose() * u.cwiseAbs()).maxCoeff();
      const auto rows = columns.middleRows(second.begin, second.end - second.begin);
      const auto at = static_cast<Eigen::Index>(2 * i);
      EXPECT_LT((products.middleRows(at, 2) - columns.transpose() * u).cwiseAbs().maxCoeff(), kTolerance * magnitude);
      EXPECT_LT(
          (some.middleRows(at, 2) - rows.transpose() * u.middleRows(second.begin, rows.rows())).cwiseAbs().maxCoeff(),
          kTolerance * magnitude);
      linearised.rows.whitening.Apply(0, columns);
      const Eigen::MatrixXd gram = columns.transpose() * columns;
      EXPECT_LT((grams[i] - gram).cwiseAbs().maxCoeff(), 10.0 * kTolerance * gram.maxCoeff()) << i;
    }
  }
}

// Frequencies that are no multiples of one step, or of two axes, are no scan.
TEST(Effects, UnevenFrequenciesAreNoScan) {
  const identify::Fit fit = FitOf(Runs(), Declared());
  const Linearised linearised = Linearise(fit.problem, fit.point, static_cast<int>(Declared().terms.size()));
  const int x = machine::FindAxis(kMachine, "X"), c = machine::FindAxis(kMachine, "C");
  std::vector<ShapedItem> even;
  for (int order = 5; order <= 30; ++order)
    even.push_back({shapes::Harmonic{c, static_cast<double>(order)}, machine::kComponents * c, {}});
  ASSERT_NE(HarmonicScan::Make(linearised, even), nullptr);
  std::vector<ShapedItem> uneven = even, two_axes = even;
  uneven.push_back({shapes::Harmonic{c, 31.3, true}, machine::kComponents * c, {}});
  EXPECT_EQ(HarmonicScan::Make(linearised, uneven), nullptr);
  two_axes.push_back({shapes::Harmonic{x, 31.0}, machine::kComponents * x, {}});
  EXPECT_EQ(HarmonicScan::Make(linearised, two_axes), nullptr);
}

// A curve pays for each of its functions: a smooth one is taken with few, one with detail with all, never one beside
// the other, and both are the same effect.
TEST(Effects, ACurveIsAsSmoothAsTheReadingsSay) {
  const auto measured = [](const machine::ErrorModel& truth) {
    synthetic::NoiseOptions noise;
    ballbar::PatternOptions options;
    options.step_deg = 2.0;
    return *identify::BindSessions(kMachine,
                                   Measure(kMachine, truth, noise, identify::testing::FivePatterns(), options));
  };
  const identify::Fit plain = FitOf(Runs(), Declared());
  const Scored without(plain, {});
  machine::ErrorTerm curve = without.catalogue.effects[without.Find("EXX:curve")].candidate.term;
  ASSERT_EQ(std::get<shapes::Curve>(curve.shape).functions, 24);
  const auto functions_of = [](const Scored& scored, int group) {
    return std::get<shapes::Curve>(scored.catalogue.effects[group].candidate.term.shape).functions;
  };
  for (const bool is_smooth : {true, false}) {
    constexpr double kSmoothMm[] = {2e-3, 4e-3, -3e-3}, kDetailMm = 4e-3;
    std::copy(std::begin(kSmoothMm), std::end(kSmoothMm), curve.amplitude.begin());
    curve.amplitude[13] = is_smooth ? 0.0 : kDetailMm;
    machine::ErrorModel truth = Declared();
    truth.terms.push_back(curve);
    const identify::Fit fit = FitOf(measured(truth), Declared());
    const Scored scored(fit, {});
    const std::string name = "EXX:curve";
    std::vector<bool> curves;
    for (const Effect& effect : scored.catalogue.effects)
      curves.push_back(effect.bad_row < 0 && loop::IsTerm(effect.candidate.family) &&
                       machine::NameOf(kMachine, effect.candidate.term) == name);
    const std::vector<objective::Move> moves = scored.scorer->Additions({}, 1.0, curves, 10);
    ASSERT_EQ(moves.size(), 3u);
    EXPECT_EQ(functions_of(scored, moves[0].member.group) < 8, is_smooth);
    EXPECT_TRUE(scored.scorer->Additions({moves[0].member}, 1.0, curves, 10).empty());
    const auto term = [&](int i) { return scored.catalogue.effects[moves[i].member.group].candidate.term; };
    EXPECT_TRUE(loop::IsSameEffect(term(0), term(1)));
  }
}

// What was moved to the same place before is that group, and what a state knew before of all others holds of it too.
TEST(Effects, AGroupAtAnotherPlaceIsAddedOnce) {
  const identify::Fit fit = FitOf(Runs(), Declared());
  Scored scored(fit, {});
  objective::Scorer& scorer = *scored.scorer;
  const int backlash = scored.Find("EXX:backlash");
  int reversal = 0;
  while (scorer.group(reversal).family != static_cast<int>(loop::Family::kReversal) || !scorer.IsVisible(reversal))
    ASSERT_LT(++reversal, scorer.group_count());
  const objective::State state = {{backlash, 0.0}};
  scorer.Additions(state, 1.0, {}, 1);  // its products with all groups are kept
  const int count = scorer.group_count();
  const double place = scorer.group(reversal).place + 0.1;
  const int moved = scorer.Append(scorer.MovedTo(reversal, place), reversal);
  EXPECT_EQ(moved, count);
  EXPECT_EQ(scorer.Append(scorer.MovedTo(reversal, place), reversal), moved);
  EXPECT_EQ(scorer.Append(scorer.MovedTo(moved, place), moved), moved);
  EXPECT_EQ(scorer.group_count(), count + 1);
  const double enlarged = scorer.ScoreOf({{backlash, 0.0}, {moved, 0.0}}, 1.0).objective;
  bool is_there = false;
  for (const objective::Move& move : scorer.AdditionsWithin(state, 1.0, INFINITY)) {
    if (move.member.group != moved) continue;
    is_there = true;
    EXPECT_NEAR(move.objective, enlarged, 1e-6);
  }
  EXPECT_TRUE(is_there);
}

// A length between those of the dictionary is reached, and is another place of the same group.
TEST(Effects, AShapeMovesToAnotherLength) {
  const identify::Fit fit = FitOf(Runs(), Declared());
  const Scored scored(fit, {});
  const int x = machine::FindAxis(kMachine, "X");
  const Linearised& linearised = scored.linearised;
  ShapedItem item{shapes::Reversal{x, 4.0}, machine::kComponents * x, {}};
  item.group.reach = 0.7;
  item.group.place = PlaceOf(item.shape);
  const Shaped source(linearised, {item});
  const std::unique_ptr<objective::Source> moved = source.Moved(0, std::log(5.0));
  ASSERT_NE(moved, nullptr);
  EXPECT_DOUBLE_EQ(moved->groups()[0].place, std::log(5.0));
  item.shape = shapes::Reversal{x, 5.0};
  EXPECT_LT((moved->Columns(0) - Shaped(linearised, {item}).Columns(0)).cwiseAbs().maxCoeff(), 1e-12);
  const shapes::Shape there = AtPlace(shapes::Reversal{x, 1.0}, std::log(5.0));
  EXPECT_DOUBLE_EQ(*shapes::NonlinearParameter(there), 5.0);
  item.group.reach = 0.0;
  EXPECT_EQ(Shaped(linearised, {item}).Moved(0, 1.0), nullptr);
}

// So is a place and a width of a local shape.
TEST(Effects, ALocalShapeMovesAndGrows) {
  const identify::Fit fit = FitOf(Runs(), Declared());
  const Scored scored(fit, {});
  const int x = machine::FindAxis(kMachine, "X");
  ShapedItem item{shapes::Bump{x, 40.0, 20.0}, machine::kComponents * x, {}};
  item.group.place = PlaceOf(item.shape);
  item.group.reach = 10.0;
  item.group.size = std::log(20.0);
  const Shaped source(scored.linearised, {item});
  EXPECT_EQ(source.Resized(0, std::log(25.0)), nullptr);  // of one size
  item.group.size_reach = 0.35;
  const std::unique_ptr<objective::Source> moved = Shaped(scored.linearised, {item}).Moved(0, 45.0);
  ASSERT_NE(moved, nullptr);
  const std::unique_ptr<objective::Source> wider = moved->Resized(0, std::log(25.0));
  ASSERT_NE(wider, nullptr);
  item.shape = shapes::Bump{x, 45.0, 25.0};
  EXPECT_LT((wider->Columns(0) - Shaped(scored.linearised, {item}).Columns(0)).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(AsIn(wider->groups()[0], shapes::Bump{x, 1.0, 1.0}), AsIn(wider->groups()[0], item.shape));
  EXPECT_EQ(std::get<shapes::Bump>(AsIn(wider->groups()[0], item.shape)).at, 45.0);
}

// A fault's columns are the derivatives of a run that has it; their products are those of the columns; and a fit with
// the fault, linearised, has its readings as they were.
TEST(Effects, AnInstrumentsFaultHasTheColumnsOfARunThatHasIt) {
  std::vector<instruments::MeasuringRun> runs = Runs();
  const identify::Fit plain = FitOf(runs, Declared());
  const Linearised linearised = Linearise(plain.problem, plain.point, static_cast<int>(Declared().terms.size()));
  const std::vector<instruments::Distortion> faults = DistortionsOf(runs);
  ASSERT_GT(faults.size(), 20u);
  std::vector<Instrumental::Item> items;
  for (const instruments::Distortion& one : faults) items.push_back({one});
  const Instrumental source(linearised, items);
  const Eigen::MatrixXd u = Eigen::MatrixXd::Random(linearised.count(), 2);
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(source.column_count(), 2);
  source.AddProducts(0, u, products);
  Eigen::Index at = 0;
  for (size_t g = 0; g < faults.size(); ++g) {
    const Eigen::MatrixXd columns = source.Columns(static_cast<int>(g));
    EXPECT_LT((columns.transpose() * u - products.middleRows(at, columns.cols())).cwiseAbs().maxCoeff(), 1e-9);
    at += columns.cols();
    instruments::MeasuringRun run = runs[0];
    const Eigen::Index own = static_cast<Eigen::Index>(run.setup.size());
    instruments::AddDistortion(faults[g], &run);
    Eigen::VectorXd setup = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(run.setup.size()));
    setup.head(own) = plain.point.setup[0];
    identify::ErrorsOfRun errors(plain.problem, plain.point);
    instruments::Evaluation evaluation;
    constexpr int kReading = 20;
    instruments::Evaluate(kMachine, run, kReading, errors.At(run.StateOf(kReading)), setup.data(), &evaluation);
    ASSERT_EQ(linearised.run[kReading], 0);
    ASSERT_EQ(linearised.reading[kReading], kReading);
    EXPECT_LT((evaluation.by_setup.row(0).tail(columns.cols()) - columns.row(kReading)).cwiseAbs().maxCoeff(), 1e-12)
        << instruments::TextOf(faults[g]);
  }
  for (instruments::MeasuringRun& run : runs)
    instruments::AddDistortion({.kind = instruments::Distortion::kGrowth,
                                .instrument = run.kind,
                                .tau_s = 60.0,
                                .amplitude_mm = {},
                                .sigma_mm = {}},
                               &run);
  const identify::Fit fit = FitOf(runs, Declared());
  const Linearised with = Linearise(fit.problem, fit.point, static_cast<int>(Declared().terms.size()));
  EXPECT_EQ(with.rows.own.cols(), linearised.rows.own.cols());
  // At one reading: what was measured less what is predicted without the fault.
  Eigen::VectorXd setup = fit.point.setup[0];
  setup[setup.size() - 1] = 0.0;
  double sound_mm = NAN;
  identify::ErrorsOfRun errors(fit.problem, fit.point);
  instruments::Predict(kMachine, runs[0], 0, errors.At(runs[0].StateOf(0)), setup.data(), &sound_mm);
  EXPECT_NEAR(with.rows.y[0], (runs[0].measured_mm(0, 0) - sound_mm) / fit.problem.noise[0].sigma_mm, 1e-6);
}

}  // namespace
}  // namespace axiscal::effects
