// What the detector tells of small histories whose truth is known. How often it is right: tests/rates/drift_rates.cc.
#include "core/drift/detector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/drift/testing/histories.h"

namespace axiscal::drift {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(Detector, APerfectMachineGetsNoAlarm) {
  State state;
  std::vector<Finding> all;
  for (int week = 0; week < 200; ++week) Tell(At(week, Eigen::Vector3d(10.0, -5.0, 30.0)), &state, &all);
  // But that it scatters less than stated is told, of each error once.
  EXPECT_EQ(Only<Noise>(all).size(), all.size());
  EXPECT_EQ(all.size(), 3u);
}

TEST(Detector, TellsAStepWithItsDateErrorsAndSizes) {
  State state;
  std::vector<Finding> all;
  Machine machine(1);
  for (int week = 0; week < 90; ++week) {
    if (week == 60) machine.truth += Eigen::Vector3d(-21.0, 0.0, 36.0);  // 10 and 12 sigma
    Tell(machine.Measure(week), &state, &all);
  }
  const std::vector<StepChange> steps = Only<StepChange>(all);
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_EQ(steps[0].after, Week(59));
  EXPECT_EQ(steps[0].by, Week(60));
  EXPECT_LE(steps[0].found_at, Week(61));
  EXPECT_EQ(steps[0].word, Word::kCertain);
  ASSERT_EQ(steps[0].amounts.size(), 2u);
  for (const Amount& amount : steps[0].amounts) {
    const double truth = amount.symbol == "EX0C" ? -21.0 : 36.0;
    EXPECT_NEAR(amount.size, truth, 4.0 * amount.sigma) << amount.symbol;
    // The mean of two calibrations less that of 60; the correlation with the error that stayed makes EX0C's better.
    const double stated = amount.symbol == "EX0C" ? 2.0 * std::sqrt(0.75) : 3.0;
    EXPECT_NEAR(amount.sigma, stated * std::sqrt(0.5), 0.25 * stated) << amount.symbol;
    EXPECT_EQ(amount.unit, amount.symbol == "EX0C" ? Unit::kUm : Unit::kUrad);
  }
  EXPECT_THAT(Text(all.front()), HasSubstr("29 February 2016"));  // the jump is between 22 and 29 February
}

// Of a step of two and a half sigma of one error five or six calibrations tell what four are too few for.
TEST(Detector, ASmallStepTakesMoreCalibrations) {
  constexpr int kMachines = 100;
  int within_four = 0, within_eight = 0;
  for (int number = 0; number < kMachines; ++number) {
    State state;
    std::vector<Finding> all;
    Machine machine(1000 + number);
    for (int week = 0; week < 68; ++week) {
      if (week == 60) machine.truth(2) += 7.5;  // urad
      Tell(machine.Measure(week), &state, &all);
    }
    for (const StepChange& step : Only<StepChange>(all)) {
      if (step.is_revision || step.by < Week(59) || step.by > Week(61) || step.amounts[0].symbol != "EB0C") continue;
      within_four += step.found_at < Week(64);
      ++within_eight;
      break;
    }
  }
  // 67 and 80; where only the last four calibrations are looked at 68 and 72.
  EXPECT_GE(within_four, 60);
  EXPECT_GE(within_eight, within_four + 8);
}

TEST(Detector, ABadCalibrationThatGoesBackIsNoStep) {
  State state;
  std::vector<Finding> all;
  Machine machine(2);
  for (int week = 0; week < 90; ++week) {
    Calibration calibration = machine.Measure(week);
    if (week == 60) calibration.values[1].value += 15.0;
    Tell(calibration, &state, &all);
  }
  EXPECT_THAT(Clear(all), IsEmpty());
  const std::vector<Suspect> suspects = Only<Suspect>(all);
  ASSERT_EQ(suspects.size(), 1u);
  EXPECT_EQ(suspects[0].at, Week(60));
  EXPECT_EQ(suspects[0].amounts[0].symbol, "EY0C");
  EXPECT_NEAR(suspects[0].amounts[0].size, 15.0, 4.0);
}

TEST(Detector, AStepThatABadCalibrationMadeTooLargeIsCorrected) {
  State state;
  std::vector<Finding> all;
  Machine machine(15);
  for (int week = 0; week < 90; ++week) {
    if (week == 60) machine.truth += Eigen::Vector3d(0.0, 15.0, 0.0);
    Calibration calibration = machine.Measure(week);
    if (week == 60 || week == 61) calibration.values[1].value += 25.0;  // the same bad set-up twice
    Tell(calibration, &state, &all);
  }
  const std::vector<StepChange> steps = Only<StepChange>(all);
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_FALSE(steps[0].is_revision);
  EXPECT_NEAR(steps[0].amounts[0].size, 40.0, 4.0);
  EXPECT_TRUE(steps[1].is_revision);
  EXPECT_EQ(steps[1].by, Week(60));
  ASSERT_EQ(steps[1].amounts.size(), 1u);
  EXPECT_EQ(steps[1].amounts[0].symbol, "EY0C");
  EXPECT_NEAR(steps[1].amounts[0].size, 15.0, 4.0);
  EXPECT_THAT(Only<Retraction>(all), IsEmpty());
}

TEST(Detector, ACombinationThatNoCalibrationTellsStaysUnknown) {
  // EX0C + 2 EY0C is known, along (2, -1) nothing is: values wander there by what the fit likes.
  const Eigen::Vector3d unknown(2.0, -1.0, 0.0);
  const Eigen::MatrixXd covariance = UsualCovariance() + 1e6 * unknown * unknown.transpose();
  State state;
  std::vector<Finding> all;
  Machine machine(3);
  base::Random random(4);
  for (int week = 0; week < 90; ++week) {
    if (week == 60) machine.truth += Eigen::Vector3d(60.0, 0.0, 0.0);
    Calibration calibration = machine.Measure(week);
    const double off = 300.0 * random.Normal();
    calibration.values[0].value += off * unknown(0);
    calibration.values[1].value += off * unknown(1);
    calibration.covariance = covariance;
    Tell(calibration, &state, &all);
    if (week < 60) {
      EXPECT_THAT(Clear(all), IsEmpty()) << week;
    }
  }
  const std::vector<StepChange> steps = Clear(all);
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_EQ(steps[0].by, Week(60));
}

TEST(Detector, AStepThatGoesBackIsTakenBack) {
  State state;
  std::vector<Finding> all;
  Machine machine(14);
  for (int week = 0; week < 90; ++week) {
    Calibration calibration = machine.Measure(week);
    if (week == 60 || week == 61) calibration.values[1].value += 12.0;  // twice the same bad set-up
    Tell(calibration, &state, &all);
  }
  const std::vector<StepChange> steps = Only<StepChange>(all);
  ASSERT_EQ(steps.size(), 1u);
  const std::vector<Retraction> taken_back = Only<Retraction>(all);
  ASSERT_EQ(taken_back.size(), 1u);
  EXPECT_EQ(taken_back[0].by, Week(60));
  EXPECT_THAT(taken_back[0].symbols, ElementsAre("EY0C"));
  EXPECT_LE(taken_back[0].at, Week(64));
}

TEST(Detector, ErrorsComeAndGoWithoutAlarm) {
  State state;
  std::vector<Finding> all;
  Machine machine(5);
  for (int week = 0; week < 300; ++week) {
    Calibration calibration = machine.Measure(week);
    if (week < 40 || (week > 60 && week < 75)) {
      calibration.values.pop_back();
      calibration.covariance = Eigen::MatrixXd(calibration.covariance.topLeftCorner(2, 2));
    } else if (week > 150) {
      calibration.values.erase(calibration.values.begin());
      calibration.covariance = Eigen::MatrixXd(calibration.covariance.bottomRightCorner(2, 2));
    }
    if (week == 39) {
      EXPECT_EQ(state.errors.size(), 2u);
    }
    if (week == 100) {
      EXPECT_EQ(state.errors.size(), 3u);
    }
    Tell(calibration, &state, &all);
  }
  EXPECT_THAT(Clear(all), IsEmpty());
  EXPECT_THAT(Only<Unstable>(all), IsEmpty());
  ASSERT_EQ(state.errors.size(), 2u);  // EX0C is forgotten after two years
  EXPECT_EQ(state.errors[0].symbol, "EY0C");
  EXPECT_EQ(state.errors[1].symbol, "EB0C");
}

// The first calibration states sigmas ten times as large: what it makes of the unit must not stay in the season's
// prior, where it would swing for years.
// The error that was unseen for longest comes back with new ones: another gives way, not the one that was measured.
TEST(Detector, WhereThereAreTooManyErrorsWhatWasMeasuredStays) {
  const auto calibration = [](int week, const std::vector<std::string>& symbols) {
    Calibration out;
    out.at = Week(week);
    for (const std::string& symbol : symbols) out.values.push_back({symbol, Unit::kUm, 1.0});
    const auto count = static_cast<Eigen::Index>(symbols.size());
    out.covariance = Eigen::MatrixXd::Identity(count, count);
    return out;
  };
  std::vector<std::string> others;
  for (int i = 1; i < kMostErrors; ++i) others.push_back("B" + std::to_string(i));
  State state;
  std::vector<Finding> all;
  Tell(calibration(0, {"A"}), &state, &all);
  Tell(calibration(1, others), &state, &all);
  Tell(calibration(2, {"A", "C"}), &state, &all);
  std::vector<std::string> followed;
  for (const auto& error : state.errors) followed.push_back(error.symbol);
  EXPECT_EQ(followed.size(), static_cast<size_t>(kMostErrors));
  EXPECT_THAT(followed, ::testing::IsSupersetOf({"A", "C"}));
}

TEST(Detector, APoorFirstCalibrationLeavesNoWildSeason) {
  const Eigen::Vector3d unknown(40.0, -20.0, 30.0);
  State state;
  std::vector<Finding> all;
  Machine machine(16);
  Tell(machine.Measure(0, UsualCovariance() + unknown * unknown.transpose()), &state, &all);
  const double first_unit = state.errors[0].unit_size;
  for (int week = 1; week < 12; ++week) {
    Tell(machine.Measure(week), &state, &all);
    for (int at = 3; at < 12; ++at) EXPECT_LE(state.joint.covariance(at, at), 0.25 + 1e-9) << week;
  }
  EXPECT_LT(state.errors[0].unit_size, first_unit / 2.0);  // so the unit was another
}

TEST(Detector, AMarkEndsWhatItEnds) {
  for (const bool is_marked : {false, true}) {
    State state;
    std::vector<Finding> all;
    Machine machine(6);
    for (int week = 0; week < 120; ++week) {
      if (week == 60) {
        machine.truth += Eigen::Vector3d(50.0, -40.0, 90.0);
        if (is_marked) {
          ASSERT_TRUE(Put({Week(59) + std::chrono::days(3), MarkKind::kCollision, {}}, &state).ok());
        }
      }
      if (week == 100) machine.truth += Eigen::Vector3d(0.0, 12.0, 0.0);  // nobody marked this
      Tell(machine.Measure(week), &state, &all);
    }
    std::vector<base::UtcTime> dates;
    for (const StepChange& step : Only<StepChange>(all)) dates.push_back(step.by);
    if (is_marked) {
      EXPECT_THAT(dates, ElementsAre(Week(100)));
      EXPECT_EQ(Only<Suspect>(all).size(), 1u);  // the first calibration after the one that nobody marked
    } else {
      EXPECT_THAT(dates, ElementsAre(Week(60), Week(100)));
    }
  }
}

TEST(Detector, AMarkOfOneErrorLeavesTheOthers) {
  State state;
  std::vector<Finding> all;
  Machine machine(7);
  for (int week = 0; week < 90; ++week) {
    if (week == 60) {
      machine.truth += Eigen::Vector3d(0.0, 15.0, 60.0);
      ASSERT_TRUE(Put({Week(59), MarkKind::kRefixturing, {"EB0C", "EX0T"}}, &state).ok());
    }
    Tell(machine.Measure(week), &state, &all);
  }
  const std::vector<StepChange> steps = Only<StepChange>(all);
  ASSERT_EQ(steps.size(), 1u);
  ASSERT_EQ(steps[0].amounts.size(), 1u);
  EXPECT_EQ(steps[0].amounts[0].symbol, "EY0C");
}

TEST(Detector, ASeasonIsNotClaimedBeforeTwoCycles) {
  State state;
  std::vector<Finding> all;
  Machine machine(8);
  for (int week = 0; week < 260; ++week) {
    Calibration calibration = machine.Measure(week);
    calibration.values[2].value += 6.0 * std::sin(2.0 * std::numbers::pi * week / 52.1775);
    Tell(calibration, &state, &all);
    if (week < 104) {
      EXPECT_THAT(Only<Season>(all), IsEmpty());
    }
  }
  const std::vector<Season> seasons = Only<Season>(all);
  ASSERT_EQ(seasons.size(), 1u);
  EXPECT_EQ(seasons[0].amplitude.symbol, "EB0C");
  EXPECT_NEAR(seasons[0].amplitude.size, 6.0, 4.0 * seasons[0].amplitude.sigma);
  EXPECT_FALSE(seasons[0].per_kelvin.has_value());
  EXPECT_THAT(Clear(all), IsEmpty());
}

TEST(Detector, WearIsTold) {
  State state;
  std::vector<Finding> all;
  Machine machine(9);
  for (int week = 0; week < 160; ++week) {
    machine.truth(0) -= 8.0 / 52.1775;  // um a week
    Tell(machine.Measure(week), &state, &all);
  }
  const std::vector<Slope> slopes = Only<Slope>(all);
  ASSERT_EQ(slopes.size(), 1u);
  EXPECT_EQ(slopes[0].per_year.symbol, "EX0C");
  EXPECT_NEAR(slopes[0].per_year.size, -8.0, 4.0 * slopes[0].per_year.sigma);
  EXPECT_THAT(Clear(all), IsEmpty());
}

TEST(Detector, ScatterBeyondWhatIsStatedIsTold) {
  State state;
  std::vector<Finding> all;
  Machine machine(10);
  for (int week = 0; week < 160; ++week) {
    Calibration calibration = machine.Measure(week, 4.0 * UsualCovariance());
    calibration.covariance = UsualCovariance();
    Tell(calibration, &state, &all);
  }
  std::vector<std::string> noisy;
  for (const Noise& noise : Only<Noise>(all)) {
    EXPECT_NEAR(noise.factor, 1.7, 0.4);
    noisy.push_back(noise.symbol);
  }
  EXPECT_THAT(noisy, ::testing::UnorderedElementsAre("EX0C", "EY0C", "EB0C"));
  EXPECT_THAT(Clear(all), IsEmpty());
}

TEST(Detector, WhatAgreesWithNothingIsUnstable) {
  State state;
  std::vector<Finding> all;
  Machine machine(11);
  for (int week = 0; week < 60; ++week) Tell(machine.Measure(week), &state, &all);
  EXPECT_THAT(all, IsEmpty());
  double off = 60.0;
  for (int week = 60; week < 66; ++week) {
    off = -1.5 * off;
    Calibration calibration = machine.Measure(week);
    for (Value& value : calibration.values) value.value += off;
    Tell(calibration, &state, &all);
  }
  const std::vector<Unstable> unstable = Only<Unstable>(all);
  ASSERT_EQ(unstable.size(), 1u);
  EXPECT_EQ(unstable[0].since, Week(60));
  EXPECT_EQ(unstable[0].at, Week(65));
}

TEST(Detector, SignsAndUnitsDoNotMatter) {
  // Minus everything, and one error in a unit a thousand times as small.
  State state, mirrored;
  std::vector<Finding> all, all_mirrored;
  Machine machine(12);
  const Eigen::Vector3d factors(-1000.0, -1.0, -1.0);
  for (int week = 0; week < 90; ++week) {
    if (week == 50) machine.truth += Eigen::Vector3d(14.0, -9.0, 0.0);
    const Calibration calibration = machine.Measure(week);
    Tell(calibration, &state, &all);
    Calibration other = calibration;
    for (int j = 0; j < 3; ++j) other.values[j].value *= factors(j);
    other.covariance = factors.asDiagonal() * calibration.covariance * factors.asDiagonal();
    Tell(other, &mirrored, &all_mirrored);
  }
  const std::vector<StepChange> steps = Only<StepChange>(all), steps_mirrored = Only<StepChange>(all_mirrored);
  ASSERT_EQ(steps.size(), 1u);
  ASSERT_EQ(steps_mirrored.size(), 1u);
  EXPECT_NEAR(steps[0].score, steps_mirrored[0].score, 1e-6);
  ASSERT_EQ(steps[0].amounts.size(), steps_mirrored[0].amounts.size());
  for (size_t i = 0; i < steps[0].amounts.size(); ++i) {
    const double factor = steps[0].amounts[i].symbol == "EX0C" ? -1000.0 : -1.0;
    EXPECT_NEAR(factor * steps[0].amounts[i].size, steps_mirrored[0].amounts[i].size, 1e-6 * std::abs(factor));
  }
}

TEST(Detector, RefusesWhatItCannotUseAndStaysAsItWas) {
  State state;
  std::vector<Finding> all;
  Machine machine(13);
  for (int week = 0; week < 10; ++week) Tell(machine.Measure(week), &state, &all);
  ASSERT_TRUE(Put({Week(9), MarkKind::kService, {}}, &state).ok());
  const std::string before = WriteState(state);
  const auto refused = [&](const Calibration& calibration, absl::StatusCode code, const std::string& what) {
    const auto findings = Advance(calibration, &state);
    EXPECT_EQ(findings.status().code(), code);
    EXPECT_THAT(std::string(findings.status().message()), HasSubstr(what));
    EXPECT_EQ(WriteState(state), before);
  };
  refused(machine.Measure(9), absl::StatusCode::kFailedPrecondition, "must be later than the last one");
  Calibration calibration = machine.Measure(10);
  calibration.values[2].unit = Unit::kUm;
  refused(calibration, absl::StatusCode::kInvalidArgument, "unit of EB0C = um, was urad before");
  calibration = machine.Measure(10);
  calibration.values[1].value = NAN;
  refused(calibration, absl::StatusCode::kInvalidArgument, "value of EY0C = nan");
  calibration.values[1].value = -1e200;  // its square would be no number, and nor would all that follows
  refused(calibration, absl::StatusCode::kInvalidArgument, "value of EY0C = -1e+200");
  calibration = machine.Measure(10);
  calibration.covariance(2, 2) = 1e-300;
  refused(calibration, absl::StatusCode::kInvalidArgument, "variance of EB0C = 1e-300");
  calibration = machine.Measure(10);
  calibration.values[1].symbol = "EX0C";
  refused(calibration, absl::StatusCode::kInvalidArgument, "values[1].symbol: 'EX0C' is there twice");
  calibration = machine.Measure(10);
  calibration.covariance(1, 1) = 0.0;
  refused(calibration, absl::StatusCode::kInvalidArgument, "variance of EY0C = 0, must be > 0");
  calibration = machine.Measure(10);
  calibration.covariance(0, 1) = calibration.covariance(1, 0) = 2.5;
  refused(calibration, absl::StatusCode::kInvalidArgument, "covariance of EX0C and EY0C = 2.5");
  calibration = machine.Measure(10);
  calibration.covariance.conservativeResize(2, 2);
  refused(calibration, absl::StatusCode::kInvalidArgument, "covariance has 2 x 2 numbers, expected 3 x 3");
  calibration = machine.Measure(10);
  calibration.temperature_celsius = 300.0;
  refused(calibration, absl::StatusCode::kInvalidArgument, "temperature_celsius = 300");
  calibration = machine.Measure(10);
  calibration.values.clear();
  refused(calibration, absl::StatusCode::kInvalidArgument, "values: none");
  // Pairs that are possible one by one and not together.
  calibration = machine.Measure(10);
  calibration.covariance = Eigen::MatrixXd{{1.0, 0.9, 0.9}, {0.9, 1.0, -0.9}, {0.9, -0.9, 1.0}};
  refused(calibration, absl::StatusCode::kInvalidArgument, "an eigenvalue of its correlations");
  EXPECT_EQ(Put({Week(8), MarkKind::kService, {}}, &state).code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(WriteState(state), before);
}

}  // namespace
}  // namespace axiscal::drift
