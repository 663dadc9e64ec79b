#include "core/machine/error_covariance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"

namespace axiscal::machine {
namespace {

using ::testing::HasSubstr;

const Machine kMachine = testing::MultiTasking();

std::string WithCovariance(const std::string& covariance) {
  return R"({"EX0C": 53.1, "EA0B": -101.2, "terms": [)"
         R"({"symbol": "EBB", "shape": "harmonic", "order": 45, "amplitude": 21.3, "phase_deg": 12},)"
         R"({"symbol": "EXX", "shape": "reversal", "length_mm": 4, "amplitude": 2}], "covariance": )" +
         covariance + "}";
}

TEST(ErrorCovariance, IsReadInMmAndRadByName) {
  const auto known = ReadKnownErrors(
      WithCovariance(R"({"of": ["EA0B", "EX0C", "EBB:harmonic(45).sin", "EXX:reversal.length"],)"
                     R"( "sigma": [2, 0.5, 3, 0.25], "correlation": [[], [0.5], [0, 0], [0, -0.1, 0]]})"),
      kMachine);
  ASSERT_TRUE(known.ok()) << known.status();
  ASSERT_EQ(known->covariance.of.size(), 4u);
  EXPECT_EQ(known->covariance.of[0].term, 1);
  EXPECT_EQ(known->covariance.of[1].term, 0);
  EXPECT_EQ(known->covariance.of[2].basis, 1);
  EXPECT_TRUE(known->covariance.of[3].is_nonlinear);
  const Eigen::MatrixXd covariance = known->covariance.root * known->covariance.root.transpose();
  EXPECT_NEAR(covariance(0, 0), 4e-12, 1e-20);
  EXPECT_NEAR(covariance(1, 1), 0.25e-6, 1e-14);
  EXPECT_NEAR(covariance(0, 1), 0.5 * 2e-6 * 0.5e-3, 1e-17);
  EXPECT_NEAR(covariance(3, 1), -0.1 * 0.25 * 0.5e-3, 1e-13);  // a length of 4 mm, in mm
  EXPECT_NEAR(covariance(2, 2), 9e-12, 1e-20);
}

// A tool that warms up at two rates: one component, one shape, two time constants.
TEST(ErrorCovariance, TwoDecaysOfOneComponentHaveNumbersOfTheirOwn) {
  const int tool = kMachine.tool_joint();
  ErrorModel model;
  model.terms = {{tool, Component::kZ, shapes::DriftExp{600.0}, {0.004}},
                 {tool, Component::kZ, shapes::DriftExp{4000.0}, {-0.003}}};
  const std::vector<std::string> numbers = {NameNumber(kMachine, model, 0, 0, false).name,
                                            NameNumber(kMachine, model, 1, 0, false).name,
                                            NameNumber(kMachine, model, 1, 0, true).name};
  EXPECT_THAT(numbers, ::testing::ElementsAre("EZT:drift-exp", "EZT:drift-exp#2", "EZT:drift-exp#2.tau"));
  WrittenCovariance written{numbers, {0.1, 0.2, 30.0}, Eigen::MatrixXd::Identity(3, 3)};
  written.correlation(1, 0) = -0.9;
  const std::string text = WriteErrors(model, kMachine, written);
  const auto known = ReadKnownErrors(text, kMachine);
  ASSERT_TRUE(known.ok()) << known.status() << text;
  ASSERT_EQ(known->covariance.of.size(), 3u);
  EXPECT_EQ(known->covariance.of[1].term, 1);
  EXPECT_TRUE(known->covariance.of[2].is_nonlinear);
  const Eigen::MatrixXd covariance = known->covariance.root * known->covariance.root.transpose();
  EXPECT_NEAR(covariance(0, 1), -0.9 * 0.1e-3 * 0.2e-3, 1e-16);
  EXPECT_NEAR(covariance(2, 2), 900.0, 1e-6);
  // The same decay twice is one too many.
  model.terms[1] = model.terms[0];
  EXPECT_THAT(std::string(ReadErrors(WriteErrors(model, kMachine), kMachine).status().message()),
              HasSubstr("EZT:drift-exp is there twice"));
}

TEST(ErrorCovariance, ComesBackAsItWasWrittenAndIsNoError) {
  const auto known =
      ReadKnownErrors(WithCovariance("{\"of\": [\"EX0C\"], \"sigma\": [1], \"correlation\": [[]]}"), kMachine);
  ASSERT_TRUE(known.ok()) << known.status();
  WrittenCovariance written{{"EX0C", "EA0B"}, {0.1, 1.0 / 3.0}, Eigen::MatrixXd::Identity(2, 2)};
  written.correlation(1, 0) = -0.123456789;
  const std::string text = WriteErrors(known->model, kMachine, written);
  const auto again = ReadKnownErrors(text, kMachine);
  ASSERT_TRUE(again.ok()) << again.status() << text;
  EXPECT_EQ(again->model.terms, ReadErrors(WriteErrors(known->model, kMachine), kMachine)->terms);
  const Eigen::MatrixXd covariance = again->covariance.root * again->covariance.root.transpose();
  EXPECT_NEAR(covariance(1, 1), 1e-12 / 9.0, 1e-20);
  EXPECT_NEAR(covariance(0, 1), -0.123456789 * 0.1e-3 * 1e-6 / 3.0, 1e-20);
  // What asks for the same errors asks for no covariance.
  const auto listed = ListErrors(text);
  ASSERT_TRUE(listed.ok()) << listed.status();
  EXPECT_EQ(listed->size(), 4u);
  EXPECT_TRUE(ReadKnownErrors(WriteErrors(known->model, kMachine), kMachine)->covariance.is_empty());
}

// A second lag that is none (tau 0) took the name, and so the place, of the first one.
TEST(ErrorCovariance, TwoLagsOfOneChannelHaveTwoNames) {
  const ErrorModel model =
      ReadErrors(R"({"terms": [{"symbol": "EZT", "shape": "thermal-lag", "tau_s": 900, "amplitude": 3},)"
                 R"( {"symbol": "EZT", "shape": "thermal-lag", "tau_s": 0, "amplitude": 1}]})",
                 kMachine)
          .value();
  EXPECT_NE(NameNumber(kMachine, model, 0, 0, false).name, NameNumber(kMachine, model, 1, 0, false).name);
}

// What is asked for again is the same curve: as many amplitudes, as far from zero beforehand.
TEST(ErrorsToAskFor, KeepPriorAndNumberOfAmplitudes) {
  const std::string text = R"({"terms": [{"symbol": "EYX", "shape": "curve", "variable": "X", "from_mm": -200,)"
                           R"( "to_mm": 300, "amplitudes": [2.1, -0.4, 0.1, 0.5], "prior_sigma": 2.8, "unit": "um"}]})";
  const auto listed = ListErrors(text);
  ASSERT_TRUE(listed.ok()) << listed.status();
  ASSERT_EQ(listed->size(), 1u);
  const auto asked = ReadAskedError(listed->front(), kMachine);
  ASSERT_TRUE(asked.ok()) << asked.status();
  ASSERT_EQ(asked->terms.size(), 1u);
  EXPECT_EQ(shapes::BasisCount(asked->terms[0].shape), 4);
  EXPECT_DOUBLE_EQ(asked->terms[0].prior_sigma, 2.8e-3);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(asked->terms[0].amplitude[k], 0.0);
}

// A fit holds local defects too, which errors.json does not: it was written so that nothing could read it.
TEST(ErrorCovariance, WithoutLocalDefectsTheFileIsReadAgain) {
  ErrorModel model = ReadErrors(R"({"EX0C": 53.1})", kMachine).value();
  const int x = FindAxis(kMachine, "X");
  model.terms.push_back({x, Component::kY, shapes::Bump{x, 100.0, 20.0}, {0.004, 0.0}});
  WrittenCovariance covariance{{"EYX:empirical", "EX0C"}, {0.5, 2.0}, Eigen::MatrixXd::Identity(2, 2)};
  const auto known = ReadKnownErrors(WriteErrors(model, kMachine, covariance), kMachine);
  ASSERT_TRUE(known.ok()) << known.status();
  ASSERT_EQ(known->model.terms.size(), 1u);
  ASSERT_EQ(known->covariance.of.size(), 1u);
  EXPECT_NEAR(known->covariance.root(0, 0), 2e-3, 1e-12);
}

TEST(ErrorCovariance, WhatIsNoneIsRefusedWithItsPlace) {
  const auto refusal = [](const std::string& covariance) {
    return std::string(ReadKnownErrors(WithCovariance(covariance), kMachine).status().message());
  };
  EXPECT_THAT(refusal("3"), HasSubstr("covariance: expected an object with of, sigma and correlation"));
  EXPECT_THAT(refusal(R"({"of": ["EX0C"], "sigma": [1], "correlation": [[]], "unit": "um"})"),
              HasSubstr("covariance: unknown field 'unit'"));
  EXPECT_THAT(refusal(R"({"of": ["EX0C"], "sigma": [1]})"), HasSubstr("'correlation' is missing"));
  EXPECT_THAT(refusal(R"({"of": ["EX0B"], "sigma": [1], "correlation": [[]]})"),
              HasSubstr("covariance.of[0]: \"EX0B\", expected the name of a number of these errors"));
  EXPECT_THAT(refusal(R"({"of": ["EX0C", "EX0C"], "sigma": [1, 1], "correlation": [[], [1]]})"),
              HasSubstr("covariance.of[1]: \"EX0C\" is there twice"));
  EXPECT_THAT(refusal(R"({"of": ["EX0C", "EA0B"], "sigma": [1], "correlation": [[], [0]]})"),
              HasSubstr("covariance.sigma: 1 entries, expected a list of 2"));
  EXPECT_THAT(refusal(R"({"of": ["EX0C"], "sigma": [-1], "correlation": [[]]})"),
              HasSubstr("covariance.sigma[0]: -1, must be >= 0"));
  EXPECT_THAT(refusal(R"({"of": ["EX0C", "EA0B"], "sigma": [1, 1], "correlation": [[1], [1, 0]]})"),
              HasSubstr("covariance.correlation[0]: expected a list of 0"));
  EXPECT_THAT(refusal(R"({"of": ["EX0C", "EA0B"], "sigma": [1, 1], "correlation": [[], [1.5]]})"),
              HasSubstr("covariance.correlation[1][0]: 1.5, expected a correlation from -1 to 1"));
  EXPECT_THAT(refusal(R"({"of": ["EX0C", "EA0B", "EBB:harmonic(45).cos"], "sigma": [1, 1, 1],)"
                      R"( "correlation": [[], [0.9], [0.9, -0.9]]})"),
              HasSubstr("covariance.correlation: its least eigenvalue is -0.8"));
}

}  // namespace
}  // namespace axiscal::machine
