// States as bytes: the same ones again, and the detector goes on from them as if nothing had been.
#include "core/drift/state.h"

#include <gtest/gtest.h>

#include "core/drift/testing/histories.h"

namespace axiscal::drift {
namespace {

TEST(State, RoundTripAtEveryCalibration) {
  State straight, read;
  std::vector<Finding> all, all_read;
  Machine machine(21);
  for (int week = 0; week < 130; ++week) {
    if (week == 45) machine.truth += Eigen::Vector3d(0.0, 12.0, -40.0);
    if (week == 80) {
      machine.truth += Eigen::Vector3d(30.0, 0.0, 0.0);
      const Mark mark{Week(79) + std::chrono::hours(1), MarkKind::kService, {"EX0C"}};
      ASSERT_TRUE(Put(mark, &straight).ok());
      ASSERT_TRUE(Put(mark, &read).ok());
    }
    Calibration calibration = machine.Measure(week);
    if (week % 7 == 3) calibration.values[0].value += 25.0;  // suspects
    if (week % 5 == 4) calibration.temperature_celsius = 20.0 + week % 3;
    if (week < 20) {
      calibration.values.pop_back();
      calibration.covariance = Eigen::MatrixXd(calibration.covariance.topLeftCorner(2, 2));
    }
    Tell(calibration, &straight, &all);
    Tell(calibration, &read, &all_read);
    const std::string bytes = WriteState(straight);
    const auto again = ReadState(bytes);
    ASSERT_TRUE(again.ok()) << again.status();
    EXPECT_EQ(WriteState(*again), bytes);
    EXPECT_EQ(WriteState(read), bytes);
    read = *again;
  }
  ASSERT_EQ(all.size(), all_read.size());
  for (size_t i = 0; i < all.size(); ++i) EXPECT_EQ(Text(all[i]), Text(all_read[i]));
  EXPECT_FALSE(Only<StepChange>(all).empty());
  EXPECT_FALSE(Only<Suspect>(all).empty());
}

TEST(State, DoesNotGrowWithTheHistory) {
  State state;
  std::vector<Finding> all;
  Machine machine(22);
  size_t after_a_year = 0;
  for (int week = 0; week < 500; ++week) {
    Tell(machine.Measure(week), &state, &all);
    if (week == 51) after_a_year = WriteState(state).size();
  }
  EXPECT_EQ(WriteState(state).size(), after_a_year);
}

TEST(State, AnEmptyOneIsAState) {
  const auto read = ReadState(WriteState(State()));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->calibrations, 0);
}

TEST(State, DamageIsRefused) {
  State state;
  std::vector<Finding> all;
  Machine machine(23);
  for (int week = 0; week < 8; ++week) Tell(machine.Measure(week), &state, &all);
  const std::string bytes = WriteState(state);
  for (const size_t size : {size_t{0}, size_t{5}, size_t{12}, bytes.size() / 2, bytes.size() - 1})
    EXPECT_EQ(ReadState(bytes.substr(0, size)).status().code(), absl::StatusCode::kDataLoss) << size;
  EXPECT_EQ(ReadState(bytes + "x").status().code(), absl::StatusCode::kDataLoss);
  for (size_t at = 0; at < bytes.size(); at += 997) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 0x10);
    EXPECT_EQ(ReadState(changed).status().code(), absl::StatusCode::kDataLoss) << at;
  }
}

}  // namespace
}  // namespace axiscal::drift
