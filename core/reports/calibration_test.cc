#include "core/reports/calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace axiscal::reports {
namespace {

using ::testing::HasSubstr;

// Numbers that no short decimal writes, so that a unit that is converted on the way would show.
constexpr double kThird = 1.0 / 3.0;

Fitted Everything() {
  Fitted fitted;
  fitted.errors = {{"EX0C", "EX0C", -22.2, 0.1 * kThird, "um", true},
                   {"EBB", "EBB:harmonic(45).cos", kNoNumber, kNoNumber, "urad", false}};
  fitted.coverage_factor = 2.0 + kThird;
  fitted.not_separable = {"EX0B - EX0C"};
  fitted.determined = {{"EX0B + EX0C", 7.0 * kThird, 0.5, "um"}};
  fitted.warnings = {InWords(SetAside{9, 100}), InWords(NoInterval{{"EX0C", "EA0C"}})};
  fitted.outliers = {{"BX", 12, 0, 41.0 * kThird, std::nullopt}, {"T1", 3, 1, -5.0, Gate{"sphere", 80.0, 20.0}}};
  fitted.sessions = {{{"BX", "mount"}, 400, 0.31, 1.7, {{"ball_x", {1.5, 0.2, "um"}}, {"tilt", {-0.0, 1e-9, "urad"}}}},
                     {{"T1", "T1"}, 80, 0.5, 2.0, {}}};
  fitted.budget_json = R"({"axiscal":"budget/1","note":"5 or 5.0","reading_noise":true,"sources":[{"half_width":70}]})";
  MonteCarlo simulation{1000, 2, uint64_t{1} << 63, {}, {{1.0, kThird}, {kThird, kNoNumber}}};
  simulation.errors = {{"EX0C", -22.2, -22.1, 0.4, -23.0, -21.0, kNoNumber, "um"}};
  fitted.monte_carlo = simulation;
  return fitted;
}

Identification AnIdentification() {
  Identification report;
  report.fitted = Everything();
  report.rank = 1;
  report.condition = 1e7 * kThird;
  report.nominal = {.rms_um = 30.0, .max_um = 90.0};
  report.before = {.rms_um = 20.0, .max_um = 70.0, .chi2_per_dof = 400.0 * kThird};
  report.fit = {.rms_um = 0.3,
                .max_um = 1.0,
                .rms_without_outliers_um = 0.29,
                .chi2_per_dof = kNoNumber,
                .readings = 480,
                .degrees_of_freedom = 0};
  report.correlation = {{1.0, kNoNumber}, {kNoNumber, kNoNumber}};
  report.held = Held{{{"EA0B", "EA0B", 82.1, kNoNumber, "urad"}}, {{0.1, kThird, 1.0}}, {{"H1", "head"}, {"H2", "H2"}}};
  report.iterations = 7;
  report.noise_scale = 1.0 + kThird;
  return report;
}

NamedTerm Named(const std::string& symbol, const std::string& shape, const std::string& name) {
  NamedTerm term;
  term.term.symbol = symbol;
  term.term.shape = shape;
  term.name = name;
  return term;
}

Loop ALoop() {
  Loop report;
  report.verdict = Verdict::kUnexplained;
  report.fitted = Everything();
  Effect harmonic{.is = Named("EBB", "harmonic", "EBB:harmonic(45)"),
                  .amplitude = 21.0 * kThird,
                  .amplitude_sigma = 0.1,
                  .unit = "urad",
                  .phase_deg = 12.0,
                  .alias_orders = {315, 405},
                  .rms_um = 3.0,
                  .evidence = 88.8};
  harmonic.is.term.variable = "B";
  harmonic.is.term.order = 45.0;
  NamedTerm map = Named("EYC", "tabulated", "EYC:tabulated(C=60,A=-30)");
  map.term.variable = "C";
  map.term.at = 60.0;
  map.term.over = "A";
  map.term.over_at = -30.0 * kThird;
  NamedTerm lobe = Named("approach", "lobe", "lobe(3)");
  lobe.term.variable = "approach";
  lobe.term.lobes = 3;
  harmonic.equivalent = {map, lobe};
  harmonic.same_always = {"lobe(3)"};
  Effect reversal{
      .is = Named("EXX", "reversal", "EXX:reversal"), .amplitude = 2.0, .amplitude_sigma = 0.1, .unit = "um"};
  reversal.is.term.variable = "X";
  reversal.is.term.length_mm = 10.0 * kThird;
  report.effects = {harmonic, reversal};
  report.fit = {{.rms_um = 5.0, .max_um = 9.0, .rms_without_outliers_um = 4.0, .chi2_per_dof = 200.0},
                {.rms_um = 0.5, .max_um = 0.9, .rms_without_outliers_um = 0.4, .chi2_per_dof = 1.0}};
  report.check = Check{report.fit.before, report.fit.after, true};
  report.volumetric = Volumetric{{{"X", -100.0 * kThird, 200.0, "mm"}, {"C", 0.0, 360.0, "deg"}},
                                 400,
                                 {30.0 * kThird, 9.0, 11.0},
                                 {5.0 * kThird, 1.0, 2.0},
                                 {0.1 * kThird, 0.01, 0.05},
                                 true,
                                 {"EY0C", "EA0C"},
                                 {"EX0C"}};
  report.steps = {{Change::kAdded, "EBB:harmonic(45)", 1.0}, {Change::kRefused, "EXX:backlash", 1.1}};
  Slip slip{Carrier::kTool, Carrier::kTable, {3.0 * kThird, kNoNumber, -1.2}, {0.05, kNoNumber, 0.1}};
  report.unexplained = {{PartKind::kSlip, "t", 10.0, 20.0 * kThird, "s", "BX", 2.0, slip},
                        {PartKind::kBadReadings, "B", -30.0, 30.0, "deg", "BX", 2.0, std::nullopt}};
  ProposedTest next{"N1", "ballbar-tilted", "a tilted circle", 0.99, 0.1, 50.0, true, "10 deg beyond B"};
  report.next_measurement = {{"EBB:harmonic(45)", {"a", "b"}, next, {"c"}, {}},
                             {"EXX:reversal", {}, std::nullopt, {}, {"EXX:other"}}};
  report.noise = {{"BX", 0.3, 0.31, kThird}};
  report.withdrawn = {"EYY:linear"};
  report.not_visible = {Named("EZ0T", "constant", "EZ0T")};
  report.axes_at_rest = {"A"};
  report.stopped_early = true;
  report.candidates = 4321;
  return report;
}

TEST(CalibrationReport, WrittenReadAndWrittenAgainIsTheSameText) {
  for (const std::string& text :
       {ToJson(AnIdentification()), ToJson(Identification{}), ToJson(ALoop()), ToJson(Loop{})}) {
    const absl::StatusOr<CalibrationReport> read = ReadCalibrationReport(text);
    ASSERT_TRUE(read.ok()) << read.status() << text;
    EXPECT_EQ(std::visit([](const auto& report) { return ToJson(report); }, *read), text);
  }
}

TEST(CalibrationReport, SaysAllThatWasWritten) {
  const absl::StatusOr<Identification> report = ReadIdentification(ToJson(AnIdentification()));
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->fitted.errors[1].name, "EBB:harmonic(45).cos");
  EXPECT_TRUE(std::isnan(report->fitted.errors[1].value));
  EXPECT_EQ(report->fitted.errors[0].name, "EX0C");
  EXPECT_EQ(report->fitted.determined[0].value, 7.0 * kThird);
  EXPECT_EQ(report->fitted.outliers[1].gate->gate, "sphere");
  EXPECT_FALSE(report->fitted.outliers[0].gate.has_value());
  EXPECT_EQ(report->fitted.warnings[0].kind, WarningKind::kSetAside);
  EXPECT_EQ(report->fitted.warnings[0].german, InGerman(SetAside{9, 100}));
  EXPECT_EQ(report->fitted.sessions[0].in.setup, "mount");
  EXPECT_EQ(report->fitted.sessions[1].in.setup, "T1");
  EXPECT_EQ(report->held->errors[0].symbol, "EA0B");
  EXPECT_EQ(report->fitted.monte_carlo->seed, uint64_t{1} << 63);
  EXPECT_EQ(report->before->chi2_per_dof, 400.0 * kThird);
  const absl::StatusOr<Loop> loop = ReadLoop(ToJson(ALoop()));
  ASSERT_TRUE(loop.ok()) << loop.status();
  EXPECT_EQ(loop->effects[0].is.term.order, 45.0);
  EXPECT_EQ(loop->effects[0].equivalent[1].term.lobes, 3);
  EXPECT_EQ(loop->unexplained[0].slip->may_be, Carrier::kTable);
  EXPECT_EQ(loop->next_measurement[0].test->beyond, "10 deg beyond B");
  EXPECT_FALSE(loop->next_measurement[1].test.has_value());
}

TEST(CalibrationReport, OfAnEarlierVersionLacksMembersAndIsReadAllTheSame) {
  const absl::StatusOr<CalibrationReport> report = ReadCalibrationReport(R"({"rank": 2, "later": [1]})");
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(std::get<Identification>(*report).rank, 2);
  EXPECT_TRUE(FittedOf(*report).errors.empty());
}

TEST(CalibrationReport, OfALaterVersionWarnsInItsOwnWords) {
  const absl::StatusOr<CalibrationReport> report =
      ReadCalibrationReport(R"({"warnings": [{"kind": "sunspots", "text": "the sun shone"}]})");
  ASSERT_TRUE(report.ok()) << report.status();
  ASSERT_EQ(FittedOf(*report).warnings.size(), 1u);
  EXPECT_EQ(FittedOf(*report).warnings[0].kind, WarningKind::kOther);
  EXPECT_EQ(FittedOf(*report).warnings[0].text, "the sun shone");
  EXPECT_FALSE(ReadCalibrationReport(R"({"warnings": [{"kind": 1, "text": "the sun shone"}]})").ok());
}

TEST(CalibrationReport, DamagedTextIsRefusedWithItsPlace) {
  const auto refusal = [](const std::string& text) {
    return std::string(ReadCalibrationReport(text).status().message());
  };
  const std::string text = ToJson(AnIdentification());
  for (const size_t size : {size_t{0}, size_t{1}, text.size() / 2, text.size() - 3})
    EXPECT_THAT(refusal(text.substr(0, size)), HasSubstr("report: ")) << size;
  EXPECT_THAT(refusal(text.substr(0, text.size() - 3)), HasSubstr("line"));
  EXPECT_EQ(refusal("[]"), "report: [], expected an object");
  EXPECT_EQ(refusal(R"({"rank": 2, "rank": 3})"), "report: 'rank' is there twice");
  EXPECT_EQ(refusal(R"({"rank": 2.5})"), "report: rank = 2.5, expected a whole number");
  EXPECT_EQ(refusal(R"({"rank": 3000000000})"), "report: rank = 3000000000, expected a whole number");
  EXPECT_EQ(refusal(R"({"errors": {}})"), "report: errors = {}, expected a list");
  EXPECT_EQ(refusal(R"({"errors": [{"symbol": "EX0C"}, {"symbol": "EY0C", "sigma": "abc"}]})"),
            "report: errors[1].sigma = \"abc\", expected a number");
  EXPECT_EQ(refusal(R"({"errors": [{"name": "EX0C"}]})"), "report: errors[0].symbol is missing");
  EXPECT_EQ(refusal(R"({"correlation": [[1, 0], [0, true]]})"), "report: correlation[1][1] = true, expected a number");
  EXPECT_EQ(refusal(R"({"sessions": [{"session": "BX", "setup": {"ball_x": {"unit": 1}}}]})"),
            "report: sessions[0].setup.ball_x.unit = 1, expected a text");
  EXPECT_EQ(refusal(R"({"verdict": "good"})"),
            "report: verdict = \"good\", expected one of adequate, extended, unexplained");
  EXPECT_EQ(refusal(R"({"verdict": "adequate", "unexplained": [{"slip": {"moved_um": [1, 2]}}]})"),
            "report: unexplained[0].slip.moved_um = [1,2], expected a list of 3 values");
  EXPECT_EQ(refusal(R"({"verdict": "adequate", "stopped_early": 1})"),
            "report: stopped_early = 1, expected true or false");
}

}  // namespace
}  // namespace axiscal::reports
