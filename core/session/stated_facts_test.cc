#include "core/session/stated_facts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/session/read_session.h"
#include "core/session/testing/example.h"
#include "core/session/text.h"
#include "core/session/validate.h"

namespace axiscal::session {
namespace {

using ::testing::HasSubstr;
using testing::kBallbar;
using testing::kTouch;

std::string Problem(const char* text, const std::string& key, const std::string& value) {
  Session session = *ReadSessionText(text, "a");
  session.header.push_back({key, value});
  return std::string(Validate(session).message());
}

TEST(StatedFacts, AnExpansionInItsUnits) {
  const auto bar = ParseExpansion({"expansion bar", "11.5 0.5"});
  ASSERT_TRUE(bar.ok()) << bar.status();
  EXPECT_EQ(bar->of, "bar");
  EXPECT_DOUBLE_EQ(bar->per_kelvin, 11.5e-6);
  EXPECT_DOUBLE_EQ(bar->sigma_per_kelvin, 0.5e-6);
  EXPECT_EQ(bar->column, "temp_C");
  EXPECT_EQ(bar->text(), "expansion of bar, 11.5 +- 0.5 um/(m K)");
  const auto scale = ParseExpansion({"expansion scale X2", "8 0 T_X2-scale_C"});
  ASSERT_TRUE(scale.ok()) << scale.status();
  EXPECT_EQ(scale->axis, "X2");
  EXPECT_EQ(scale->column, "T_X2-scale_C");
  EXPECT_EQ(scale->text(), "expansion of scale X2, 8 +- 0 um/(m K)");
}

TEST(StatedFacts, AnExpansionPerKelvinAloneIsRefused) {
  for (const char* value : {"11.5e-6 0.5e-6", "-2e-7 0"}) {
    const std::string message(ParseExpansion({"expansion bar", value}).status().message());
    EXPECT_NE(message.find("at least 0.001 in size"), std::string::npos) << message;
  }
  EXPECT_TRUE(ParseExpansion({"expansion bar", "0 0.02"}).ok());
  EXPECT_TRUE(ParseExpansion({"expansion bar", "0.02 0.02"}).ok());
}

// U = 0.8 um at k = 2 is a standard uncertainty of 0.4 um; a certificate is valid on its last day.
TEST(StatedFacts, ACertificateInItsUnits) {
  const auto bar =
      ParseCertificate({"certificate bar_length", "D-K-4711 due 2027-01-31 value 149.9987 mm U 0.8 um k 2"});
  ASSERT_TRUE(bar.ok()) << bar.status();
  EXPECT_EQ(bar->number, "D-K-4711");
  EXPECT_DOUBLE_EQ(bar->value->value, 149.9987);
  EXPECT_DOUBLE_EQ(bar->value->sigma, 0.4e-3);
  EXPECT_LT(*ParseIso8601("2027-01-31T23:59:59Z"), bar->valid_until);
  EXPECT_GE(*ParseIso8601("2027-02-01"), bar->valid_until);
  const auto scale = ParseCertificate({"certificate scale", "7 due 2027-01-31 value -12 um/m U 3 um/m k 2"});
  ASSERT_TRUE(scale.ok()) << scale.status();
  EXPECT_DOUBLE_EQ(scale->value->value, -12e-6);
  EXPECT_DOUBLE_EQ(scale->value->sigma, 1.5e-6);
  EXPECT_FALSE(ParseCertificate({"certificate thermometer", "7 due 2027-01-31"})->value.has_value());
}

TEST(StatedFacts, WhatIsWrongIsRefusedWithItsLine) {
  EXPECT_EQ(Problem(kBallbar, "expansion bar", "11.5 0.5"), "");
  EXPECT_EQ(Problem(kBallbar, "temperature_sigma_K", "0.2"), "");
  const std::string line = absl::StrCat("line ", ReadSessionText(kBallbar, "a")->header.size() + 1, ": ");
  EXPECT_THAT(Problem(kBallbar, "expansion bar", "11.5"), HasSubstr(line + "expansion bar: '11.5', expected a coeff"));
  EXPECT_THAT(Problem(kBallbar, "expansion bar", "0.0000115 1 2 3"), HasSubstr("expected a coefficient"));
  EXPECT_THAT(Problem(kBallbar, "expansion bar", "11500 1"), HasSubstr("from -20 to 300"));
  EXPECT_THAT(Problem(kBallbar, "expansion bar", "11.5 -1"), HasSubstr("standard uncertainty from 0 to 50"));
  EXPECT_THAT(Problem(kBallbar, "expansion bar", "11.5 1 X_mm"), HasSubstr("column of its temperature"));
  EXPECT_THAT(Problem(kBallbar, "expansion wall", "11.5 1"), HasSubstr("expected 'expansion' and one of bar"));
  EXPECT_THAT(Problem(kBallbar, "expansion scale", "11.5 1"), HasSubstr("or 'scale' and an axis"));
  EXPECT_THAT(Problem(kTouch, "expansion bar", "11.5 1"),
              HasSubstr("expansion bar: is of instrument ballbar, this session's is touch"));
  EXPECT_EQ(Problem(kTouch, "expansion artefact", "11.5 1"), "");
  EXPECT_THAT(Problem(kBallbar, "Expansion bar", "11.5 1"), HasSubstr("expected 'expansion' in small letters"));
  EXPECT_THAT(Problem(kBallbar, "certificate", "7 due 2027-01-31"), HasSubstr("expected 'certificate'"));
  Session twice = *ReadSessionText(kBallbar, "a");
  twice.header.push_back({"expansion bar", "11.5 1"});
  twice.header.push_back({"expansion  bar", "11.5 1"});
  EXPECT_THAT(std::string(Validate(twice).message()), HasSubstr("stands in line"));
  EXPECT_THAT(Problem(kBallbar, "temperature_sigma_K", "0"), HasSubstr("expected one number above 0 up to 10"));
  EXPECT_THAT(Problem(kBallbar, "certificate bar_length", "4711"), HasSubstr("expected 'NUMBER due DATE'"));
  EXPECT_THAT(Problem(kBallbar, "certificate bar_length", "4711 due 31.1.2027"), HasSubstr("the date as 2027-01-31"));
  EXPECT_THAT(Problem(kBallbar, "certificate bar_length", "4711 due 2027-02-30"), HasSubstr("the date as"));
  EXPECT_THAT(Problem(kBallbar, "certificate bar_length", "7 due 2027-01-31 value 150 m U 0.8 um k 2"),
              HasSubstr("'NUMBER due DATE value V mm U EXPANDED um k FACTOR'"));
  EXPECT_THAT(Problem(kBallbar, "certificate bar_length", "7 due 2027-01-31 value 0.15 mm U 0.8 um k 2"),
              HasSubstr("a value from 10 to 5000 mm"));
  EXPECT_THAT(Problem(kBallbar, "certificate bar_length", "7 due 2027-01-31 value 150 mm U 0 um k 2"),
              HasSubstr("U > 0 and a coverage factor"));
  EXPECT_THAT(Problem(kTouch, "certificate bar_length", "7 due 2027-01-31 value 150 mm U 0.8 um k 2"),
              HasSubstr("a value of bar_length is of instrument ballbar, this session's is touch"));
  EXPECT_THAT(Problem(kBallbar, "certificate ball", "7 due 2027-01-31 value 25 mm U 0.8 um k 2"),
              HasSubstr("only those of bar_length and scale are used"));
  EXPECT_EQ(Problem(kTouch, "certificate ball", "7 due 2027-01-31"), "");
}

TEST(StatedFacts, OnceAndNotBothOfScaleAndWorkpiece) {
  Session session = *ReadSessionText(kBallbar, "a");
  session.header.push_back({"expansion scale X", "8 1"});
  EXPECT_TRUE(Validate(session).ok()) << Validate(session);
  session.header.push_back({"expansion workpiece", "8 1"});
  EXPECT_THAT(std::string(Validate(session).message()), HasSubstr("expected only one of both"));
  session.header.back() = {"expansion scale X", "9 1"};
  EXPECT_THAT(std::string(Validate(session).message()), HasSubstr("already, expected once"));
}

}  // namespace
}  // namespace axiscal::session
