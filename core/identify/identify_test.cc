#include "core/identify/identify.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/testing/source_path.h"
#include "core/identify/report.h"
#include "core/identify/testing/scenario.h"
#include "core/machine/machine_json.h"
#include "core/session/read_session.h"

namespace axiscal::identify {
namespace {

using machine::Machine;
using ::testing::HasSubstr;

const Machine kMachine = machine::testing::MultiTasking();
constexpr char kTruth[] =
    R"({"EA0B": 82.1, "EC0B": -61.0, "EB0B": 40.5, "EX0C": -22.2, "EY0C": 15.3, "EA0C": -42.9, "EB0C": 45.6,
                              "EX0T": -2.0, "EZ0T": 29.9})";

const Estimate& Find(const Result& result, const std::string& name) {
  for (const Estimate& estimate : result.estimates) {
    if (estimate.name == name) return estimate;
  }
  ADD_FAILURE() << "no estimate " << name;
  return result.estimates.front();
}

// Noise-free readings without setup offsets: the errors come back exactly, those that only priors tell apart within
// them.
TEST(Identify, ExactReadingsGiveTheErrorsBack) {
  synthetic::NoiseOptions noise;
  noise.sigma_scale = 0.0;
  noise.draw_setup = false;
  const auto truth = testing::Errors(kMachine, kTruth);
  const auto result = Identify(kMachine, testing::Measure(kMachine, truth, noise));
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->rank, 9);
  EXPECT_LT(result->fit.rms_mm, 1e-7);
  for (const machine::ErrorTerm& term : truth.terms) {
    const Estimate& estimate = Find(*result, machine::NameOf(kMachine, term));
    // 0.01 % of a standard uncertainty, or 1e-5 um / urad: what the prior on the run-out pulls.
    EXPECT_NEAR(estimate.value, term.amplitude[0], 1e-2 * estimate.sigma + 1e-8) << estimate.name;
  }
}

// The five patterns move X over a part of its travel: a curve over much more of it is known where they were, and as
// unknown as its prior elsewhere; its functions are more than the readings tell.
TEST(Identify, AFreeCurveIsKnownWhereItWasMeasuredAndHasItsPriorElsewhere) {
  const int x = machine::FindAxis(kMachine, "X");
  const auto truth =
      testing::Errors(kMachine, R"({"terms": [{"symbol": "EYX", "shape": "quadratic", "amplitude": 6}]})");
  const auto sessions = testing::Measure(kMachine, truth, {});
  const auto runs = BindSessions(kMachine, sessions);
  ASSERT_TRUE(runs.ok());
  double low = INFINITY, high = -INFINITY;
  for (const instruments::MeasuringRun& run : *runs) {
    for (int k = 0; k < run.reading_count(); ++k) {
      low = std::min(low, run.PositionsOf(k)[x]);
      high = std::max(high, run.PositionsOf(k)[x]);
    }
  }
  constexpr double kPrior = 0.01;
  Options options;
  options.model = machine::DeclaredModel(kMachine);
  machine::ErrorTerm curve{x, machine::Component::kY, shapes::Curve{x, {low, high + (high - low)}}, {}, kPrior};
  options.model->terms.push_back(curve);
  const auto result = Identify(kMachine, sessions, options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_NEAR(result->fit.chi2_per_dof, 1.0, 0.15);
  EXPECT_TRUE(result->not_separable.empty());
  const auto known =
      machine::ReadKnownErrors(machine::WriteErrors(result->model, kMachine, result->covariance), kMachine);
  ASSERT_TRUE(known.ok()) << known.status();
  const auto term = static_cast<int>(result->model.terms.size()) - 1;
  const auto sigma_at = [&](double position) {
    Eigen::VectorXd by_number = Eigen::VectorXd::Zero(known->covariance.root.rows());
    std::vector<shapes::AxisState> axes(kMachine.axes.size());
    axes[x].position = position;
    double basis[shapes::kMaxBasisCount];
    shapes::Basis(result->model.terms[term].shape, {axes}, basis);
    for (size_t i = 0; i < known->covariance.of.size(); ++i) {
      if (known->covariance.of[i].term == term)
        by_number[static_cast<Eigen::Index>(i)] = basis[known->covariance.of[i].basis];
    }
    return (by_number.transpose() * known->covariance.root).norm();
  };
  // Constant and line of a curve over the measured part alone are other errors' as well; what bends is told.
  EXPECT_GT(sigma_at(high + 0.8 * (high - low)), 0.3 * kPrior);
  EXPECT_LT(sigma_at(0.5 * (low + high)), 0.5 * sigma_at(high + 0.8 * (high - low)));
  double rms = 0.0;
  for (int i = 0; i < 16; ++i) rms += std::pow(result->model.terms[term].amplitude[i], 2);
  EXPECT_LT(std::sqrt(rms), 3.0 * kPrior);
}

TEST(Identify, APerfectMachineHasNoErrors) {
  synthetic::NoiseOptions noise;
  noise.sigma_scale = 1e-7;  // all the same they would be a dead instrument's
  noise.draw_setup = false;
  const auto result = Identify(kMachine, testing::Measure(kMachine, {}, noise));
  ASSERT_TRUE(result.ok()) << result.status();
  for (const Estimate& estimate : result->estimates)
    EXPECT_NEAR(estimate.value / estimate.factor, 0.0, 1e-5) << estimate.name;
  EXPECT_LT(result->nominal.rms_mm, 1e-9);
}

// With noise: truth within four stated uncertainties, residual variance near one.
TEST(Identify, NoisyReadingsGiveTheErrorsWithinTheirUncertainty) {
  const auto truth = testing::Errors(kMachine, kTruth);
  const auto result = Identify(kMachine, testing::Measure(kMachine, truth, {}));
  ASSERT_TRUE(result.ok()) << result.status();
  for (const machine::ErrorTerm& term : truth.terms) {
    const Estimate& estimate = Find(*result, machine::NameOf(kMachine, term));
    EXPECT_TRUE(estimate.identifiable);
    EXPECT_LT(std::abs(estimate.value - term.amplitude[0]), 4.0 * estimate.sigma) << estimate.name;
  }
  EXPECT_NEAR(result->fit.chi2_per_dof, 1.0, 0.1);  // 2527 readings: 0.028 per standard deviation
  EXPECT_TRUE(result->outliers.empty());
  EXPECT_GT(result->nominal.rms_mm, 10 * result->fit.rms_mm);  // before anything was fitted
}

TEST(Identify, WhatTheDataCannotSeparateIsNamedAndGetsNoNumber) {
  Options options;
  options.model = testing::Errors(kMachine, R"({"EX0B": 0, "EA0B": 0, "EX0C": 0, "EB0C": 0, "EX0X": 0})");
  const auto result = Identify(
      kMachine, testing::Measure(kMachine, testing::Errors(kMachine, R"({"EX0B": 5, "EX0C": 25})"), {}), options);
  ASSERT_TRUE(result.ok()) << result.status();
  // EX0B and EX0X shift the spindle, EX0C shifts the table the other way.
  EXPECT_EQ(result->rank, 3);
  EXPECT_THAT(result->not_separable, ::testing::UnorderedElementsAre("EX0B + EX0C", "EX0B - EX0X"));
  for (const char* name : {"EX0B", "EX0C", "EX0X"}) {
    EXPECT_FALSE(Find(*result, name).identifiable);
    EXPECT_TRUE(std::isnan(Find(*result, name).value));
  }
  ASSERT_EQ(result->determined.size(), 1u);
  EXPECT_EQ(result->determined[0].name, "EX0B - EX0C + EX0X");
  // Determined up to the run-out of each session's tool ball, 3 um over the square root of a few sessions.
  EXPECT_NEAR(result->determined[0].value, -0.020, 4 * result->determined[0].sigma);
  EXPECT_TRUE(Find(*result, "EA0B").identifiable);
  EXPECT_THAT(reports::ToJson(ReportOf(*result)), HasSubstr("\"value\": null"));
}

// A bar along X there and back while A turns the table, its ball `across_mm` from A; positions as controls write them.
session::Session TurnOfA(const std::string& name, double across_mm, double height_mm) {
  session::Session session;
  session.header = {{"machine", "a4"},
                    {"session", name},
                    {"instrument", "ballbar"},
                    {"sigma_um", "0.3"},
                    {"tool_tip_mm", "0 0 -210.7"},
                    {"table_ball_mm", absl::StrCat("-68.8 ", across_mm, " ", height_mm)},
                    {"bar_length_mm", "100"}};
  for (const char* column : {"t_s", "X_mm", "Y_mm", "Z_mm", "A_deg"}) session.columns.push_back({column, {}, {}});
  constexpr double kHeightOfA = 80.0;
  for (int i = 0; i < 362; ++i) {
    const double deg = -180.0 + 2.0 * std::min(i, 361 - i), c = std::cos(deg * M_PI / 180),
                 s = std::sin(deg * M_PI / 180);
    const double above = height_mm - kHeightOfA;
    const double row[] = {0.5 * i, 31.2, across_mm * c - above * s, 210.7 + kHeightOfA + across_mm * s + above * c,
                          deg};
    for (size_t k = 0; k < session.columns.size(); ++k)
      session.columns[k].values.push_back(std::round(row[k] * 1e4) / 1e4);
  }
  return session;
}

// Across the bar a squareness shows by the last digit of the positions alone. It is not fitted: it would stand at a
// radian and more, bend the bar, and leave the readings worse explained than by set-ups alone.
TEST(Identify, WhatOnlyTheRoundingOfPositionsShowsIsNotSeen) {
  using machine::testing::kX, machine::testing::kY, machine::testing::kZ, machine::testing::Linear;
  const Machine machine = machine::testing::Make(
      "a4", {Linear("Z", kZ)}, {Linear("Y", -kY), Linear("X", -kX), machine::testing::Rotary("A", kX, {0, 0, 80})},
      {"EY0A", "EZ0A", "EB0A", "EC0A", "EC0Y", "EA0Z", "EB0Z"});
  const auto truth = testing::Errors(machine, R"({"EB0A": 60, "EC0A": -40})");
  std::vector<session::Session> sessions;
  for (const session::Session& planned : {TurnOfA("low", 66.5, 47.4), TurnOfA("far", 25.1, 32.8)})
    sessions.push_back(*synthetic::Simulate(machine, truth, planned, {}));
  const auto result = Identify(machine, sessions);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_FALSE(Find(*result, "EA0Z").identifiable);
  EXPECT_EQ(result->noise_scale, 1.0);
  EXPECT_LT(result->fit.rms_mm, 0.4e-3);
}

TEST(Identify, ScatteredBadReadingsAreListedAndDoNoHarm) {
  const auto truth = testing::Errors(kMachine, kTruth);
  auto sessions = testing::Measure(kMachine, truth, {});
  const auto clean = Identify(kMachine, sessions);
  ASSERT_TRUE(clean.ok());
  sessions[2].columns.back().values[99] += 0.055;
  sessions[4].columns.back().values[640] -= 0.010;
  const auto dirty = Identify(kMachine, sessions);
  ASSERT_TRUE(dirty.ok());
  ASSERT_EQ(dirty->outliers.size(), 2u);
  EXPECT_EQ(dirty->outliers[0].session, "CR");
  EXPECT_EQ(dirty->outliers[0].row, 100);
  EXPECT_NEAR(dirty->outliers[0].residual_mm, -0.055, 2e-3);
  for (size_t i = 0; i < clean->estimates.size(); ++i) {
    EXPECT_NEAR(dirty->estimates[i].value, clean->estimates[i].value, 0.2 * clean->estimates[i].sigma);
  }
}

// The uncertainty of EC0B over that of readings taken for independent.
double LargerByCorrelation(const synthetic::NoiseOptions& noise) {
  const auto sessions = testing::Measure(kMachine, testing::Errors(kMachine, kTruth), noise);
  const auto judged = Identify(kMachine, sessions);
  Options as_independent;
  as_independent.judge_correlation = false;
  const auto independent = Identify(kMachine, sessions, as_independent);
  if (!judged.ok() || !independent.ok()) return NAN;
  EXPECT_NEAR(judged->fit.chi2_per_dof, 1.0, 0.15);
  return Find(*judged, "EC0B").sigma / Find(*independent, "EC0B").sigma;
}

// A mean over n readings that remember their neighbours with 0.6 is uncertain by sqrt(1.6 / 0.4) = 2 times that of n
// independent ones; errors that the priors leave to the readings alone come near that.
TEST(Identify, CorrelatedReadingsStateLargerUncertainties) {
  synthetic::NoiseOptions noise;
  noise.ar1 = 0.6;
  const double larger = LargerByCorrelation(noise);
  EXPECT_GT(larger, 1.6);
  EXPECT_LT(larger, 2.2);
}

// The same of noise that is half white: its slow half averages down as slowly as if it were alone, 5 times by variance.
TEST(Identify, AWhiteShareDoesNotHideWhatTheNoiseRemembers) {
  synthetic::NoiseOptions noise;
  noise.ar1 = 0.8;
  noise.white_share = 0.5;
  const double larger = LargerByCorrelation(noise);
  EXPECT_GT(larger, 1.8);
  EXPECT_LT(larger, 2.6);
}

TEST(Identify, ReadingsOfACoarseDisplayAreWarnedOfAndScatterByTheirRounding) {
  synthetic::NoiseOptions noise;
  noise.resolution_mm = 2e-3;
  const auto truth = testing::Errors(kMachine, kTruth);
  const auto result = Identify(kMachine, testing::Measure(kMachine, truth, noise));
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_FALSE(result->warnings.empty());
  EXPECT_EQ(reports::InWords(result->warnings[0]).kind, reports::WarningKind::kResolution);
  EXPECT_THAT(reports::InWords(result->warnings[0]).text,
              HasSubstr("readings stand in steps of 2 um, expected at most 2 times the stated "
                        "sigma of 0.3 um"));
  EXPECT_TRUE(result->outliers.empty());
  for (const machine::ErrorTerm& term : truth.terms) {
    const Estimate& estimate = Find(*result, machine::NameOf(kMachine, term));
    EXPECT_NEAR(estimate.value, term.amplitude[0], 4.0 * estimate.sigma) << estimate.name;
  }
}

TEST(Identify, AnInstrumentThatReadsOneValueIsRefused) {
  auto sessions = testing::Measure(kMachine, testing::Errors(kMachine, kTruth), {});
  std::vector<double>& readings = sessions[1].columns.back().values;
  std::fill(readings.begin() + 40, readings.begin() + 90, readings[40]);
  const auto result = Identify(kMachine, sessions);
  EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(result.status().message()), HasSubstr("readings 41 to 90 of session"));
}

// A tilt of the table that nobody declared is taken up by balls pulled across the bar, along a valley without a floor:
// such a fit ended without an answer.
TEST(Identify, AModelThatLacksATiltIsFittedAllTheSame) {
  for (const double tilt_urad : {150.0, 250.0, 400.0}) {
    Options options;
    options.model = testing::Errors(kMachine, R"({"EA0B": 0, "EC0B": 0, "EB0B": 0, "EX0C": 0, "EY0C": 0, "EA0C": 0,
                                                  "EX0T": 0, "EZ0T": 0})");
    const auto truth = testing::Errors(
        kMachine, absl::StrFormat(R"({"EA0B": 20, "EC0B": 20, "EX0C": 20, "EZ0T": 20, "EB0C": %g})", tilt_urad));
    const auto result = Identify(kMachine, testing::Measure(kMachine, truth, {}), options);
    ASSERT_TRUE(result.ok()) << tilt_urad << ": " << result.status();
    EXPECT_GT(result->fit.chi2_per_dof * result->noise_scale * result->noise_scale, 1.5) << tilt_urad;  // it says so
  }
}

// Sigma estimated from few readings: the interval is Student's.
TEST(Identify, FewReadingsThatScatterMoreTakeStudentsT) {
  ballbar::PatternOptions few;
  few.step_deg = 45.0;
  synthetic::NoiseOptions noise;
  noise.sigma_scale = 3.0;
  const auto result = Identify(
      kMachine, testing::Measure(kMachine, testing::Errors(kMachine, kTruth), noise, testing::FivePatterns(), few));
  ASSERT_TRUE(result.ok()) << result.status();
  const int freedom = result->fit.degrees_of_freedom;
  ASSERT_GT(result->fit.chi2_per_dof, 1.0);
  ASSERT_TRUE(freedom >= 20 && freedom <= 60) << freedom;  // t(20) = 2.086, t(60) = 2.000
  EXPECT_GT(result->coverage_factor, 2.000);
  EXPECT_LT(result->coverage_factor, 2.087);
  EXPECT_THAT(reports::ToJson(ReportOf(*result)), HasSubstr("\"coverage_factor\": 2.0"));
}

// Many readings that scatter by half of what was stated say so.
TEST(Identify, ManyReadingsThatScatterLessThanStatedNarrowTheirIntervals) {
  synthetic::NoiseOptions noise;
  const auto as_stated = Identify(kMachine, testing::Measure(kMachine, testing::Errors(kMachine, kTruth), noise));
  noise.sigma_scale = 0.5;
  const auto quieter = Identify(kMachine, testing::Measure(kMachine, testing::Errors(kMachine, kTruth), noise));
  ASSERT_TRUE(as_stated.ok() && quieter.ok());
  EXPECT_NEAR(quieter->fit.chi2_per_dof, 1.0, 0.1);
  EXPECT_NEAR(Find(*quieter, "EC0B").sigma / Find(*as_stated, "EC0B").sigma, 0.5, 0.1);
}

// A third of the readings off by fifty sigma is no chip: the fit says so.
TEST(Identify, TooManyBadReadingsAreSaidAloud) {
  auto sessions = testing::Measure(kMachine, testing::Errors(kMachine, kTruth), {});
  ASSERT_TRUE(Identify(kMachine, sessions)->warnings.empty());
  std::vector<double>& values = sessions[2].columns.back().values;
  for (size_t k = 0; k < values.size(); k += 5) values[k] += 0.050;
  const auto result = Identify(kMachine, sessions);
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_FALSE(result->warnings.empty());
  EXPECT_EQ(reports::InWords(result->warnings[0]).kind, reports::WarningKind::kSetAside);
  EXPECT_THAT(reports::ToJson(ReportOf(*result)), HasSubstr("too many for chips"));
}

// A number that is wider than 10 mm or 30 mrad is none, and the model does not act by it.
TEST(Identify, ANumberWiderThanAnyErrorIsNone) {
  auto sessions = testing::Measure(kMachine, testing::Errors(kMachine, kTruth), {});
  for (session::Session& session : sessions) {
    for (session::HeaderEntry& entry : session.header) {
      if (entry.key == "sigma_um") entry.value = "90000";
    }
  }
  Options options;
  options.judge_correlation = false;  // sigma as stated
  const auto result = Identify(kMachine, sessions, options);
  ASSERT_TRUE(result.ok()) << result.status();
  int without = 0;
  for (size_t i = 0; i < result->estimates.size(); ++i) {
    const Estimate& estimate = result->estimates[i];
    const double largest = estimate.unit == "um" ? 10.0 : 0.03;
    EXPECT_FALSE(estimate.sigma > largest) << estimate.name << ' ' << estimate.sigma;
    if (!std::isnan(estimate.value)) continue;
    ++without;
    EXPECT_FALSE(estimate.identifiable) << estimate.name;
  }
  EXPECT_GT(without, 0);
  EXPECT_FALSE(result->not_separable.empty());
  for (const Combination& combination : result->determined)
    EXPECT_LE(combination.sigma, combination.unit == "um" ? 10.0 : 0.03) << combination.name;
  const std::string json = reports::ToJson(ReportOf(*result));
  EXPECT_THAT(json, HasSubstr("\"value\": null"));
}

// The only readings that told an error were set aside: nothing is left that tells it, and it acts nowhere.
TEST(Identify, WhatOnlyBadReadingsToldHasNoNumberAndDoesNotAct) {
  machine::ErrorModel truth = testing::Errors(kMachine, R"({"EX0C": -22.2, "EY0C": 15.3})");
  std::vector<session::Session> sessions = testing::Measure(
      kMachine, truth, {}, {{"CR", ballbar::Pattern::kCR, 356.4}, {"CA", ballbar::Pattern::kCA, 356.4}});
  const session::Column* const c = session::FindColumn(sessions[0], "C_deg");
  ASSERT_NE(c, nullptr);
  size_t at = 0;  // of two neighbours on the way up, near 60 deg, where the bar points along X by half
  while (c->values[at] < 60.0) ++at;
  const double step_deg = c->values[at + 1] - c->values[at];
  ASSERT_GT(step_deg, 0.0);
  machine::ErrorTerm defect = truth.terms[0];
  // Of all readings at other positions none is nearer than three times what these two are: less than 1e-6 of it.
  defect.shape = shapes::Bump{.axis = machine::FindAxis(kMachine, "C"),
                              .at = (c->values[at] + 0.5 * step_deg) * M_PI / 180.0,
                              .width = 0.4 * step_deg * M_PI / 180.0};
  Options options;
  options.model = truth;
  options.model->terms.push_back(defect);
  const auto seen = Identify(kMachine, sessions, options);
  ASSERT_TRUE(seen.ok()) << seen.status();
  EXPECT_TRUE(seen->estimates.back().identifiable);
  // Chips between ball and cup, wherever the two positions were passed.
  std::vector<double>& lengths = sessions[0].columns.back().values;
  for (size_t k = 0; k < lengths.size(); ++k) {
    const double off = (c->values[k] - c->values[at]) / step_deg;
    if (off > -0.5 && off < 1.5) lengths[k] += off < 0.5 ? 0.5 : -0.5;
  }
  const auto result = Identify(kMachine, sessions, options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->outliers.size(), 4u);
  const Estimate& estimate = result->estimates.back();
  EXPECT_FALSE(estimate.identifiable) << estimate.value << " +- " << estimate.sigma;
  EXPECT_TRUE(std::isnan(estimate.value)) << estimate.value << " +- " << estimate.sigma;
  EXPECT_EQ(result->model.terms.back().amplitude[0], 0.0);
  for (size_t i = 0; i < 2; ++i) {
    const Estimate& other = result->estimates[i];
    EXPECT_TRUE(other.identifiable) << other.name;
    EXPECT_NEAR(other.value, truth.terms[i].amplitude[0], 4.0 * other.sigma) << other.name;
  }
}

// The X that the control shows is `off_mm` short of where the axis stands: the work offset was set anew.
void SetAnew(double off_mm, session::Session* session) {
  for (session::Column& column : session->columns) {
    if (column.name != "X_mm") continue;
    for (double& position : column.values) position -= off_mm;
  }
}

// A constant of one session is set-up where its header says so, and proposed where nobody does.
TEST(Identify, AWorkOffsetThatWasSetAnewIsSetUpAndNoError) {
  const auto truth = testing::Errors(kMachine, kTruth);
  std::vector<testing::Measured> patterns = testing::FivePatterns();
  patterns.push_back({"CR-again", ballbar::Pattern::kCR, 356.4});
  std::vector<session::Session> sessions = testing::Measure(kMachine, truth, {}, patterns);
  constexpr double kOffMm = 0.040;
  SetAnew(kOffMm, &sessions[5]);
  const auto silent = Identify(kMachine, sessions);
  ASSERT_TRUE(silent.ok()) << silent.status();
  EXPECT_GT(std::abs(Find(*silent, "EX0C").value + 22.2e-3), 4.0 * Find(*silent, "EX0C").sigma);
  std::string warned;
  for (const reports::WarningFacts& facts : silent->warnings) {
    const auto* const moved = std::get_if<reports::DatumMoved>(&facts);
    if (moved == nullptr) continue;
    warned = reports::InWords(facts).text;
    for (const reports::DatumMoved::Axis& axis : moved->groups[0].axes) {
      if (axis.name != "X") continue;
      EXPECT_NEAR(std::abs(axis.moved_um), 1e3 * kOffMm, 4.0 * axis.sigma_um);
      EXPECT_GT(std::abs(axis.moved_um), 5.0 * axis.sigma_um);
    }
  }
  EXPECT_THAT(warned, HasSubstr("by a constant of the commanded position (X by "));
  EXPECT_THAT(warned, HasSubstr("Then '# datum: free X"));
  sessions[5].header.push_back({"datum", "free X"});
  const auto stated = Identify(kMachine, sessions);
  ASSERT_TRUE(stated.ok()) << stated.status();
  for (const machine::ErrorTerm& term : truth.terms) {
    const Estimate& estimate = Find(*stated, machine::NameOf(kMachine, term));
    EXPECT_LT(std::abs(estimate.value - term.amplitude[0]), 4.0 * estimate.sigma) << estimate.name;
  }
  EXPECT_TRUE(stated->warnings.empty());
  const SetupOffset& datum = stated->sessions[5].setup.back();
  EXPECT_EQ(datum.name, "datum_X");
  EXPECT_NEAR(datum.value, kOffMm, 4.0 * datum.sigma);
  EXPECT_LT(datum.sigma, 0.2 * kOffMm);
  // Free in every session that sees where C stands, nothing tells it.
  for (session::Session& session : sessions) {
    if (!session::FindHeader(session, "datum")) session.header.push_back({"datum", "free X"});
  }
  const auto all_free = Identify(kMachine, sessions);
  ASSERT_TRUE(all_free.ok()) << all_free.status();
  EXPECT_FALSE(Find(*all_free, "EX0C").identifiable);
}

// Where the readings say less of a free constant than the prior that keeps the fit steady, it has no number: neither in
// the result nor as it is written.
TEST(Identify, ADatumThatNoReadingTellsHasNoNumber) {
  std::vector<session::Session> sessions = testing::Measure(kMachine, testing::Errors(kMachine, kTruth), {});
  sessions[2].header.push_back({"datum", "free X Z"});  // a ball bar in the plane of X and Y does not see Z
  const auto result = Identify(kMachine, sessions);
  ASSERT_TRUE(result.ok()) << result.status();
  const std::vector<SetupOffset>& setup = result->sessions[2].setup;
  const SetupOffset &x = setup[setup.size() - 2], &z = setup.back();
  ASSERT_EQ(x.name + " " + z.name, "datum_X datum_Z");
  EXPECT_TRUE(std::isfinite(x.value)) << x.sigma;
  EXPECT_LT(x.sigma, 0.1);
  EXPECT_TRUE(std::isnan(z.value)) << z.value << " +- " << z.sigma;
  EXPECT_TRUE(std::isnan(z.sigma)) << z.sigma;
  const reports::Identification report = ReportOf(*result);
  const std::vector<reports::SessionFit>& written = report.fitted.sessions;
  EXPECT_TRUE(std::isfinite(written[2].setup[setup.size() - 2].second.value));
  EXPECT_TRUE(std::isnan(written[2].setup.back().second.value));
  // Stated, it is known that well whatever the readings tell.
  sessions[2].header.push_back({"datum_Z_sigma_um", "40"});
  const auto stated = Identify(kMachine, sessions);
  ASSERT_TRUE(stated.ok()) << stated.status();
  EXPECT_NEAR(stated->sessions[2].setup.back().sigma, 0.040, 0.004);
}

// How far a work offset went that nobody stated says nothing of the fit: no misfit, no size beyond a machine's, and
// another session that was set anew is found beside it. Where somebody did state it, it is a reading.
TEST(Identify, AFreeDatumJudgesNothingUnlessItIsStated) {
  const auto truth = testing::Errors(kMachine, kTruth);
  std::vector<testing::Measured> patterns = testing::FivePatterns();
  patterns.push_back({"CR-again", ballbar::Pattern::kCR, 356.4});
  patterns.push_back({"CR-third", ballbar::Pattern::kCR, 356.4});
  std::vector<session::Session> sessions = testing::Measure(kMachine, truth, {}, patterns);
  const auto as_stated = Identify(kMachine, sessions);
  ASSERT_TRUE(as_stated.ok()) << as_stated.status();
  constexpr double kOffMm = 20.0;
  SetAnew(kOffMm, &sessions[5]);
  sessions[5].header.push_back({"datum", "free X"});
  const auto free = Identify(kMachine, sessions);
  ASSERT_TRUE(free.ok()) << free.status();
  const SetupOffset& datum = free->sessions[5].setup.back();
  EXPECT_NEAR(datum.value, kOffMm, 5.0 * datum.sigma + 1e-3);
  EXPECT_NEAR(free->fit.chi2_per_dof, as_stated->fit.chi2_per_dof, 0.02);
  EXPECT_EQ(free->fit.degrees_of_freedom, as_stated->fit.degrees_of_freedom - 1);
  EXPECT_TRUE(free->warnings.empty()) << reports::InWords(free->warnings.front()).text;
  std::vector<session::Session> another = sessions;
  SetAnew(0.040, &another[6]);
  const auto two = Identify(kMachine, another);
  ASSERT_TRUE(two.ok()) << two.status();
  EXPECT_TRUE(std::any_of(two->warnings.begin(), two->warnings.end(), [](const reports::WarningFacts& facts) {
    return std::holds_alternative<reports::DatumMoved>(facts);
  }));
  sessions[5].header.push_back({"datum_X_sigma_um", "100"});
  const auto stated = Identify(kMachine, sessions);
  ASSERT_TRUE(stated.ok()) << stated.status();
  EXPECT_EQ(stated->fit.degrees_of_freedom, as_stated->fit.degrees_of_freedom);
  EXPECT_GT(stated->fit.chi2_per_dof * stated->fit.degrees_of_freedom, 3e4);  // (20 mm / 0.1 mm)^2
  EXPECT_TRUE(std::any_of(stated->warnings.begin(), stated->warnings.end(), [](const reports::WarningFacts& facts) {
    return std::holds_alternative<reports::Scatter>(facts);
  }));
}

// Bad readings change what is fitted: the fit without them must converge too.
TEST(Identify, AFitThatDoesNotConvergeWithoutItsBadReadingsIsNone) {
  std::vector<session::Session> sessions = testing::Measure(kMachine, testing::Errors(kMachine, kTruth), {});
  for (const size_t reading : {40u, 90u, 170u}) sessions[1].columns.back().values[reading] += 2.0;
  Options options;
  options.judge_correlation = options.set_outliers_aside = options.raise_noise = options.profile_intervals = false;
  const auto with_bad = FitSessions(kMachine, sessions, options);
  ASSERT_TRUE(with_bad.ok()) << with_bad.status();
  const auto fit_from_there = [&] {
    return FitProblem(with_bad->problem, with_bad->result.model, options, with_bad->point.setup).status();
  };
  options.max_iterations = 1;
  EXPECT_TRUE(fit_from_there().ok());  // it is there already
  options.set_outliers_aside = true;
  EXPECT_THAT(std::string(fit_from_there().message()), HasSubstr("has not converged after 1 iterations"));
}

TEST(Identify, SessionsOfOneSetUpHaveOneDatum) {
  std::vector<session::Session> sessions = testing::Measure(kMachine, testing::Errors(kMachine, kTruth), {});
  for (session::Session& session : sessions) session.header.push_back({"setup", "one"});
  sessions[1].header.push_back({"datum", "free X"});
  const auto refused = Identify(kMachine, sessions);
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("share the setup 'one' but not the datum"));
}

const reports::WarningFacts* FirstWarning(const Result& result) {
  return result.warnings.empty() ? nullptr : &result.warnings.front();
}

// A tool 5 mm shorter than stated; readings in m or inch in place of mm.
TEST(Identify, SizesThatNoMachineHasAndReadingsThatAreTooQuietAreSaidFirst) {
  const auto truth = testing::Errors(kMachine, R"({"EA0B": 20, "EX0C": 20, "EZ0T": 5000})");
  Options options;
  options.model = truth;
  const auto shorter = Identify(kMachine, testing::Measure(kMachine, truth, {}), options);
  ASSERT_TRUE(shorter.ok()) << shorter.status();
  ASSERT_NE(FirstWarning(*shorter), nullptr);
  const auto* const beyond = std::get_if<reports::BeyondSize>(FirstWarning(*shorter));
  ASSERT_NE(beyond, nullptr);
  ASSERT_EQ(beyond->errors.size(), 1u);
  EXPECT_EQ(beyond->errors[0].name, "EZ0T");
  EXPECT_THAT(reports::InWords(*beyond).text, HasSubstr("tool_tip_mm"));
  for (const double unit_mm : {25.4, 1000.0}) {
    auto sessions = testing::Measure(kMachine, testing::Errors(kMachine, kTruth), {});
    for (session::Session& session : sessions) {
      for (session::Column& column : session.columns) {
        if (column.name != "dL_mm") continue;
        for (double& reading : column.values) reading /= unit_mm;
      }
    }
    const auto small = Identify(kMachine, sessions);
    ASSERT_TRUE(small.ok()) << small.status();
    ASSERT_NE(FirstWarning(*small), nullptr) << unit_mm;
    const auto* const quiet = std::get_if<reports::Quiet>(FirstWarning(*small));
    ASSERT_NE(quiet, nullptr) << unit_mm;
    EXPECT_EQ(quiet->sessions.size(), sessions.size());
    EXPECT_THAT(reports::InWords(*quiet).text, HasSubstr("in m or inch in place of mm"));
  }
  const auto right = Identify(kMachine, testing::Measure(kMachine, testing::Errors(kMachine, kTruth), {}));
  ASSERT_TRUE(right.ok());
  EXPECT_TRUE(right->warnings.empty());
}

// Sphere centres that are the sphere's tops: where its place is known (a certificate), the head's axis seems to stand a
// radius deeper. Where it is not, the radius is the set-up's, and no error moves.
TEST(Identify, AForgottenSphereRadiusIsSaidFirst) {
  const std::string folder = base::SourcePath("/deploy/examples/fang-grinder");
  const Machine machine = machine::ReadMachineFile(folder + "/machine.json").value();
  const auto truth = testing::Errors(machine, R"({"EX0B": 20, "EZ0B": -28, "EA0B": 50, "EC0B": 30, "EX0C": 10})");
  std::vector<session::Session> sessions;
  for (const char* const name : {"pattern-1", "pattern-2"}) {
    synthetic::NoiseOptions noise;
    noise.seed = 3 + sessions.size();
    noise.draw_setup = false;
    const session::Session planned = session::ReadSessionFile(absl::StrCat(folder, "/fit/", name, ".csv")).value();
    sessions.push_back(synthetic::Simulate(machine, truth, planned, noise).value());
  }
  Options options;
  options.model = truth;
  const auto right = Identify(machine, sessions, options);
  ASSERT_TRUE(right.ok()) << right.status();
  EXPECT_TRUE(right->warnings.empty()) << reports::InWords(right->warnings.front()).text;
  constexpr double kRadiusMm = 16.0;
  for (session::Session& session : sessions) {
    for (session::Column& column : session.columns) {
      if (column.name != "cz_mm") continue;
      for (double& height : column.values) height += kRadiusMm;
    }
  }
  const auto forgotten = Identify(machine, sessions, options);
  ASSERT_TRUE(forgotten.ok()) << forgotten.status();
  EXPECT_NEAR(Find(*forgotten, "EZ0B").value, -0.028 - kRadiusMm, 0.1);
  ASSERT_NE(FirstWarning(*forgotten), nullptr);
  const auto* const beyond = std::get_if<reports::BeyondSize>(FirstWarning(*forgotten));
  ASSERT_NE(beyond, nullptr);
  ASSERT_EQ(beyond->errors.size(), 1u);
  EXPECT_EQ(beyond->errors[0].name, "EZ0B");
  EXPECT_THAT(reports::InWords(*beyond).text, HasSubstr("a radius of sphere or stylus (forgotten or counted twice)"));
  for (session::Session& session : sessions)
    std::erase_if(session.header, [](const session::HeaderEntry& entry) { return entry.key == "ball_z_sigma_um"; });
  const auto mounted = Identify(machine, sessions, options);
  ASSERT_TRUE(mounted.ok()) << mounted.status();
  for (const Estimate& estimate : mounted->estimates) {
    if (!estimate.identifiable) continue;
    EXPECT_NEAR(estimate.value, Find(*right, estimate.name).value, 4.0 * estimate.sigma) << estimate.name;
  }
}

TEST(Identify, CancellationReachesTheSolver) {
  Options options;
  int polls = 0;
  options.cancelled = [&polls] { return ++polls > 1; };
  const auto result = Identify(kMachine, testing::Measure(kMachine, testing::Errors(kMachine, kTruth), {}), options);
  EXPECT_EQ(result.status().code(), absl::StatusCode::kCancelled);
}

TEST(Identify, BadInputIsRefused) {
  auto sessions = testing::Measure(kMachine, {}, {});
  auto broken = sessions;
  broken[1].columns.back().values[7] = NAN;
  EXPECT_THAT(std::string(Identify(kMachine, broken).status().message()),
              HasSubstr("session 'BY': reading 8: dL_mm = nan"));
  broken = sessions;
  broken[1] = broken[0];
  EXPECT_THAT(std::string(Identify(kMachine, broken).status().message()), HasSubstr("session 'BX' is there twice"));
  EXPECT_THAT(std::string(Identify(machine::testing::SwivelHead(), sessions).status().message()),
              HasSubstr("measured on machine 'mt'"));
  EXPECT_EQ(Identify(kMachine, {}).status().code(), absl::StatusCode::kInvalidArgument);
  Options options;
  options.max_iterations = 0;
  EXPECT_THAT(std::string(Identify(kMachine, sessions, options).status().message()),
              HasSubstr("max_iterations = 0, must be > 0"));
}

}  // namespace
}  // namespace axiscal::identify
