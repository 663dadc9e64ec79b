#include "core/sheet/calibration_sheet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_join.h"
#include "core/session/text.h"
#include "core/sheet/error_words.h"
#include "core/sheet/html.h"
#include "core/sheet/iso_words.h"
#include "core/sheet/numbers.h"

namespace axiscal::sheet {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

CalibrationToPrint ACalibration() {
  reports::Identification report;
  report.fitted.errors = {{"EX0C", "EX0C", -22.24, 0.153, "um", true},
                          {"EXX", "EXX:linear", reports::kNoNumber, reports::kNoNumber, "um/m", false}};
  report.fitted.coverage_factor = 2.1;
  report.fitted.not_separable = {"EX0B - EX0C"};
  report.fitted.determined = {{"EX0B + EX0C", 7.25, 0.5, "um"}};
  report.fitted.sessions = {{{"BX", "mount"}, 400, 0.31, 1.7, {}}, {{"other", "other"}, 4, 0.3, 1.0, {}}};
  report.before = {.rms_um = 20.0, .max_um = 70.0};
  report.fit = {.rms_um = 0.31, .max_um = 1.7};
  CalibrationToPrint calibration{report, {}, {}, {}};
  records::SessionRecord session;
  session.name = "BX";
  session.instrument = "ballbar";
  session.header = {{"serial", "QC-1234"}, {"sigma_um", "0.3"}, {"operator", "Ann"}};
  calibration.sessions = {session};
  return calibration;
}

machine::Axis AnAxis(const std::string& name, const Eigen::Vector3d& direction, const Eigen::Vector3d& point_mm) {
  machine::Axis axis;
  axis.name = name;
  axis.kind = name == "X" ? machine::AxisKind::kLinear : machine::AxisKind::kRotary;
  axis.direction = direction;
  axis.point_mm = point_mm;
  return axis;
}

// Three joints, upright and two that turn about -Y; the second link lies along -X.
machine::Machine AnArm() {
  machine::Machine arm;
  arm.id = "arm";
  arm.axes = {AnAxis("J1", {0, 0, 1}, {0, 0, 0}), AnAxis("J2", {0, -1, 0}, {0, 0, 89}),
              AnAxis("J3", {0, -1, 0}, {-425, 0, 89})};
  arm.tool_branch = {0, 1, 2};
  return arm;
}

std::vector<std::string> RowOf(const Sheet& sheet, const std::string& first) {
  for (const Section& section : sheet.sections) {
    for (const auto& row : section.rows) {
      if (row[0] == first) return row;
    }
  }
  return {};
}

Section SectionOf(const Sheet& sheet, const std::string& title) {
  for (const Section& section : sheet.sections)
    if (section.title == title) return section;
  return {};
}

TEST(CalibrationSheet, SaysErrorsWithExpandedUncertaintyInWordsOfTheStandard) {
  const Sheet sheet = CalibrationSheet(ACalibration(), Language::kEnglish);
  EXPECT_THAT(RowOf(sheet, "EX0C"), ElementsAre("EX0C", "position error of C in X", "-22.24", "0.15", "0.32", "µm"));
  // What has no number shows none, not zero.
  EXPECT_THAT(RowOf(sheet, "EXX:linear"),
              ElementsAre("EXX:linear", "positioning error of X: linear", "–", "–", "–", "µm/m"));
  EXPECT_THAT(RowOf(sheet, "readings, rms"), ElementsAre("readings, rms", "20", "0.31"));
  EXPECT_THAT(RowOf(sheet, "BX"), ElementsAre("BX", "ballbar, QC-1234", "–", "0.3", "400", "0.31", "1.7"));
  EXPECT_EQ(RowOf(sheet, "other")[1], "not stated");
  EXPECT_THAT(RowOf(sheet, "EX0B + EX0C"), ElementsAre("EX0B + EX0C", "7.2", "0.50", "1.1", "µm"));
  EXPECT_THAT(SectionOf(sheet, "What the readings do not tell").lines,
              ElementsAre("No number: EXX:linear", "Changes no reading: EX0B - EX0C"));
  EXPECT_EQ(sheet.facts[0].value, "not stated");
  EXPECT_EQ(sheet.facts[2].value, "not stated");
  EXPECT_EQ(sheet.facts[3].value, "Ann");
  CalibrationToPrint dated = ACalibration();
  dated.sessions[0].measured_at = base::FromUtcUs(1'775'455'200'000'000);
  EXPECT_EQ(CalibrationSheet(dated, Language::kEnglish).facts[2].value, "2026-04-06 06:00 UTC");
  EXPECT_EQ(sheet.signatures.size(), 2u);
}

// A certificate is valid on its last day; one that was not is said.
TEST(CalibrationSheet, SaysCertificates) {
  const auto lines_of = [](const char* measured) {
    CalibrationToPrint calibration = ACalibration();
    calibration.sessions[0].header.push_back(
        {"certificate bar_length", "4711 due 2027-01-31 value 149.9987 mm U 0.8 um k 2"});
    calibration.sessions[0].measured_at = session::ParseIso8601(measured);
    std::vector<std::string> lines;
    for (const Section& section : CalibrationSheet(calibration, Language::kEnglish).sections)
      if (section.title == "Measured with") lines = section.lines;
    return lines;
  };
  EXPECT_THAT(lines_of("2027-01-31T20:00:00Z"),
              ElementsAre("BX: certificate 4711 of bar_length, valid until 2027-01-31"));
  EXPECT_THAT(lines_of("2027-02-01T00:00:00Z"),
              ElementsAre("BX: certificate 4711 of bar_length, valid until 2027-01-31 (expired when measured)"));
}

// Where an uncertainty comes from that measuring again does not lessen.
TEST(CalibrationSheet, SaysWhatStatedFactsHaveInTheUncertainties) {
  CalibrationToPrint calibration = ACalibration();
  auto& fitted = std::get<reports::Identification>(calibration.report).fitted;
  fitted.stated = {{"thermometer of temp_C, +- 0.1 K", {{"EX0C", -0.14}}},
                   {"expansion of scale X, 9 +- 0.5 um/(m K)", {{"EX0C", 0.001}}}};
  const Sheet sheet = CalibrationSheet(calibration, Language::kEnglish);
  EXPECT_THAT(sheet.sections[0].lines, ElementsAre("In u by the thermometer of temp_C, +- 0.1 K: 0.14 µm of EX0C"));
  EXPECT_THAT(CalibrationSheet(calibration, Language::kGerman).sections[0].lines,
              ElementsAre("In u durch thermometer of temp_C, +- 0.1 K: 0,14 µm von EX0C"));
}

// A remark ends with what it means: 180 letters of it were a riddle.
TEST(CalibrationSheet, RemarksAreWhole) {
  CalibrationToPrint calibration = ACalibration();
  const reports::TrackerMoved moved{"station-1", 3, 5, 1630.0, 190.0, 719.0, 6.5, 130.0};
  std::get<reports::Identification>(calibration.report).fitted.warnings = {reports::InWords(moved)};
  const Sheet sheet = CalibrationSheet(calibration, Language::kEnglish);
  const Section& remarks = sheet.sections.back();
  ASSERT_EQ(remarks.title, "Remarks");
  EXPECT_THAT(remarks.lines[0], HasSubstr("seemed to go by up to 1630 +- 190 um and to turn by 719 +- 6.5 urad"));
  EXPECT_THAT(remarks.lines[0], ::testing::EndsWith("it is taken off and in no error"));
}

TEST(CalibrationSheet, IsGermanForGermanReaders) {
  const Sheet sheet = CalibrationSheet(ACalibration(), Language::kGerman);
  EXPECT_THAT(RowOf(sheet, "EX0C"), ElementsAre("EX0C", "Lageabweichung von C in X", "-22,24", "0,15", "0,32", "µm"));
  EXPECT_EQ(RowOf(sheet, "BX")[3], "0,3");
}

// The value has the place of the second digit of U, in every table; U = 2.1 u.
TEST(CalibrationSheet, ValuesHaveTheDigitsOfTheirExpandedUncertainty) {
  CalibrationToPrint calibration = ACalibration();
  auto& fitted = std::get<reports::Identification>(calibration.report).fitted;
  fitted.errors = {{"EX0C", "EX0C", 6.3612, 0.0476, "um", true}, {"EA0C", "EA0C", 101.04, 6.9, "urad", true}};
  fitted.determined = {{"0.5 EX0B + EX0C", 1234.56, 100.0, "um"}};
  const Sheet sheet = CalibrationSheet(calibration, Language::kGerman);
  EXPECT_THAT(RowOf(sheet, "EX0C"), ElementsAre("EX0C", "Lageabweichung von C in X", "6,36", "0,048", "0,10", "µm"));
  EXPECT_THAT(RowOf(sheet, "EA0C"),
              ElementsAre("EA0C", "Rechtwinkligkeitsabweichung von C zu Y", "101", "6,9", "14", "µrad"));
  EXPECT_THAT(RowOf(sheet, "0,5 EX0B + EX0C"), ElementsAre("0,5 EX0B + EX0C", "1230", "100", "210", "µm"));
}

// An arm of which most errors have no number: those that have one keep their meaning, the sums are there with U.
TEST(CalibrationSheet, AnArmHasMeaningsAndSums) {
  CalibrationToPrint calibration = ACalibration();
  calibration.machine = AnArm();
  auto& fitted = std::get<reports::Identification>(calibration.report).fitted;
  fitted.errors.clear();
  fitted.not_separable.clear();
  fitted.determined.clear();
  for (const char* axis : {"J1", "J2", "J3"}) {
    for (const char* component : {"EX0", "EY0", "EZ0", "EA0", "EB0", "EC0"}) {
      const std::string name = absl::StrCat(component, axis);
      for (const char* part : {"", ":linear"})  // more than a page has rows
        fitted.errors.push_back({name, name + part, 1.0, 0.1, "um", name == "EX0J3" || name == "EB0J3"});
      fitted.not_separable.push_back(absl::StrCat(name, " - 0.425 EB0J9"));
    }
    fitted.determined.push_back({absl::StrCat("EB0", axis, " + 0.5 EC0J9"), 2.0, 0.1, "urad"});
  }
  const Sheet sheet = CalibrationSheet(calibration, Language::kGerman);
  EXPECT_EQ(sheet.title, "Geometrische Abweichungen eines Roboterarms");
  ASSERT_EQ(sheet.sections[0].rows.size(), 4u);
  EXPECT_EQ(RowOf(sheet, "EX0J3")[1], "Glied zwischen Gelenk 2 und 3: Länge entlang X");
  EXPECT_EQ(RowOf(sheet, "EB0J3")[1], "Gelenk 3: Nullpunktversatz");
  EXPECT_THAT(RowOf(sheet, "EB0J3 + 0,5 EC0J9"), ElementsAre("EB0J3 + 0,5 EC0J9", "2,00", "0,10", "0,21", "µrad"));
  EXPECT_EQ(SectionOf(sheet, "Zusammen bekannt, einzeln nicht").rows.size(), 3u);
  const Section untold = SectionOf(sheet, "Was die Messwerte nicht trennen");
  EXPECT_THAT(absl::StrJoin(untold.lines, " "), HasSubstr("Ohne Zahl: EX0J1, EX0J1:linear, EY0J1"));
  EXPECT_THAT(absl::StrJoin(untold.lines, " "), HasSubstr("EC0J3 - 0,425 EB0J9"));
}

TEST(ErrorWords, OfAnArmAreOfJointsAndLinks) {
  const auto say = [](const char* symbol) { return ErrorWords(symbol, AnArm(), Language::kEnglish); };
  EXPECT_EQ(say("EC0J1"), "joint 1: zero offset");
  EXPECT_EQ(say("EA0J2"), "joint 2: tilt of its axis around X");
  EXPECT_EQ(say("EX0J1"), "joint 1: place along X");
  EXPECT_EQ(say("EX0J3"), "link between joints 2 and 3: length along X");
  EXPECT_EQ(say("EY0J3"), "link between joints 2 and 3: offset along Y");
  EXPECT_EQ(say("EBJ2"), "joint 2: positioning error");
  EXPECT_EQ(say("EXJ2"), "joint 2: run-out along X");
  EXPECT_EQ(say("EZ0T"), "tool: offset along Z");
  EXPECT_EQ(say("nonsense"), "");
  EXPECT_EQ(PartWords("harmonic(45).cos", Language::kGerman), "Harmonische(45).cos");
  EXPECT_EQ(PartWords("backlash#2", Language::kGerman), "Umkehrspanne#2");
  EXPECT_EQ(PartWords("backlash", Language::kEnglish), "backlash");
  // A1 to A3 are no axes about X.
  machine::Machine arm = AnArm();
  for (machine::Axis& axis : arm.axes) axis.name[0] = 'A';
  EXPECT_EQ(ErrorWords("EB0A3", arm, Language::kEnglish), "joint 3: zero offset");
  // A machine tool's are those of the standard, with or without its description.
  machine::Machine mill;
  mill.axes = {AnAxis("X", {1, 0, 0}, {0, 0, 0}), AnAxis("C", {0, 0, -1}, {0, 0, 0})};
  EXPECT_EQ(ErrorWords("EC0C", mill, Language::kEnglish), "zero position error of C");
  EXPECT_EQ(ErrorWords("EC0C", std::nullopt, Language::kEnglish), "zero position error of C");
}

// At which tool point the figures hold, and what was stated of each set-up.
TEST(CalibrationSheet, SaysHowItWasMeasured) {
  CalibrationToPrint calibration = ACalibration();
  auto& fitted = std::get<reports::Identification>(calibration.report).fitted;
  fitted.sessions[1].in = {"CR", "CR"};
  calibration.sessions.push_back(calibration.sessions[0]);
  calibration.sessions[1].name = "CR";
  for (records::SessionRecord& session : calibration.sessions) {
    for (const auto& [key, value] : {std::pair{"tool_tip_mm", "0 0 -350.500"}, {"table_ball_mm", "50 0 65"}})
      session.header.push_back({key, value});
  }
  const auto lines = [&](Language language) {
    const Sheet sheet = CalibrationSheet(calibration, language);
    return SectionOf(sheet, language == Language::kGerman ? "Gemessen mit" : "Measured with").lines;
  };
  EXPECT_EQ(CalibrationSheet(calibration, Language::kEnglish).facts[4].value, "(0; 0; -350.5) mm");
  EXPECT_THAT(lines(Language::kEnglish), ElementsAre("all sessions: table ball at (50; 0; 65) mm"));
  calibration.sessions[1].instrument = "length";
  calibration.sessions[1].header = {
      {"tool_tip_mm", "0 0 -150"}, {"anchor_mm", "0.5 -500 20"}, {"anchor_on", "bed"},  {"scale_sigma_um", "100"},
      {"knocked_s", "120.5 900"},  {"reference R1", "1 2 3"},    {"datum", "free X Z"}, {"setup", "wire"}};
  EXPECT_EQ(CalibrationSheet(calibration, Language::kGerman).facts[4].value, "(0; 0; -150) mm, (0; 0; -350,5) mm");
  EXPECT_THAT(lines(Language::kGerman),
              ElementsAre("BX: Werkzeugpunkt (0; 0; -350,5) mm, Tischkugel bei (50; 0; 65) mm",
                          "CR: Werkzeugpunkt (0; 0; -150) mm, Ankerpunkt bei (0,5; -500; 20) mm am Bett, u der Teilung "
                          "100 µm/m, Tracker angestoßen bei t = 120,5; 900 s, Nullpunkt neu gesetzt: X Z, Aufspannung "
                          "wire, Referenzziele neben der Maschine: R1"));
  EXPECT_EQ(RowOf(CalibrationSheet(calibration, Language::kGerman), "CR")[1],
            "Länge von einem Ankerpunkt, ohne Seriennummer");
}

// What a residual is of, and what the tool point's error is of, stands above each number.
TEST(CalibrationSheet, SaysBeforeWhat) {
  CalibrationToPrint calibration = ACalibration();
  const auto head = [&](const char* title) {
    return SectionOf(CalibrationSheet(calibration, Language::kEnglish), title).head;
  };
  const char* const kResiduals = "Residuals of the readings, µm";
  EXPECT_THAT(head(kResiduals), ElementsAre("what", "without these errors", "with these errors"));
  std::get<reports::Identification>(calibration.report).held.emplace();
  EXPECT_THAT(head(kResiduals), ElementsAre("what", "held errors alone", "with these errors"));
  std::get<reports::Identification>(calibration.report).before.reset();
  EXPECT_THAT(head(kResiduals), ElementsAre("what", "machine and set-ups as stated", "with these errors"));
  calibration.report = reports::Loop{.volumetric = reports::Volumetric{}};
  EXPECT_THAT(head(kResiduals), ElementsAre("what", "declared model", "with all that was found"));
  EXPECT_THAT(head("Error of the tool point, µm"),
              ElementsAre("what", "machine as it is", "compensated with these errors"));
}

// Warnings, causes, instruments, stated facts: no English but names, unless the report has nothing else.
TEST(CalibrationSheet, RemarksAreGermanForGermanReaders) {
  CalibrationToPrint calibration = ACalibration();
  calibration.sessions[0].instrument = "centres";
  calibration.sessions[0].header.push_back({"expansion bar", "11.5 0.5"});
  calibration.sessions[0].header.push_back({"temperature_sigma_K", "0.1"});
  auto& fitted = std::get<reports::Identification>(calibration.report).fitted;
  fitted.stated = {{"expansion of bar, 11.5 +- 0.5 um/(m K)", {{"EX0C", 0.14}}},
                   {"thermometer of temp_C, +- 0.1 K", {{"EX0C", 0.14}}}};
  fitted.warnings = {reports::InWords(reports::Scatter{.times_sigma = 2.34}),
                     {reports::WarningKind::kClock, "as an earlier version said it"}};
  const Sheet sheet = CalibrationSheet(calibration, Language::kGerman);
  EXPECT_THAT(sheet.sections.back().lines,
              ElementsAre(fitted.warnings[0].german, "(englisch) as an earlier version said it"));
  EXPECT_EQ(RowOf(sheet, "BX")[1], "Messtaster (Kugelmitten), QC-1234");
  EXPECT_THAT(sheet.sections[0].lines,
              ElementsAre("In u durch Ausdehnung des Stabs, 11,5 ± 0,5 µm/(m K): 0,14 µm von EX0C",
                          "In u durch Thermometer temp_C, ± 0,1 K: 0,14 µm von EX0C"));
  reports::Loop loop;
  loop.causes = {{reports::CauseKind::kNominal, "all sessions: x", 9.0, "", "alle Messungen: x", ""}};
  calibration.report = loop;
  EXPECT_THAT(CalibrationSheet(calibration, Language::kGerman).sections.back().lines,
              ElementsAre("Nicht die Maschine: alle Messungen: x"));
}

TEST(CalibrationSheet, ManyErrorsStandInPairs) {
  CalibrationToPrint calibration = ACalibration();
  auto& errors = std::get<reports::Identification>(calibration.report).fitted.errors;
  for (int i = 0; i < 57; ++i) errors.push_back({"EXC", absl::StrCat("EXC:harmonic(", i, ")"), i * 1.0, 1, "um", true});
  ASSERT_EQ(errors.size(), 59u);
  const Section section = CalibrationSheet(calibration, Language::kEnglish).sections[0];
  EXPECT_EQ(section.columns.size(), section.head.size());
  ASSERT_EQ(section.rows.size(), 30u);
  EXPECT_THAT(section.rows[0], ElementsAre("EX0C", "-22.24", "0.15", "0.32", "µm",  //
                                           "EXC:harmonic(28)", "28.0", "1.0", "2.1", "µm"));
  EXPECT_THAT(section.rows[29], ElementsAre("EXC:harmonic(27)", "27.0", "1.0", "2.1", "µm", "", "", "", "", ""));
  EXPECT_THAT(section.lines, Not(Contains(HasSubstr("more"))));
  // In smaller letters where the usual ones would take a second page.
  EXPECT_THAT(ToHtml(CalibrationSheet(ACalibration(), Language::kEnglish)), Not(HasSubstr("class=\"dense\"")));
  auto& sessions = std::get<reports::Identification>(calibration.report).fitted.sessions;
  sessions.resize(8, sessions[0]);
  EXPECT_THAT(ToHtml(CalibrationSheet(calibration, Language::kEnglish)), HasSubstr("<body class=\"dense\">"));
  auto& fitted = std::get<reports::Identification>(calibration.report).fitted;
  fitted.determined.resize(18, fitted.determined[0]);
  fitted.warnings.resize(5, reports::InWords(reports::TrackerMoved{.session = "T"}));
  EXPECT_THAT(ToHtml(CalibrationSheet(calibration, Language::kEnglish)), HasSubstr("<body class=\"denser\">"));
}

TEST(CalibrationSheet, WhatWouldNotFitIsCutAndSaysSo) {
  CalibrationToPrint calibration = ACalibration();
  auto& fitted = std::get<reports::Identification>(calibration.report).fitted;
  for (int i = 0; i < 98; ++i)
    fitted.errors.push_back({"EXC", absl::StrCat("EXC:harmonic(", i, ")"), 1, 1, "um", true});
  fitted.not_separable = {std::string(5000, 'x') + "ü"};
  const Sheet sheet = CalibrationSheet(calibration, Language::kEnglish);
  EXPECT_EQ(sheet.sections[0].rows.size(), 30u);
  EXPECT_THAT(sheet.sections[0].lines, Contains("and 40 more, in the report as JSON"));
  for (const std::string& line : SectionOf(sheet, "What the readings do not tell").lines) EXPECT_LT(line.size(), 200u);
}

TEST(CalibrationSheet, SaysWhatTheLoopFound) {
  reports::Loop loop;
  reports::Effect effect;
  effect.is.name = "EBB:harmonic(45)";
  effect.equivalent.resize(1);
  effect.equivalent[0].name = "EBB:curve";
  loop.effects = {effect};
  loop.causes = {{reports::CauseKind::kInstrument, "rtest: gain of x", 812.0, "calibrate it"}};
  loop.fit = {{.rms_um = 12.0, .max_um = 30.0}, {.rms_um = 0.4, .max_um = 1.0}};
  loop.check = reports::Check{{.rms_um = 11.0, .max_um = 30.0}, {.rms_um = 0.5, .max_um = 1.0}, false};
  loop.volumetric = reports::Volumetric{.uncorrected = {30.0, 28.0, 32.0}, .after = {1.0, 0.5, 1.5}};
  const Sheet sheet = CalibrationSheet({loop, {}, {}, {}}, Language::kEnglish);
  EXPECT_THAT(RowOf(sheet, "check sessions, rms"), ElementsAre("check sessions, rms", "11", "0.5"));
  const std::string box = "tool point over the measured box, rms [95 %]";
  EXPECT_THAT(RowOf(sheet, box), ElementsAre(box, "30.0 [28.0; 32.0]", "1.00 [0.50; 1.50]"));
  EXPECT_THAT(SectionOf(sheet, "What the readings do not tell").lines,
              Contains("EBB:harmonic(45) may as well be EBB:curve"));
  EXPECT_THAT(sheet.sections.back().lines, Contains("Not the machine: rtest: gain of x"));
}

TEST(IsoWords, NamesEveryKindOfError) {
  const auto say = [](const char* symbol) { return IsoWords(symbol, Language::kEnglish); };
  EXPECT_EQ(say("EXX"), "positioning error of X");
  EXPECT_EQ(say("EYX"), "straightness error motion of X in Y");
  EXPECT_EQ(say("EAX"), "roll error motion of X");
  EXPECT_EQ(say("ECX"), "angular error motion of X around Z");
  EXPECT_EQ(say("EC0Y"), "squareness error of Y to X");
  EXPECT_EQ(say("EA0Z"), "squareness error of Z to Y");
  EXPECT_EQ(say("EX0X"), "zero position error of X");
  EXPECT_EQ(say("EX0C"), "position error of C in X");
  EXPECT_EQ(say("EA0C"), "squareness error of C to Y");
  EXPECT_EQ(say("EC0C"), "zero position error of C");
  EXPECT_EQ(say("EZC"), "axial error motion of C");
  EXPECT_EQ(say("EXC2"), "radial error motion of C2 in X");
  EXPECT_EQ(say("EAC"), "tilt error motion of C around X");
  EXPECT_EQ(say("ECC"), "angular positioning error of C");
  EXPECT_EQ(say("EX0T"), "offset of spindle and tool in X");
  EXPECT_EQ(say("EZ0W"), "offset of the table ball in Z");
  EXPECT_EQ(say("EA0J1"), "error of J1 around X");
  EXPECT_EQ(say("nonsense"), "");
  EXPECT_EQ(IsoWords("EC0Y", Language::kGerman), "Rechtwinkligkeitsabweichung von Y zu X");
}

TEST(SheetNumbers, HaveTheDigitsOfTheirUncertainty) {
  EXPECT_EQ(ValueText(-22.2449, 0.153, Language::kEnglish), "-22.24");
  EXPECT_EQ(ValueText(1234.6, 230.0, Language::kEnglish), "1230");
  EXPECT_EQ(ValueText(-0.001, 0.3, Language::kGerman), "0,00");
  EXPECT_EQ(ValueText(NAN, 0.3, Language::kEnglish), "–");
  EXPECT_EQ(NumberText(0.31, 3, Language::kEnglish), "0.31");
  EXPECT_EQ(NumberText(1200, 2, Language::kEnglish), "1200");
  EXPECT_EQ(NumberText(3e-7, 2, Language::kGerman), "3e-07");
  // Both digits, zeros too, and of the rounded number.
  EXPECT_EQ(UncertaintyText(0.1, Language::kGerman), "0,10");
  EXPECT_EQ(UncertaintyText(0.0996, Language::kEnglish), "0.10");
  EXPECT_EQ(ValueText(6.36, 0.0996, Language::kEnglish), "6.36");
  EXPECT_EQ(UncertaintyText(13.2, Language::kEnglish), "13");
  EXPECT_EQ(UncertaintyText(996.0, Language::kEnglish), "1000");
  EXPECT_EQ(UncertaintyText(105.0, Language::kEnglish), "110");
  EXPECT_EQ(UncertaintyText(NAN, Language::kEnglish), "–");
  EXPECT_EQ(IntervalText(15.17, 0.326, 37.1, Language::kGerman), "15 [0; 37]");
  EXPECT_EQ(CombinationText("0.5 EX0C + 5.4e-05 EBB:harmonic(0.5).cos", Language::kGerman),
            "0,5 EX0C + 5,4e-05 EBB:harmonic(0.5).cos");
  EXPECT_EQ(TimeText(base::FromUtcUs(1'775'455'200'000'000)), "2026-04-06 06:00 UTC");
}

TEST(SheetHtml, HoldsTextAsTextAndSaysItsStyle) {
  CalibrationToPrint calibration = ACalibration();
  std::get<reports::Identification>(calibration.report).fitted.not_separable = {"<img src=x onerror=alert(1)>"};
  const std::string html = ToHtml(CalibrationSheet(calibration, Language::kGerman));
  EXPECT_THAT(html, HasSubstr("<html lang=\"de\">"));
  EXPECT_THAT(html,
              HasSubstr("<th scope=\"row\">EX0C</th><td>Lageabweichung von C in X</td><td class=\"n\">-22,24</td>"));
  EXPECT_THAT(html, HasSubstr("&lt;img"));
  EXPECT_THAT(html, Not(HasSubstr("<img")));
  // 32 bytes as base64.
  EXPECT_EQ(StyleHash().size(), 9u + 44u);
}

}  // namespace
}  // namespace axiscal::sheet
