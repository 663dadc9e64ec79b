// Reports as messages: every member that the JSON has is a field, and says the same.
#include "proto/convert/report.h"

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "core/records/job_params.h"
#include "core/reports/identification.h"
#include "core/reports/loop.h"
#include "core/reports/rewrite.h"
#include "core/reports/tool_setter.h"

namespace axiscal::convert {
namespace {

using google::protobuf::util::JsonStringToMessage;
using reports::kNoNumber;

reports::Fitted Everything() {
  reports::Fitted fitted;
  fitted.errors = {{"EX0C", "EX0C", 12.5, 0.5, "um", true},
                   {"EBB", "EBB:harmonic(45).cos", kNoNumber, kNoNumber, "urad", false}};
  fitted.coverage_factor = 2.0;
  fitted.not_separable = {"EX0B - EX0C"};
  fitted.determined = {{"EX0B + EX0C", 7.0, 0.1, "um"}};
  fitted.warnings = {{reports::WarningKind::kScatter, "it scatters", "sie streuen"}};
  fitted.outliers = {{"BX", 3, 0, 4.0, std::nullopt}, {"BX", 4, 1, 5.0, reports::Gate{"sphere", 9.0, 3.0}}};
  fitted.sessions = {{{"BX", "mount"}, 720, 0.3, 1.0, {{"ball_x", {1.5, 0.1, "um"}}}}};
  fitted.stated = {{"expansion bar", {{"EX0C", 0.25}}}};
  fitted.budget_json = R"({"sources": [{"name": "ball", "sigma": 0.5}]})";
  fitted.monte_carlo = reports::MonteCarlo{100, 1, uint64_t{1} << 63, {{"EX0C", 1, 2, 3, 4, 5, 6, "um"}}, {{1.0}}};
  return fitted;
}

reports::Identification AnIdentification() {
  reports::Identification report;
  report.fitted = Everything();
  report.rank = 1;
  report.condition = 12.0;
  report.nominal = report.fit = {1.0, 2.0, 0.9, 1.1, 720, 700};
  report.before = reports::Statistics{.rms_um = 20.0, .max_um = 70.0};
  report.correlation = {{1.0, kNoNumber}, {kNoNumber, 1.0}};
  report.held = reports::Held{{{"EA0B", "EA0B", 82.1, kNoNumber, "urad"}}, {{0.1, 1.0}}, {{"H1", "head"}}};
  report.iterations = 7;
  return report;
}

reports::Loop ALoop() {
  reports::Loop report;
  report.verdict = reports::Verdict::kUnexplained;
  report.fitted = Everything();
  reports::Effect effect{.amplitude = 7.0, .amplitude_sigma = 0.1, .unit = "urad", .phase_deg = 12.0};
  machine::WrittenTerm& term = effect.is.term;
  effect.is.name = "EBB:harmonic(45)";
  term.symbol = "EBB";
  term.shape = "harmonic";
  term.variable = "B";
  term.at = 1;
  term.over = "A";
  term.over_at = 2;
  term.order = 45;
  term.period_mm = term.length_deg = term.length_mm = term.tau_s = 3;
  term.channel = "T_table";
  term.from_mm = term.to_mm = term.from_deg = term.to_deg = term.from_s = term.to_s = 4;
  term.from_celsius = term.to_celsius = term.over_from_mm = term.over_to_mm = term.over_from_deg = term.over_to_deg = 5;
  effect.alias_orders = {315};
  effect.equivalent = {effect.is};
  effect.same_always = {"lobe(3)"};
  report.effects = {effect};
  report.causes = {{reports::CauseKind::kInstrument, "ball bar", 50.0, "0.1 %", "Messgerät", "0,1 %"}};
  report.held_back = {{reports::HeldBackKind::kUndecided, "EBB:harmonic(45)", 50.0, 0.1, "a circle"}};
  report.check = reports::Check{{.rms_um = 1.0}, {.rms_um = 0.5}, true};
  report.volumetric =
      reports::Volumetric{{{"X", -100, 200, "mm"}}, 400, {3, 2, 4}, {2, 1, 3}, {1, 0, 2}, true, {"a"}, {"b"}, {"c"}};
  report.steps = {{reports::Change::kRefused, "EXX:backlash", 1.1}};
  report.unexplained = {
      {reports::PartKind::kSlip, "t", 10, 20, "s", "BX", 2.0,
       reports::Slip{
           reports::Carrier::kTool, reports::Carrier::kTable, {3.0, kNoNumber, -1.2}, {0.1, kNoNumber, 0.1}}}};
  report.next_measurement = {{"EBB",
                              {"a"},
                              reports::ProposedTest{"N1", "ballbar-tilted", "a circle", 0.9, 0.1, 50, true, "beyond B"},
                              {"c"},
                              {"d"}},
                             {"EXX", {}, std::nullopt, {}, {}}};
  report.noise = {{"BX", 0.3, 0.31, 0.5}};
  report.withdrawn = {"EYY:linear"};
  report.not_visible = {effect.is};
  report.axes_at_rest = {"A"};
  report.stopped_early = true;
  report.candidates = 4321;
  return report;
}

reports::Rewrite ARewrite() {
  reports::Rewrite report;
  report.calibration = "mt v3";
  report.dialect = "haas";
  report.blocks = {10, 8, 2, 5, 1, 1, 1};
  report.calibration_warnings = {{reports::WarningKind::kOther, "x", "y"}};
  report.calibration_causes = {{reports::CauseKind::kNominal, "the tool", 9.0, "add"}};
  report.ways_back = {{7, "G01 X1", 12.5}};
  report.note_kinds = {{"profile", 7}};
  report.correction = {{"X", {10.0, 5.0, 8}}};
  report.shifts = {{"T5", "G54", 12, 41.5, 10.0, 7, {{"X", 10.0}}}};
  report.rotary_stood_deg = {{"C", 90.0}};
  report.missing = {"--offset"};
  report.orientation = reports::Orientation{.max_rotary_correction_deg = 0.1,
                                            .correction = {{"C", {50, 20, 8}}},
                                            .blocks_not_reached = 1,
                                            .not_reached = {{7, "N70", "cannot"}}};
  report.holes = report.contours = reports::Leftovers{3, 0.5, 1, {{9, "N90", "leans"}}};
  report.positions = {{"X", -10.0, 20.0, "mm"}};
  report.path = {{3, 5, 12.5, {{"X", {-1.0, 2.0}}}, 9.0, 0.1}};
  report.passed = report.refused = {{3, "N30", "G91"}};
  report.ranges_not_corrected = 1;
  report.not_corrected = {{3, 5, "G91"}};
  report.notes = {"a"};
  report.source_crc32c = "00ab12ef";
  return report;
}

reports::BeamReference ABeam() {
  reports::BeamReference report;
  report.session = "rods";
  report.reference_mm = {.stated = {}, .estimate = 100.0, .sigma = 0.001, .identifiable = true};
  report.yaw_deg = {.stated = 0.25};
  report.warnings = {{reports::WarningKind::kOther, "x"}};
  report.rods = {{"rod-1", 5, 250.1, 1.0, 0.2, 33.3, 0.5, kNoNumber}};
  report.not_told_apart = {{.z_um = 1.0, .yaw_urad = 2.0, .pitch_urad = 3.0}};
  report.next_measurement = reports::RodProposal{"rod-1", {0.0, 30.0}, 0.4, 0.01, 0.02};
  return report;
}

reports::Wear AWear() {
  reports::Wear report;
  report.session = "curve";
  report.inserts = {{.insert = 2, .at_least_um = 9.0, .fires_first_deg = 0.0, .unseen_from_um = 5.0}};
  report.readings = {{0.0, 176.0, -1.0}};
  report.next_measurement = reports::FeedProposal{60.0, 1000.0, 30.0};
  return report;
}

// Unknown members are errors here: the messages have all that is written.
template <typename Message, typename Report>
Message Strictly(const Report& report) {
  Message message;
  const auto status = JsonStringToMessage(reports::ToJson(report), &message);
  EXPECT_TRUE(status.ok()) << status.ToString() << "\n" << reports::ToJson(report);
  return message;
}

TEST(Reports, HaveAFieldForEveryMember) {
  Strictly<v1::IdentificationReport>(AnIdentification());
  Strictly<v1::LoopReport>(ALoop());
  Strictly<v1::RewriteReport>(ARewrite());
  Strictly<v1::BeamReport>(ABeam());
  Strictly<v1::WearReport>(AWear());
}

TEST(Reports, SayWhatTheTextSays) {
  const auto read = ReportFromJson(records::kIdentify, reports::ToJson(AnIdentification()));
  ASSERT_TRUE(read.ok()) << read.status();
  const v1::IdentificationReport& report = read->identification();
  EXPECT_EQ(report.errors(0).value(), 12.5);
  EXPECT_FALSE(report.errors(0).has_name());
  EXPECT_EQ(report.errors(1).name(), "EBB:harmonic(45).cos");
  EXPECT_FALSE(report.errors(1).has_value());  // no number is none, not zero
  EXPECT_EQ(report.sessions(0).setup().at("ball_x").value(), 1.5);
  EXPECT_EQ(report.sessions(0).shared_setup(), "mount");
  EXPECT_EQ(report.outliers(1).gate(), "sphere");
  EXPECT_EQ(report.monte_carlo().seed(), uint64_t{1} << 63);
  EXPECT_EQ(report.correlation(0).values(0).number_value(), 1.0);
  EXPECT_EQ(report.correlation(0).values(1).kind_case(), google::protobuf::Value::kNullValue);
  EXPECT_EQ(report.stated(0).moves().at("EX0C"), 0.25);
  const auto loop = ReportFromJson(records::kCloseLoop, reports::ToJson(ALoop()));
  ASSERT_TRUE(loop.ok()) << loop.status();
  EXPECT_EQ(loop->loop().verdict(), "unexplained");
  EXPECT_EQ(loop->loop().effects(0).order(), 45.0);
  EXPECT_EQ(loop->loop().unexplained(0).slip().moved_um().values(2).number_value(), -1.2);
  EXPECT_FALSE(loop->loop().next_measurement(1).has_session());
  const auto rewrite = ReportFromJson(records::kCompensate, reports::ToJson(ARewrite()));
  ASSERT_TRUE(rewrite.ok()) << rewrite.status();
  EXPECT_EQ(rewrite->rewrite().correction().at("X").max_um(), 10.0);
  EXPECT_EQ(rewrite->rewrite().positions(0).from(), -10.0);
  EXPECT_TRUE(ReportFromJson(records::kToolSetter, reports::ToJson(ABeam()))->has_beam());
  EXPECT_EQ(ReportFromJson(records::kToolSetter, reports::ToJson(AWear()))->wear().inserts(0).at_least_um(), 9.0);
}

TEST(Reports, WhatIsNoneIsRefused) {
  EXPECT_EQ(base::ErrorReason(ReportFromJson(records::kIdentify, "{\"errors\": 3}").status()), "REPORT_DAMAGED");
  EXPECT_EQ(base::ErrorReason(ReportFromJson(records::kIdentify, "").status()), "REPORT_DAMAGED");
  EXPECT_EQ(base::ErrorReason(ReportFromJson("dance", "{}").status()), "JOB_KIND_UNKNOWN");
  // What a later version adds is passed over.
  EXPECT_TRUE(ReportFromJson(records::kIdentify, R"({"rank": 2, "later": [1]})").ok());
}

}  // namespace
}  // namespace axiscal::convert
