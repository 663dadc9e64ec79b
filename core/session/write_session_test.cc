#include "core/session/write_session.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>

#include "core/session/read_session.h"
#include "core/session/testing/example.h"

namespace axiscal::session {
namespace {

using testing::kBallbar;
using testing::kEccentricity;
using testing::kTouch;

TEST(WriteSession, ReadsBackEqual) {
  for (const char* text : {kBallbar, kTouch}) {
    const auto session = ReadSessionText(text, "a");
    ASSERT_TRUE(session.ok());
    const auto written = WriteSession(*session);
    ASSERT_TRUE(written.ok()) << written.status();
    EXPECT_EQ(*ReadSessionText(*written, "b"), *session);
  }
}

TEST(WriteSession, EmptyCellsStayEmpty) {
  EXPECT_EQ(*WriteSession(*ReadSessionText(kEccentricity, "a")), kEccentricity);
}

TEST(WriteSession, EveryDoubleReadsBackBitEqual) {
  auto session = *ReadSessionText(kBallbar, "a");
  std::mt19937_64 random(1);  // fixed seed
  std::uniform_real_distribution<double> position(-1e5, 1e5);
  std::vector<double> values = {-0.0, 5e-324, std::numeric_limits<double>::min(), 1e5, -1e5, 0.1 + 0.2, 1.0 / 3};
  while (values.size() < 2000) values.push_back(position(random) * std::pow(10, -static_cast<int>(random() % 20)));
  for (Column& column : session.columns) column.values.assign(values.size(), 1.0);
  session.columns[1].values = values;
  const auto written = WriteSession(session);
  ASSERT_TRUE(written.ok()) << written.status();
  const auto again = ReadSessionText(*written, "b");
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(std::memcmp(again->columns[1].values.data(), values.data(), values.size() * sizeof(double)), 0);
}

TEST(WriteSession, WhatCouldNotBeReadIsNotWritten) {
  auto session = *ReadSessionText(kBallbar, "a");
  session.header[7].value = "two\nlines";
  EXPECT_EQ(WriteSession(session).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace axiscal::session
