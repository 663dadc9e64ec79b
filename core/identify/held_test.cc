#include "core/identify/held.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/identify/monte_carlo.h"
#include "core/identify/report.h"
#include "core/identify/testing/scenario.h"

namespace axiscal::identify {
namespace {

using ::testing::HasSubstr;

const machine::Machine kMachine = machine::testing::MultiTasking();
constexpr char kTruth[] = R"({"EA0B": 82.1, "EC0B": -61.0, "EB0B": 40.5, "EX0C": -22.2, "EA0C": -42.9, "EB0C": 45.6})";
constexpr char kHead[] = R"({"EA0B": 0, "EB0B": 0, "EC0B": 0})";
constexpr char kTable[] = R"({"EX0C": 0, "EA0C": 0, "EB0C": 0})";

std::vector<session::Session> Sessions(const std::vector<testing::Measured>& patterns, uint64_t seed,
                                       double sigma_scale = 1.0) {
  synthetic::NoiseOptions noise;
  noise.seed = seed;
  noise.sigma_scale = sigma_scale;
  noise.draw_setup = sigma_scale > 0.0;
  ballbar::PatternOptions plan;
  plan.step_deg = 5.0;
  return testing::Measure(kMachine, testing::Errors(kMachine, kTruth), noise, patterns, plan);
}

// B's axis alone, then C's, on which B's tilts act by the tool's length.
const std::vector<testing::Measured> kOfHead = {{"BX", ballbar::Pattern::kBX, 356.4},
                                                {"BY", ballbar::Pattern::kBY, 356.4}};
const std::vector<testing::Measured> kOfTable = {{"CR", ballbar::Pattern::kCR, 356.4},
                                                 {"CA", ballbar::Pattern::kCA, 356.4}};

Fit FitOrDie(const std::vector<session::Session>& sessions, const char* model, std::optional<HeldErrors> held = {}) {
  Options options;
  options.model = testing::Errors(kMachine, model);
  options.held_errors = std::move(held);
  return FitSessions(kMachine, sessions, options).value();
}

// A calibration as it is printed.
std::string Printed(const Result& result, const std::string& machine = "mt") {
  nlohmann::ordered_json calibration = {{"machine", machine}};
  calibration["model"] = nlohmann::ordered_json::parse(machine::WriteErrors(result.model, kMachine));
  calibration["report"] = nlohmann::ordered_json::parse(reports::ToJson(ReportOf(result)));
  return calibration.dump();
}

const Estimate& Find(const std::vector<Estimate>& estimates, const std::string& name) {
  for (const Estimate& estimate : estimates) {
    if (estimate.name == name) return estimate;
  }
  ADD_FAILURE() << "no estimate " << name;
  return estimates.front();
}

TEST(HeldErrors, SecondStageFindsTheRestExactlyAndIsWrongWithoutTheFirst) {
  const auto head = ReadHeldErrors(R"({"EA0B": 82.1, "EC0B": -61.0, "EB0B": 40.5})", kMachine);
  ASSERT_TRUE(head.ok()) << head.status();
  const auto sessions = Sessions(kOfTable, 1, 0.0);
  const Result held = FitOrDie(sessions, kTable, *head).result;
  for (const machine::ErrorTerm& term :
       testing::Errors(kMachine, R"({"EX0C": -22.2, "EA0C": -42.9, "EB0C": 45.6})").terms) {
    const Estimate& found = Find(held.estimates, machine::NameOf(kMachine, term));
    EXPECT_NEAR(found.value, term.amplitude[0], 1e-2 * found.sigma + 1e-8) << found.name;
  }
  EXPECT_LT(held.fit.rms_mm, 1e-7);
  ASSERT_EQ(held.held_errors.size(), 3u);
  // B's tilt moves the tool point by 40.5 urad x 356.4 mm: taken for C's offset where nobody says so.
  const Result alone = FitOrDie(sessions, kTable).result;
  EXPECT_GT(std::abs(Find(alone.estimates, "EX0C").value + 0.0222), 0.01);
}

// The variance of what is fitted is that of the readings and, independent of it, that of the held errors.
TEST(HeldErrors, TheirUncertaintyIsCarried) {
  const Result head = FitOrDie(Sessions(kOfHead, 3), kHead).result;
  const auto held = ReadHeldErrors(Printed(head), kMachine);
  ASSERT_TRUE(held.ok()) << held.status();
  EXPECT_NEAR(Find(held->errors, "EB0B").sigma / Find(head.estimates, "EB0B").sigma, 1.0, 1e-9);
  const auto exact = ReadHeldErrors(machine::WriteErrors(head.model, kMachine), kMachine);
  ASSERT_TRUE(exact.ok()) << exact.status();
  EXPECT_TRUE(std::isnan(Find(exact->errors, "EB0B").sigma));
  const auto sessions = Sessions(kOfTable, 4);
  const Result with = FitOrDie(sessions, kTable, *held).result, without = FitOrDie(sessions, kTable, *exact).result;
  const Estimate &carried = Find(with.estimates, "EX0C"), &bare = Find(without.estimates, "EX0C");
  EXPECT_NEAR(carried.value, bare.value, 1e-12);
  // EX0C + 356.4 mm EB0B is what CR sees (Yao 2022): the slope by the held tilt is the tool's length.
  const double by_tilt = 356.4 * Find(head.estimates, "EB0B").sigma;
  EXPECT_NEAR(carried.sigma / std::hypot(bare.sigma, by_tilt), 1.0, 0.01);
  EXPECT_GT(by_tilt, 0.1 * bare.sigma);
}

std::vector<session::Session> OnOneSetup(std::vector<session::Session> sessions) {
  for (session::Session& session : sessions) session.header.push_back({"setup", "mount"});
  return sessions;
}

// The run-out of the tool ball is known to the micrometres that are stated of it, and EX0C rests on them: nothing else
// tells both apart with one tool. EB0C rests on nothing that is stated.
TEST(HeldErrors, WhatBothStagesRestOnIsSaid) {
  const auto head = ReadHeldErrors(Printed(FitOrDie(OnOneSetup(Sessions(kOfHead, 3)), kHead).result), kMachine);
  ASSERT_TRUE(head.ok()) << head.status();
  ASSERT_EQ(head->from.size(), 2u);
  EXPECT_EQ(head->from[0].session, "BX");
  EXPECT_EQ(head->from[0].setup, "mount");
  const auto sessions = Sessions(kOfTable, 4);
  const Result offset = FitOrDie(OnOneSetup(sessions), R"({"EX0C": 0, "EA0C": 0, "EB0C": 0})", *head).result;
  ASSERT_EQ(offset.warnings.size(), 1u);
  EXPECT_EQ(reports::InWords(offset.warnings[0]).kind, reports::WarningKind::kHeld);
  EXPECT_THAT(reports::InWords(offset.warnings[0]).text, HasSubstr("run_out_x of set-up mount"));
  EXPECT_TRUE(FitOrDie(sessions, kTable, *head).result.warnings.empty());  // mounted anew: a set-up of its own
  const Result tilts = FitOrDie(OnOneSetup({sessions[1]}), R"({"EA0C": 0, "EB0C": 0})", *head).result;
  EXPECT_TRUE(tilts.warnings.empty()) << reports::InWords(tilts.warnings[0]).text;
  // A third stage knows what the first two came from.
  EXPECT_EQ(ReadHeldErrors(Printed(offset), kMachine)->from.size(), 4u);
}

TEST(HeldErrors, ReadingsThatGaveBothStagesAreSaid) {
  const auto sessions = Sessions(kOfHead, 3);
  const auto head = ReadHeldErrors(Printed(FitOrDie(sessions, kHead).result), kMachine);
  ASSERT_TRUE(head.ok()) << head.status();
  const Result again = FitOrDie(sessions, R"({"EZ0T": 0})", *head).result;
  ASSERT_EQ(again.warnings.size(), 1u);
  EXPECT_THAT(reports::InWords(again.warnings[0]).text, HasSubstr("come from sessions that are used again (BX, BY)"));
}

TEST(HeldErrors, MonteCarloDrawsThem) {
  const Result head = FitOrDie(Sessions(kOfHead, 3), kHead).result;
  const Fit fit = FitOrDie(Sessions(kOfTable, 4), kTable, ReadHeldErrors(Printed(head), kMachine).value());
  MonteCarloOptions options;
  options.runs = 300;
  const auto result = MonteCarlo(fit, options);
  ASSERT_TRUE(result.ok()) << result.status();
  for (const Spread& spread : result->spreads) {
    EXPECT_NEAR(spread.sigma / spread.linear_sigma, 1.0, 4 * 0.04) << spread.name;
    EXPECT_NEAR(spread.mean, spread.value, 4.0 * spread.sigma / std::sqrt(300.0)) << spread.name;
  }
}

// A third stage knows how the errors of the first two go together.
TEST(HeldErrors, OfTwoStagesKeepTheirCorrelation) {
  const Result head = FitOrDie(Sessions(kOfHead, 3), kHead).result;
  Result table = FitOrDie(Sessions(kOfTable, 4), kTable, ReadHeldErrors(Printed(head), kMachine).value()).result;
  const machine::ErrorModel fitted = table.model;
  table.model.terms.insert(table.model.terms.end(), head.model.terms.begin(), head.model.terms.end());
  const auto both = ReadHeldErrors(Printed(table), kMachine);
  ASSERT_TRUE(both.ok()) << both.status();
  ASSERT_EQ(both->errors.size(), 6u);
  const auto covariance = [&](const std::string& a, const std::string& b) {
    const auto at = [&](const std::string& name) { return &Find(both->errors, name) - both->errors.data(); };
    return both->covariance(at(a), at(b));
  };
  const double tilt = Find(head.estimates, "EB0B").sigma;
  EXPECT_NEAR(covariance("EB0B", "EB0B") / (tilt * tilt), 1.0, 1e-9);
  EXPECT_NEAR(std::abs(covariance("EX0C", "EB0B")) / (356.4 * tilt * tilt), 1.0, 0.02);
  EXPECT_NEAR(covariance("EX0C", "EB0B"), covariance("EB0B", "EX0C"), 1e-18);
}

// Held errors bend the chain a little; what is degenerate at the nominal machine stays so.
TEST(HeldErrors, DoNotMakeTheInseparableSeparable) {
  const auto head = ReadHeldErrors(R"({"EA0B": 2000, "EC0B": -3000, "EB0B": 4000})", kMachine);
  const Result result = FitOrDie(Sessions(kOfTable, 1), R"({"EX0C": 0, "EX0T": 0})", *head).result;
  EXPECT_EQ(result.rank, 1);
  EXPECT_FALSE(Find(result.estimates, "EX0C").identifiable);
}

TEST(HeldErrors, RefusesWhatCannotBeHeld) {
  const auto message = [](const std::string& text) {
    const absl::Status status = ReadHeldErrors(text, kMachine).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << text;
    return std::string(status.message());
  };
  EXPECT_THAT(message("{"), HasSubstr("held errors: line 1"));
  EXPECT_THAT(message("{}"), HasSubstr("there is none in it"));
  EXPECT_THAT(message(R"({"EX0Q": 1})"), HasSubstr("EX0Q"));
  EXPECT_THAT(message(R"({"EX0C": null})"), HasSubstr("EX0C"));
  EXPECT_THAT(message(R"({"verdict": "adequate", "errors": []})"), HasSubstr("expected an errors.json"));
  const Result unclear = FitOrDie(Sessions(kOfTable, 1), R"({"EX0C": 0, "EX0T": 0})").result;
  EXPECT_THAT(message(Printed(unclear)), HasSubstr("has no value of its own"));
  const Result head = FitOrDie(Sessions(kOfHead, 3), kHead).result;
  EXPECT_THAT(message(Printed(head, "other")), HasSubstr("of machine other, expected of mt"));
}

TEST(HeldErrors, WhatIsFittedBesideThem) {
  const HeldErrors held = ReadHeldErrors(R"({"EX0C": 1.0})", kMachine).value();
  const machine::ErrorModel both = testing::Errors(kMachine, R"({"EX0C": 0, "EY0C": 0})");
  EXPECT_EQ(BesideHeld(kMachine, both, false, held)->terms.size(), 1u);
  EXPECT_THAT(std::string(BesideHeld(kMachine, both, true, held).status().message()),
              HasSubstr("EX0C is held and asked for too"));
  const machine::ErrorModel same = testing::Errors(kMachine, R"({"EX0C": 0})");
  EXPECT_THAT(std::string(BesideHeld(kMachine, same, false, held).status().message()),
              HasSubstr("nothing is left to identify"));
}

}  // namespace
}  // namespace axiscal::identify
