#include "core/session/validate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "core/session/read_session.h"
#include "core/session/testing/example.h"

namespace axiscal::session {
namespace {

using ::testing::HasSubstr;
using testing::kBallbar;
using testing::kTouch;

Session Ballbar() { return *ReadSessionText(kBallbar, "a"); }

std::string Problem(const Session& session) {
  const absl::Status status = Validate(session);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  return std::string(status.message());
}

TEST(Validate, WhatWasReadIsValid) {
  EXPECT_TRUE(Validate(Ballbar()).ok());
  EXPECT_TRUE(Validate(*ReadSessionText(kTouch, "a")).ok());
}

TEST(Validate, PlacesErrorsWhereTheyStandInTheFile) {
  Session session = Ballbar();
  session.columns[1].values[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(Problem(session), "line 11, column 2 (X_mm): nan, expected mm from -100000 to 100000");
  session = Ballbar();
  session.columns[0].values[2] = 0.1;
  EXPECT_THAT(Problem(session), HasSubstr("line 12, column 1 (t_s): 0.1, expected at least 0.25"));
  session = Ballbar();
  session.header[3].value = "0";
  EXPECT_THAT(Problem(session), HasSubstr("line 4: sigma_um: '0', expected"));
}

TEST(Validate, ColumnsOfUnequalLengthOrKindAreRefused) {
  Session session = Ballbar();
  session.columns[3].values.pop_back();
  EXPECT_EQ(Problem(session), "column 4 (Z_mm): 2 numbers, expected 3");
  session = Ballbar();
  session.columns[3].texts = {"a", "b", "c"};
  EXPECT_THAT(Problem(session), HasSubstr("column 4 (Z_mm): 3 numbers and cells of the other kind"));
  session = *ReadSessionText(kTouch, "a");
  session.columns.back().texts[0] = "a,b";
  EXPECT_THAT(Problem(session), HasSubstr("line 10, column 7 (feature): 'a,b', expected a name"));
}

TEST(Validate, EmptySessionsAreRefused) {
  EXPECT_THAT(Problem(Session()), HasSubstr("header key machine is missing"));
  Session session = Ballbar();
  for (Column& column : session.columns) column.values.clear();
  EXPECT_EQ(Problem(session), "no readings, expected at least one");
}

TEST(Validate, HeaderTextsThatWouldBreakAFileAreRefused) {
  for (const char* value : {"two\nlines", "\x01", " leading", "trailing ", "caf\xE9"}) {
    Session session = Ballbar();
    session.header[7].value = value;
    EXPECT_THAT(Problem(session), HasSubstr("line 8: operator: "));
  }
  Session session = Ballbar();
  session.header[7].key = "a:b";
  EXPECT_THAT(Problem(session), HasSubstr("expected '# key: value'"));
}

}  // namespace
}  // namespace axiscal::session
