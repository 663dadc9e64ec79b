// Every test that can be planned, from the plan's file over the control's log to a session: the tests are those of the
// planners' own lists, so that a new one is held to this as well.
#include "core/logs/testing/planned_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <sstream>

#include "core/base/files.h"
#include "core/base/random.h"
#include "core/base/testing/source_path.h"
#include "core/base/units.h"
#include "core/instruments/evaluation.h"
#include "core/instruments/registry.h"
#include "core/instruments/run.h"
#include "core/logs/reduce.h"
#include "core/machine/error_model.h"
#include "core/machine/testing/machines.h"
#include "core/plan/program.h"
#include "core/plan/test.h"
#include "core/plan/testing/situations.h"
#include "core/session/column_rules.h"
#include "core/session/read_session.h"
#include "core/session/write_session.h"
#include "core/synthetic/simulate.h"
#include "core/toolsetter/plan.h"

namespace axiscal::logs {
namespace {

using machine::Machine;
using plan::testing::Machines;
using plan::testing::Measured;
using plan::testing::NeverMeasured;
using session::Column;
using session::Session;
using testing::ColumnOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using testing::HeaderOf;
using testing::IsReading;
using testing::Line;
using testing::LogOf;
using testing::ReduceText;
using testing::TemplateOf;

// 20 um and 50 urad of each declared error.
machine::ErrorModel Truth(const Machine& machine) {
  machine::ErrorModel truth = machine::DeclaredModel(machine);
  for (machine::ErrorTerm& term : truth.terms)
    term.amplitude[0] = term.component <= machine::Component::kZ ? 0.020 : 50e-6;
  return truth;
}

std::string Refusal(const absl::StatusOr<Reduced>& reduced) {
  return reduced.ok() ? "accepted" : std::string(reduced.status().message());
}

// The session is one, and what was measured, to the decimals of the log.
void ExpectMeasured(const Session& reduced, const Session& measured, const std::string& what) {
  const auto text = session::WriteSession(reduced);
  ASSERT_TRUE(text.ok()) << what << ": " << text.status();
  ASSERT_TRUE(session::ReadSessionText(*text, "s.csv").ok()) << what;
  for (const session::HeaderEntry& entry : measured.header) EXPECT_THAT(reduced.header, Contains(entry)) << what;
  ASSERT_EQ(reduced.columns.size(), measured.columns.size()) << what;
  for (const Column& column : measured.columns) {
    const Column* const there = session::FindColumn(reduced, column.name);
    ASSERT_NE(there, nullptr) << what << ": " << column.name;
    EXPECT_EQ(there->texts, column.texts) << what << ": " << column.name;
    ASSERT_EQ(there->values.size(), column.values.size()) << what << ": " << column.name;
    constexpr double kDecimals = 0.51e-4;
    for (size_t k = 0; k < column.values.size(); ++k)
      ASSERT_NEAR(there->values[k], column.values[k], kDecimals) << what << ": " << column.name << ' ' << k;
  }
}

// Where the program touches: begin and end of each touch, by axis, mm and rad.
struct Way {
  std::vector<double> from, to;
};

std::vector<Way> Touches(const Machine& machine, const std::string& program) {
  std::vector<Way> touches;
  std::vector<double> at;
  std::istringstream in(program);
  for (std::string text; std::getline(in, text);) {
    const bool is_touch = text.rfind("G31 ", 0) == 0 || text.rfind("G38.2 ", 0) == 0 || text.rfind("MEAS=1 ", 0) == 0;
    if (!is_touch && text.rfind("G00 ", 0) != 0) continue;
    std::vector<double> to;
    for (const machine::Axis& axis : machine.axes) {
      const double number = std::stod(text.substr(text.find(" " + axis.name) + 1 + axis.name.size()));
      to.push_back(axis.kind == machine::AxisKind::kRotary ? number * base::kRadPerDeg : number);
    }
    if (is_touch) touches.push_back({at, to});
    at = std::move(to);
  }
  return touches;
}

constexpr double kSphereMm = 12.5, kStylusMm = 3.0,
                 kLateMm = 0.004;  // the probe triggers late, alike in all directions

// Where on the way, mm and deg, a sphere is touched that stands off the header's place by `mounted_mm`.
std::vector<double> Contact(const Machine& machine, const instruments::MeasuringRun& run, const Way& way,
                            const Eigen::Vector3d& mounted_mm) {
  const machine::JointErrors<double> errors = machine::ErrorsAt(machine, Truth(machine), {});
  std::vector<double> positions(way.from.size());
  const auto gap_mm = [&](double share) {
    for (size_t i = 0; i < positions.size(); ++i) positions[i] = way.from[i] + share * (way.to[i] - way.from[i]);
    const auto pose = machine::EvaluateChain<double>(machine, positions.data(), errors);
    return (pose.bed_from_tool * run.tip_mm - pose.bed_from_table * (run.ball_mm + mounted_mm)).norm() - kSphereMm -
           kStylusMm + kLateMm;
  };
  double free = 0.0, beyond = 1.0;
  EXPECT_GT(gap_mm(free), 0.0);
  EXPECT_LT(gap_mm(beyond), 0.0);
  for (int i = 0; i < 60; ++i) (gap_mm(0.5 * (free + beyond)) > 0.0 ? free : beyond) = 0.5 * (free + beyond);
  for (size_t i = 0; i < positions.size(); ++i)
    positions[i] *= machine.axes[i].kind == machine::AxisKind::kRotary ? base::kDegPerRad : 1.0;
  return positions;
}

plan::ProgramOptions Dialect(const std::string& name) {
  plan::ProgramOptions options;
  options.dialect = name;
  return options;
}

struct Control {
  std::string dialect, format;
};
const Control kControls[] = {{"fanuc", "dprnt"}, {"linuxcnc", "linuxcnc-probe"}, {"sinumerik", "sinumerik-write"}};

std::string Head(const Control& control, size_t touches) {
  if (control.format == "linuxcnc-probe") return "";
  return absl::StrCat("Number of Points ", touches, "\nFeature Model TOUCH\n");
}

void CheckTouchSession(const Machine& machine, const Session& planned, const Session& plan, const std::string& what) {
  auto measured = synthetic::Simulate(machine, Truth(machine), planned, {});
  ASSERT_TRUE(measured.ok()) << what << measured.status();
  // No control prints the temperature, and the plan's is not what was measured.
  std::erase_if(measured->columns, [](const Column& column) { return column.name == "temp_C"; });
  for (const Control& control : kControls) {
    const auto program = plan::ToProgram(machine, planned, Dialect(control.dialect));
    ASSERT_TRUE(program.ok()) << what << program.status();
    ASSERT_EQ(Touches(machine, *program).size(), measured->reading_count());
    std::string log = Head(control, measured->reading_count());
    for (size_t k = 0; k < measured->reading_count(); ++k) {
      std::vector<double> positions;
      for (const machine::Axis& axis : machine.axes)
        positions.push_back(session::FindColumn(*measured, ColumnOf(axis))->values[k]);
      log += Line(control.format, machine, positions);
    }
    const auto reduced = ReduceText(log, FindFormat(control.format).value(), &machine, plan);
    ASSERT_TRUE(reduced.ok()) << what << reduced.status();
    ExpectMeasured(reduced->session, *measured, what);
    EXPECT_TRUE(instruments::BindSession(reduced->session, machine).ok()) << what;
  }
}

void CheckCentresSession(const Machine& machine, const Session& planned, const Session& plan, const std::string& what) {
  Session nothing_read = planned;
  for (const char* const name : {"cx_mm", "cy_mm", "cz_mm"})
    nothing_read.columns.push_back({name, std::vector<double>(planned.reading_count()), {}});
  const instruments::MeasuringRun run = instruments::BindSession(nothing_read, machine).value();
  const Eigen::Vector3d mounted_mm(0.3, -0.2, 0.1);
  for (const Control& control : kControls) {
    const auto program = plan::ToProgram(machine, planned, Dialect(control.dialect));
    ASSERT_TRUE(program.ok()) << what << program.status();
    const std::vector<Way> touches = Touches(machine, *program);
    std::string log = Head(control, touches.size());
    for (const Way& way : touches) log += Line(control.format, machine, Contact(machine, run, way, mounted_mm));
    const auto reduced = ReduceText(log, FindFormat(control.format).value(), &machine, plan);
    ASSERT_TRUE(reduced.ok()) << what << reduced.status();
    const Session& session = reduced->session;
    ASSERT_EQ(session.reading_count(), planned.reading_count()) << what;
    const auto bound = instruments::BindSession(session, machine);
    ASSERT_TRUE(bound.ok()) << what << bound.status();
    double setup[instruments::kMaxSetupParameters] = {mounted_mm.x(), mounted_mm.y(), mounted_mm.z()};
    const machine::JointErrors<double> errors = machine::ErrorsAt(machine, Truth(machine), {});
    for (int k = 0; k < bound->reading_count(); ++k) {
      double expected_mm[instruments::kMaxRows];
      instruments::Predict(machine, *bound, k, errors, setup, expected_mm);
      constexpr double kToleranceMm = 2e-3;  // four decimals of five touches; 50 urad over the sphere
      for (int row = 0; row < 3; ++row) EXPECT_NEAR(bound->measured_mm(row, k), expected_mm[row], kToleranceMm) << what;
    }
    EXPECT_EQ(session::FindColumn(session, "t_s")->values, session::FindColumn(planned, "t_s")->values);
    EXPECT_EQ(HeaderOf(session, "sigma_um"), HeaderOf(planned, "sigma_um"));
    EXPECT_FALSE(HeaderOf(session, "centre_sigma_um").empty());
    EXPECT_TRUE(session::ReadSessionText(session::WriteSession(session).value(), "s.csv").ok());
  }
}

// A log with all columns, and one with the readings alone.
void CheckReadSession(const Machine* machine, const Session& measured, const Session& plan, const std::string& what) {
  std::vector<const Column*> all, read;
  for (const Column& column : measured.columns) {
    all.push_back(&column);
    if (IsReading(measured, column)) read.push_back(&column);
  }
  ASSERT_FALSE(read.empty()) << what;
  ASSERT_LT(read.size(), all.size()) << what;
  for (const std::vector<const Column*>& columns : {all, read}) {
    const std::string log = LogOf(columns, measured.reading_count());
    const auto reduced = ReduceText(log, TemplateOf(columns), machine, plan);
    ASSERT_TRUE(reduced.ok()) << what << reduced.status();
    ExpectMeasured(reduced->session, measured, what);
    if (machine != nullptr) {
      EXPECT_TRUE(instruments::BindSession(reduced->session, *machine).ok()) << what;
    }
  }
  // A reading that is missing somewhere is not made up by the plan's order.
  const std::string shorter = LogOf(read, measured.reading_count() - 1);
  EXPECT_THAT(Refusal(ReduceText(shorter, TemplateOf(read), machine, plan)), HasSubstr("expected all of them")) << what;
  for (const Column* const column : read) {
    if (column->name == "temp_C") continue;
    std::vector<const Column*> others = all;
    std::erase(others, column);
    EXPECT_THAT(Refusal(ReduceText(LogOf(others, measured.reading_count()), TemplateOf(others), machine, plan)),
                HasSubstr("has no field {" + column->name + "}, which instrument"))
        << what;
  }
}

TEST(PlannedLogs, EveryTestOfTheMachinesErrorsBecomesASession) {
  for (const auto* const tests : {&plan::Tests(), &plan::FurtherTests()}) {
    for (const plan::Test& test : *tests) {
      size_t sessions = 0;
      for (const Machine& machine : Machines()) {
        std::vector<instruments::MeasuringRun> runs;
        for (const plan::Situation& situation : {NeverMeasured(machine), Measured(machine, &runs)}) {
          for (const plan::PlannedSession& one : test.plan(situation)) {
            if (!plan::ReachOf(situation, one.session).is_reachable) continue;
            ++sessions;
            const std::string instrument = HeaderOf(one.session, "instrument");
            const std::string what = machine.id + " " + HeaderOf(one.session, "session") + ": ";
            const auto plan = session::ReadPlanText(plan::ToTable(one.session), "plan.csv");
            ASSERT_TRUE(plan.ok()) << what << plan.status();
            EXPECT_EQ(plan->reading_count(), one.session.reading_count());
            if (instrument == "touch") {
              CheckTouchSession(machine, one.session, *plan, what);
            } else if (instrument == "centres") {
              CheckCentresSession(machine, one.session, *plan, what);
            } else {
              const auto measured = synthetic::Simulate(machine, Truth(machine), one.session, {});
              ASSERT_TRUE(measured.ok()) << what << measured.status();
              CheckReadSession(&machine, *measured, *plan, what);
            }
            if (HasFatalFailure()) return;
          }
        }
      }
      EXPECT_GT(sessions, 0u) << test.name << ": no machine here runs it";
    }
  }
}

std::string Example(const std::string& name) { return base::SourcePath("/deploy/examples/" + name); }

Session WithReadings(Session plan, const std::string& column, const std::vector<double>& readings) {
  plan.columns.push_back({column, readings, {}});
  return plan;
}

// The plans of the tool setter's own list, with the readings that they expect and some noise.
TEST(PlannedLogs, EveryTestOfTheToolSetterBecomesASession) {
  base::Random random(7);
  for (const toolsetter::PlannableTest& test : toolsetter::PlannableTests()) {
    std::vector<double> readings;
    std::string table;
    if (test.name == "tool-setter") {
      const auto rods = session::ReadSessionFile(Example("fang-tool-setter/tool-setter-misaligned-1.csv")).value();
      const auto planned = toolsetter::PlanRods(toolsetter::ReadRodSession(rods).value(), "rod-2", 12, 3).value();
      table = toolsetter::ToTable(rods, planned);
      for (const toolsetter::MeasuredRod& rod : planned.rods) {
        for (const double readout_mm : rod.readouts_mm) readings.push_back(readout_mm - 500.0);
      }
    } else if (test.name == "tool-curve") {
      const std::string file = Example("fang-round-insert/cutter.json");
      const auto cutter = toolsetter::ReadCutterFile(file).value();
      toolsetter::CurveSession session;
      session.sigma_mm = 1e-3;
      session.start_sigma_rad = 1e-3;
      session.cutter = cutter.cutter;
      session.run = cutter.run;
      const auto planned = toolsetter::PlanStarts(session, 12).value();
      table = toolsetter::ToTable(base::ReadFile(file, 1 << 20).value(), "mt", "starts", planned).value();
      readings = planned.lengths_mm;
    } else {
      FAIL() << test.name << ": a new test of the tool setter, expected its plan and log here";
    }
    for (double& reading : readings) reading += 0.5e-3 * random.Normal();
    const auto plan = session::ReadPlanText(table, "plan.csv");
    ASSERT_TRUE(plan.ok()) << plan.status();
    EXPECT_FALSE(session::ReadSessionText(table, "plan.csv").ok());  // a plan is not a measured session
    const std::string column = test.name == "tool-setter" ? "Z_mm" : "length_mm";
    const Session measured = WithReadings(*plan, column, readings);
    CheckReadSession(nullptr, measured, *plan, test.name);
    const auto reduced = ReduceText(LogOf({&measured.columns.back()}, readings.size()),
                                    TemplateOf({&measured.columns.back()}), nullptr, *plan);
    ASSERT_TRUE(reduced.ok());
    if (test.name == "tool-setter") {
      EXPECT_TRUE(toolsetter::ReadRodSession(reduced->session).ok());
    } else {
      EXPECT_TRUE(toolsetter::ReadCurveSession(reduced->session).ok());
    }
  }
}

// A control prints all its axes where the beam triggers: Z is the reading, the others say nothing.
TEST(PlannedLogs, AToolSettersLogOfAxisPositions) {
  Machine machine = machine::testing::MultiTasking();
  const std::string text =
      "# machine: mt\n# session: rods\n# instrument: tool-setter\n# sigma_um: 0.5\n# tool_tip_mm: 0 0 0\n"
      "# beam: 0.2 0 0\n# rod one: 5 0.03 90 0 133.702 0\n# rod two: 5 0.03 89.9 127 160.591 0\n"
      "rod,readout,Z_mm\none,1,\none,2,\ntwo,1,\n";
  const Session plan = session::ReadPlanText(text, "plan.csv").value();
  machine.id = HeaderOf(plan, "machine");
  for (const Control& control : kControls) {
    std::string log;
    for (const double z_mm : {-376.586, -376.585, -349.701}) {
      std::vector<double> positions(machine.axis_count(), 12.5);
      positions[machine::FindAxis(machine, "Z")] = z_mm;
      log += Line(control.format, machine, positions);
    }
    const auto reduced = ReduceText(log, FindFormat(control.format).value(), &machine, plan);
    ASSERT_TRUE(reduced.ok()) << reduced.status();
    ASSERT_EQ(reduced->session.columns.size(), 3u);
    EXPECT_THAT(session::FindColumn(reduced->session, "rod")->texts, ::testing::ElementsAre("one", "one", "two"));
    EXPECT_THAT(session::FindColumn(reduced->session, "readout")->values, ::testing::ElementsAre(1, 2, 1));
    EXPECT_THAT(session::FindColumn(reduced->session, "Z_mm")->values,
                ::testing::ElementsAre(-376.586, -376.585, -349.701));
  }
  // What the log names is what the plan names, and without a plan it is enough.
  const std::string named = "ROD one\n-376.586\n-376.585\nROD two\n-349.701\n";
  const std::string rules = "line: {Z_mm}\nmark: ROD {rod}\naxis: Z 1 0.5\n";
  const auto by_log = ReduceText(named, ParseTemplate(rules, "t.txt").value(), nullptr, plan);
  ASSERT_TRUE(by_log.ok()) << by_log.status();
  EXPECT_EQ(session::FindColumn(by_log->session, "Z_mm")->values[2], -349.201);
  EXPECT_THAT(Refusal(ReduceText("ROD one\n-376.586\nROD two\n-349.701\n", ParseTemplate(rules, "t.txt").value(),
                                 nullptr, plan)),
              HasSubstr("probe.log: line 4: rod 'two', but line 2 of the plan is of 'one'"));
  const std::string header = text.substr(0, text.find("rod,readout"));
  std::istringstream in(named);
  const auto alone = Reduce(in, "probe.log", ParseTemplate(header + rules, "t.txt").value(), {});
  ASSERT_TRUE(alone.ok()) << alone.status();
  EXPECT_THAT(session::FindColumn(alone->session, "readout")->values, ::testing::ElementsAre(1, 2, 1));
  EXPECT_THAT(alone->notes, Contains(HasSubstr("readout: not in the log")));
}

// Instruments that no test plans.
TEST(PlannedLogs, EveryInstrumentsPlanTakesItsReadings) {
  const std::map<std::string, std::pair<std::string, std::vector<std::string>>> plans = {
      {"tracker", {"t_s,X_mm,C_deg\n0,1,2\n5,3,4\n", {"px_mm", "py_mm", "pz_mm"}}},
      {"eccentricity",
       {"# table_ball_mm: 50 0 65.5\n# bar_length_mm: 100\n# path BX: B 0 90 fixed 1 0 0\nrun,sense\nBX,1\nBX,-1\n",
        {"ex_um", "ez_um"}}}};
  for (const session::InstrumentFormat& format : session::InstrumentFormats()) {
    const auto of = plans.find(format.name);
    if (of == plans.end()) {  // planned by a test above
      const auto is_its = [&](const toolsetter::PlannableTest& test) { return test.name == format.name; };
      EXPECT_TRUE(instruments::FindInstrument(format.name) != nullptr ||
                  std::any_of(toolsetter::PlannableTests().begin(), toolsetter::PlannableTests().end(), is_its))
          << format.name << ": expected a plan of it here";
      continue;
    }
    const std::string header = absl::StrCat("# machine: mt\n# session: s\n# instrument: ", format.name,
                                            "\n# sigma_um: 1\n# tool_tip_mm: 0 0 0\n");
    const auto plan = session::ReadPlanText(header + of->second.first, "plan.csv");
    ASSERT_TRUE(plan.ok()) << plan.status();
    std::vector<Column> read;
    std::vector<const Column*> columns;
    for (const std::string& name : of->second.second) read.push_back({name, {1.5, -2.5}, {}});
    for (const Column& column : read) columns.push_back(&column);
    const auto reduced = ReduceText(LogOf(columns, 2), TemplateOf(columns), nullptr, *plan);
    ASSERT_TRUE(reduced.ok()) << format.name << reduced.status();
    for (const Column& column : read)
      EXPECT_EQ(session::FindColumn(reduced->session, column.name)->values, column.values) << column.name;
    EXPECT_TRUE(session::ReadSessionText(session::WriteSession(reduced->session).value(), "s.csv").ok());
  }
}

// The same run has two senses: which reading is missing, its name does not say.
TEST(PlannedLogs, ANameThatStandsForSeveralReadingsIsNotEnough) {
  const Session plan =
      session::ReadPlanText(
          "# machine: mt\n# session: s\n# instrument: eccentricity\n# sigma_um: 1\n# tool_tip_mm: 0 0 0\n"
          "run,sense\nBX,1\nBX,-1\n",
          "plan.csv")
          .value();
  const LogTemplate by_run = ParseTemplate("line: {run} = {ex_um}\n", "t.txt").value();
  EXPECT_THAT(Refusal(ReduceText("BX = 1.5\n", by_run, nullptr, plan)), HasSubstr("expected all of them"));
  EXPECT_THAT(Refusal(ReduceText("CR = 1.5\nBX = 2.5\n", by_run, nullptr, plan)),
              HasSubstr("probe.log: line 1: run 'CR', but line 1 of the plan is of 'BX'"));
}

// Five touches at each of seven poses, noise of `sigma_mm` along the way, spoilt by `spoil` before they are written.
absl::StatusOr<Reduced> TouchedSphere(double sigma_mm, const std::function<void(std::vector<std::string>*)>& spoil,
                                      const std::string& header_from = "", const std::string& header_to = "") {
  const Machine machine = machine::testing::MultiTasking();
  Session planned = plan::FindTest("sphere-probing")->plan(NeverMeasured(machine))[0].session;
  Session nothing_read = planned;
  for (const char* const name : {"cx_mm", "cy_mm", "cz_mm"})
    nothing_read.columns.push_back({name, std::vector<double>(planned.reading_count()), {}});
  const instruments::MeasuringRun run = instruments::BindSession(nothing_read, machine).value();
  const std::string program = plan::ToProgram(machine, planned, Dialect("fanuc")).value();
  base::Random random(3);
  std::vector<std::string> lines;
  for (const Way& way : Touches(machine, program)) {
    std::vector<double> at = Contact(machine, run, way, {0.1, 0.2, 0.3});
    double length_mm = 0.0;
    for (size_t i = 0; i < at.size(); ++i) {
      if (machine.axes[i].kind == machine::AxisKind::kLinear)
        length_mm = std::hypot(length_mm, way.to[i] - way.from[i]);
    }
    const double noise_mm = sigma_mm * random.Normal();
    for (size_t i = 0; i < at.size(); ++i) {
      if (machine.axes[i].kind == machine::AxisKind::kLinear) at[i] += noise_mm * (way.to[i] - way.from[i]) / length_mm;
    }
    lines.push_back(Line("dprnt", machine, at));
  }
  spoil(&lines);
  std::string log, table = plan::ToTable(planned);
  for (const std::string& line : lines) log += line;
  if (!header_from.empty()) table.replace(table.find(header_from), header_from.size(), header_to);
  return ReduceText(log, FindFormat("dprnt").value(), &machine, session::ReadPlanText(table, "plan.csv").value());
}

void Move(std::string* line, double mm) {  // along Y
  const size_t at = line->find('Y') + 1, end = line->find(' ', at);
  line->replace(at, end - at, absl::StrFormat("%.4f", std::stod(line->substr(at, end - at)) + mm));
}

TEST(PlannedLogs, CentresSayHowWellTheyAreKnown) {
  const auto as_it_is = [](std::vector<std::string>*) {};
  const auto quiet = TouchedSphere(0.0, as_it_is), noisy = TouchedSphere(5e-3, as_it_is);
  ASSERT_TRUE(quiet.ok() && noisy.ok()) << quiet.status() << noisy.status();
  EXPECT_EQ(HeaderOf(quiet->session, "sigma_um"), "2");
  // Five touches of 5 um: 0.82 of it across the tool, 2.24 along it.
  const double sigma_um = std::stod(HeaderOf(noisy->session, "sigma_um"));
  EXPECT_GT(sigma_um, 5.0);
  EXPECT_LT(sigma_um, 25.0);
  EXPECT_THAT(noisy->notes, Contains(HasSubstr("and not the stated 2")));
}

// A measured session is the plan of the same poses: what its own log said of it is not said of the next one.
TEST(PlannedLogs, ACentresSessionIsMeasuredAgain) {
  const Machine machine = machine::testing::MultiTasking();
  std::string log;
  const auto first = TouchedSphere(1e-4, [&](std::vector<std::string>* lines) {
    for (const std::string& line : *lines) log += line;
  });
  ASSERT_TRUE(first.ok()) << first.status();
  Session again = first->session;
  again.header.push_back({"cut_line", "line 9 of the log: 'X'"});
  const Session plan = session::ReadPlanText(session::WriteSession(again).value(), "plan.csv").value();
  const auto second = ReduceText(log, FindFormat("dprnt").value(), &machine, plan);
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_EQ(second->session, first->session);
}

TEST(PlannedLogs, ASphereThatWasNotTouchedAsPlannedGivesNoCentre) {
  // One of the sides, and the touch along the tool, which only the radius shows.
  for (const size_t touch : {2u, 0u}) {
    const auto reduced = TouchedSphere(0.0, [&](std::vector<std::string>* lines) {
      for (size_t i = 0; i < lines->size(); ++i) {
        if (i != 15 + touch) continue;
        Move(&(*lines)[i], 0.2);
        const size_t at = (*lines)[i].find('Z') + 1, end = (*lines)[i].find(' ', at);
        (*lines)[i].replace(at, end - at, absl::StrFormat("%.4f", std::stod((*lines)[i].substr(at, end - at)) + 0.15));
      }
    });
    ASSERT_TRUE(reduced.ok()) << reduced.status();
    EXPECT_EQ(reduced->session.reading_count(), 6u) << touch;
    EXPECT_THAT(reduced->notes, Contains(HasSubstr("left out: pose 4, lines 16 to 20"))) << touch;
  }
  const auto missing = TouchedSphere(0.0, [](std::vector<std::string>* lines) { lines->erase(lines->begin() + 7); });
  ASSERT_TRUE(missing.ok()) << missing.status();
  EXPECT_THAT(missing->notes, Contains(HasSubstr("left out: pose 2, lines 6 to 9: 4 touches do not fix")));
  EXPECT_EQ(session::FindColumn(missing->session, "t_s")->values[1], 120.0);
  const auto ended = TouchedSphere(0.0, [](std::vector<std::string>* lines) { lines->resize(30); });
  ASSERT_TRUE(ended.ok()) << ended.status();
  EXPECT_THAT(ended->notes, Contains(HasSubstr("the plan has 7 poses, the log touches at 6")));
  const auto no_pose = [](std::vector<std::string>* lines) { lines->erase(lines->begin() + 5, lines->begin() + 10); };
  EXPECT_THAT(Refusal(TouchedSphere(0.0, no_pose)), HasSubstr("probe.log: line 6: B_deg = "));
  const auto as_it_is = [](std::vector<std::string>*) {};
  EXPECT_THAT(Refusal(TouchedSphere(0.0, as_it_is, "stylus_radius_mm: 3", "stylus_radius_mm: 3.5")),
              HasSubstr("the touches lie on a radius of 15.4960 mm, expected 16.0000"));
  EXPECT_THAT(Refusal(TouchedSphere(0.0, as_it_is, "table_ball_mm: 40 0 60", "table_ball_mm: 40 30 60")),
              HasSubstr("mm off where the header's table_ball_mm puts it, expected within 25"));
  const auto moved = [](std::vector<std::string>* lines) {
    for (size_t i = 2; i < lines->size(); i += 5) Move(&(*lines)[i], 0.4);
  };
  EXPECT_THAT(Refusal(TouchedSphere(0.0, moved)), HasSubstr("of 7 poses give no centre"));
}

}  // namespace
}  // namespace axiscal::logs
