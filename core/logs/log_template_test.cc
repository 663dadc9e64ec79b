#include "core/logs/log_template.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace axiscal::logs {
namespace {

using ::testing::HasSubstr;

constexpr char kHeader[] =
    "# machine: mt\n# session: log\n# instrument: touch\n# sigma_um: 1.5\n# tool_tip_mm: 0 0 0\n"
    "# stylus_radius_mm: 2.9106\n# sphere ball: -390 0 -472 5\n";

std::string Refusal(const std::string& text) {
  const auto parsed = ParseTemplate(text, "t.txt");
  return parsed.ok() ? "accepted" : std::string(parsed.status().message());
}

TEST(LogTemplate, HeaderAndRulesAreRead) {
  const auto parsed = ParseTemplate(absl::StrCat(kHeader,
                                                 "\n; the probing program of the ball\nline: X{X_mm} Y{Y_mm}\r\n"
                                                 "skip: Feature {*}\nskip: O{*}\ncount: Number of Points {count}\n"
                                                 "axis: X 25.4 -390\nfeature: ball\napproach: feature\nseconds: 6\n"),
                                    "t.txt");
  ASSERT_TRUE(parsed.ok()) << parsed.status();
  EXPECT_EQ(parsed->header.size(), 7u);
  EXPECT_EQ(parsed->header[6].key, "sphere ball");
  EXPECT_TRUE(parsed->line->is_any_order);
  EXPECT_EQ(parsed->skip.size(), 2u);
  EXPECT_TRUE(parsed->count.has_value());
  EXPECT_EQ(parsed->scales.at("X").scale, 25.4);
  EXPECT_EQ(parsed->scales.at("X").offset, -390.0);
  EXPECT_EQ(parsed->feature, "ball");
  EXPECT_TRUE(parsed->approach_is_feature);
  EXPECT_EQ(parsed->seconds, 6.0);
}

TEST(LogTemplate, WhatBreaksARuleIsNamedWithItsLine) {
  const std::string header = kHeader;
  EXPECT_THAT(Refusal(header), HasSubstr("t.txt: expected either 'line: ...' or 'format: ...'"));
  EXPECT_THAT(Refusal(header + "line: X{X_mm}\nformat: dprnt\n"), HasSubstr("expected either"));
  EXPECT_THAT(Refusal(header + "lines: X{X_mm}\n"), HasSubstr("t.txt: line 8: lines: is no rule, expected format"));
  EXPECT_THAT(Refusal(header + "line: X{X_mm\n"), HasSubstr("line 8: line: 'X{X_mm': a '{' without '}'"));
  EXPECT_THAT(Refusal(header + "line: X{X_mm}\nline: Y{Y_mm}\n"), HasSubstr("line 9: line is said twice"));
  EXPECT_THAT(Refusal(header + "line: %\n"), HasSubstr("has no field"));
  EXPECT_THAT(Refusal(header + "format: heidenhain\n"),
              HasSubstr("'heidenhain', expected dprnt, linuxcnc-probe or sinumerik-write"));
  EXPECT_THAT(Refusal(header + "count: Points\n"), HasSubstr("expected a field {count}"));
  EXPECT_THAT(Refusal(header + "approach: 1 1 0\n"), HasSubstr("expected 'feature' or a unit vector"));
  EXPECT_THAT(Refusal(header + "axis: X 0 1\n"), HasSubstr("a scale other than 0"));
  EXPECT_THAT(Refusal(header + "decimal: ;\n"), HasSubstr("line 8: decimal: ';', expected . or ,"));
  EXPECT_THAT(Refusal(header + "time: now\n"), HasSubstr("expected a form such as %d.%m.%Y %H:%M:%S"));
  EXPECT_THAT(Refusal(header + "line: X{X_mm}\ntime: %H:%M:%S\n"), HasSubstr("expected a field {t_s}"));
  EXPECT_THAT(Refusal(header + "seconds: -1\n"), HasSubstr("expected seconds above 0"));
  EXPECT_THAT(Refusal("format: dprnt\n" + header),
              HasSubstr("t.txt: line 2: header lines '# machine: ...' stand first"));
  EXPECT_THAT(Refusal("# machine: mt\nformat: dprnt\n"), HasSubstr("header key session is missing"));
  EXPECT_THAT(Refusal(header + "line\n"), HasSubstr("expected '# key: value' or 'rule: value'"));
  EXPECT_FALSE(FindFormat("fanuc").ok());
  for (const std::string& name : KnownFormats()) EXPECT_TRUE(FindFormat(name).ok()) << name;
}

}  // namespace
}  // namespace axiscal::logs
