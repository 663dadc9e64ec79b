#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/reports/rewrite.h"
#include "core/reports/table.h"
#include "core/reports/tool_setter.h"

namespace axiscal::reports {
namespace {

using ::testing::HasSubstr;

constexpr double kThird = 1.0 / 3.0;  // no short decimal writes it

Rewrite ARewrite() {
  Rewrite report;
  report.dialect = "haas";
  report.shifts = {{"T5", "G54", 12, 41.5, 10.0 * kThird, 7, {{"X", 10.0 * kThird}, {"B", -90.0}}}, {}};
  report.rotary_stood_deg = {{"C", 90.0}};
  report.missing = {"--offset \"G55 X=...\""};
  report.calibration = "mt v3";
  report.blocks = {10, 8, 2, 5, 1, 1};
  report.correction = {{"X", {10.0 * kThird, kThird, 8}}, {"Z", {1.0, 0.5, 8}}};
  report.error_before = {12.0, 7.0 * kThird, 8};
  report.path_before_at_most_um = 13.0;
  report.path_after_at_most_um = 0.1;
  report.orientation = Orientation{.max_rotary_correction_deg = 0.1,
                                   .correction = {{"C", {50.0 * kThird, 20.0, 8}}},
                                   .error_before = {80.0, 40.0, 8},
                                   .blocks_not_reached = 1,
                                   .not_reached = {{7, "N70 X1", "the axes cannot"}}};
  report.passed = {{3, "N30 G0 X\"\t", "G91"}};
  report.blocks.going_back = 1;
  report.ways_back = {{3, "G01 X-5.0 Z1.0", 3200.0 * kThird}};
  report.calibration_warnings = {{WarningKind::kSize, "EZ0T at 3145 um"}};
  report.calibration_causes = {{CauseKind::kNominal, "Z of tool_tip_mm", 1e6 * kThird, "add 3.1 mm"}};
  report.ranges_not_corrected = 1;
  report.not_corrected = {{3, 5, "G91"}};
  report.notes = {"line 4: tool change", "not UTF-8: \xff"};
  report.note_kinds = {{"tool-change", 4}, {"profile", std::nullopt}};
  report.source_crc32c = "00ab12ef";
  return report;
}

Table ATable() {
  Table report;
  report.format = "siemens-cec";
  report.tool_tip_mm = {0.0, -0.0, -1070.0 * kThird};
  report.reference = {{"X_mm", 0.0}, {"C_deg", 12.5}};
  report.ranges = {{"X_mm", {-300.0, 300.0}}};
  report.tables = {{.of = "X",
                    .over = {"X", "Y"},
                    .points = {31, 2},
                    .from = {-300.0, 0.0},
                    .to = {300.0, 1.0},
                    .by_sense = true,
                    .unit = "um",
                    .largest = 10.0 * kThird,
                    .left_max = 0.1,
                    .left_rms = 0.01}};
  report.along_axes = {{10.0, 5.0}, {1.0, kThird}};
  report.within_ranges = {{11.0, 6.0}, {1.5, kThird}};
  report.not_carried = {"EBX"};
  return report;
}

BeamReference AReference() {
  BeamReference report;
  report.session = "rods";
  report.reference_mm = {.stated = {}, .estimate = 100.0 * kThird, .sigma = 0.001, .identifiable = true};
  report.yaw_deg = {.stated = 0.25};
  report.rods = {{"rod-1", 5, 250.1, 1.0, 0.2, 33.3, 0.5, kNoNumber}};
  report.not_told_apart = {{.z_um = 1.0, .yaw_urad = kThird}, {.pitch_urad = 1.0}};
  report.next_measurement = RodProposal{"rod-1", {0.0, 30.0}, 0.4, 0.01, 0.02};
  return report;
}

Wear AWear() {
  Wear report;
  report.session = "curve";
  report.length_mm = 529.0 * kThird;
  report.inserts = {{.insert = 1, .identifiable = true, .wear_um = 0.0, .sigma_um = 0.0, .readings = 8},
                    {.insert = 2, .at_least_um = 9.0, .fires_first_deg = 0.0, .unseen_from_um = 5.0}};
  report.warnings = {InWords(Scatter{3.0, Scatter::About::kCutter})};
  report.readings = {{0.0, 176.0, -kThird}};
  report.next_measurement = FeedProposal{60.0, 1000.0, 30.0 * kThird};
  return report;
}

template <typename Report>
std::string Refusal(const absl::StatusOr<Report>& report) {
  return std::string(report.status().message());
}

TEST(Reports, WrittenReadAndWrittenAgainAreTheSameText) {
  for (const Rewrite& report : {ARewrite(), Rewrite{}}) {
    const auto read = ReadRewrite(ToJson(report));
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(ToJson(*read), ToJson(report));
  }
  for (const Table& report : {ATable(), Table{}}) {
    const auto read = ReadTable(ToJson(report));
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(ToJson(*read), ToJson(report));
  }
  for (const ToolSetter& report : std::vector<ToolSetter>{AReference(), BeamReference{}, AWear(), Wear{}}) {
    const auto read = ReadToolSetter(ToJson(report));
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(read->index(), report.index());
    EXPECT_EQ(ToJson(*read), ToJson(report));
  }
}

TEST(Reports, SayAllThatWasWritten) {
  const auto rewrite = ReadRewrite(ToJson(ARewrite()));
  ASSERT_TRUE(rewrite.ok()) << rewrite.status();
  EXPECT_EQ(rewrite->blocks.refused, 1);
  ASSERT_EQ(rewrite->shifts.size(), 2u);
  EXPECT_EQ(rewrite->shifts[0].line, 7);
  EXPECT_EQ(rewrite->shifts[0].at[1].second, -90.0);
  EXPECT_EQ(rewrite->rotary_stood_deg[0].first, "C");
  EXPECT_EQ(rewrite->missing, ARewrite().missing);
  EXPECT_EQ(rewrite->correction[0].second.max_um, 10.0 * kThird);
  EXPECT_EQ(rewrite->orientation->not_reached[0].block, "N70 X1");
  EXPECT_EQ(rewrite->notes[1], "not UTF-8: \xEF\xBF\xBD");
  const auto table = ReadTable(ToJson(ATable()));
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->tables[0].points[0], 31u);
  EXPECT_EQ(table->within_ranges->after.rms_um, kThird);
  EXPECT_EQ(table->ranges[0].second[1], 300.0);
  const auto reference = ReadToolSetter(ToJson(AReference()));
  ASSERT_TRUE(reference.ok()) << reference.status();
  EXPECT_EQ(std::get<BeamReference>(*reference).yaw_deg.stated, 0.25);
  EXPECT_FALSE(std::get<BeamReference>(*reference).pitch_deg.identifiable);
  EXPECT_EQ(std::get<BeamReference>(*reference).not_told_apart[0].yaw_urad, kThird);
  const auto wear = ReadToolSetter(ToJson(AWear()));
  ASSERT_TRUE(wear.ok()) << wear.status();
  EXPECT_EQ(std::get<Wear>(*wear).inserts[1].at_least_um, 9.0);
  EXPECT_EQ(std::get<Wear>(*wear).warnings[0].kind, WarningKind::kScatter);
}

TEST(Reports, DamagedTextIsRefusedWithItsPlace) {
  const std::string rewrite = ToJson(ARewrite()), table = ToJson(ATable());
  const std::string reference = ToJson(AReference()), wear = ToJson(AWear());
  for (const size_t drop : {size_t{3}, size_t{60}}) {
    const auto cut = [drop](const std::string& text) { return text.substr(0, text.size() - drop); };
    EXPECT_THAT(Refusal(ReadRewrite(cut(rewrite))), HasSubstr("report: line"));
    EXPECT_THAT(Refusal(ReadTable(cut(table))), HasSubstr("report: line"));
    EXPECT_THAT(Refusal(ReadToolSetter(cut(reference))), HasSubstr("report: line"));
    EXPECT_THAT(Refusal(ReadToolSetter(cut(wear))), HasSubstr("report: line"));
  }
  EXPECT_EQ(Refusal(ReadRewrite(R"({"tool_point_error": {"before": {"count": "8"}}})")),
            "report: tool_point_error.before.count = \"8\", expected a whole number");
  EXPECT_EQ(Refusal(ReadRewrite(R"({"passed": [{"block": "N1"}]})")), "report: passed[0].line is missing");
  EXPECT_EQ(Refusal(ReadTable(R"({"ranges": {"X_mm": 5}})")), "report: ranges.X_mm = 5, expected a list of 2 values");
  EXPECT_EQ(Refusal(ReadTable(R"({"tool_point_error": 5})")), "report: tool_point_error = 5, expected an object");
  EXPECT_EQ(Refusal(ReadToolSetter("{}")), "report: reference_mm is missing");
  EXPECT_EQ(Refusal(ReadToolSetter(R"({"inserts": [{"insert": 1}, {"insert": null}]})")),
            "report: inserts[1].insert = null, expected a whole number");
}

}  // namespace
}  // namespace axiscal::reports
