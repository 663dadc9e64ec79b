#include "core/plan/program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/identify/testing/scenario.h"
#include "core/nc/decimal.h"
#include "core/nc/move_reader.h"
#include "core/plan/test.h"
#include "core/session/read_session.h"

namespace axiscal::plan {
namespace {

// Where the interpreter stands after each linear move of a program, per axis of the machine.
std::vector<std::vector<double>> Visited(machine::Machine machine, const std::string& program,
                                         const std::string& dialect) {
  for (machine::Axis& axis : machine.axes) {
    if (axis.kind == machine::AxisKind::kRotary) axis.roll_over = machine::RollOver::kNone;
  }
  nc::RewriteOptions options;
  options.dialect = dialect;
  auto interpreter = nc::Interpreter::Create(machine, options);
  EXPECT_TRUE(interpreter.ok()) << interpreter.status();
  const nc::ByteReader reader = nc::TextReader(program);
  nc::MoveReader moves(reader, *std::move(interpreter));
  std::vector<std::vector<double>> visited;
  nc::Event event;
  while (true) {
    const auto more = moves.Next(&event);
    EXPECT_TRUE(more.ok()) << more.status();
    if (!more.ok() || !*more) break;
    if (event.step.kind == nc::StepKind::kNone) continue;  // the end of the program
    EXPECT_EQ(event.step.kind, nc::StepKind::kMove) << dialect << " line " << event.line << ": " << event.step.reason;
    EXPECT_EQ(event.step.end.known, (1u << machine.axis_count()) - 1) << event.line;
    std::vector<double>& at = visited.emplace_back();
    for (int i = 0; i < machine.axis_count(); ++i)
      at.push_back(static_cast<double>(event.step.end.ticks[i]) / nc::kTicksPerUnit);
  }
  return visited;
}

const session::Column& ColumnOf(const session::Session& session, const machine::Axis& axis) {
  return *session::FindColumn(session, axis.name + (axis.kind == machine::AxisKind::kRotary ? "_deg" : "_mm"));
}

class EveryDialect : public ::testing::TestWithParam<std::string> {};

// What the program visits is the table: every test of the machine, read back by the interpreter.
TEST_P(EveryDialect, ProgramsVisitTheTablesPositions) {
  const machine::Machine machine = machine::testing::MultiTasking();
  Mounted mounted;
  mounted.tips_mm = {{0, 0, -356.4}};
  mounted.balls_mm = {{50, 0, 65.5}};
  const Situation situation = SituationOfMachine(machine, mounted);
  int programs = 0;
  for (const auto* tests : {&Tests(), &FurtherTests()}) {
    for (const plan::Test& test : *tests) {
      for (const PlannedSession& planned : test.plan(situation)) {
        const auto instrument = session::FindHeader(planned.session, "instrument");
        if (instrument == "centres" || instrument == "touch") continue;  // probing_program_test.cc, touch_tests_test.cc
        ProgramOptions options;
        options.dialect = GetParam();
        const auto program = ToProgram(machine, planned.session, options);
        ASSERT_TRUE(program.ok()) << program.status();
        const std::vector<std::vector<double>> visited = Visited(machine, *program, GetParam());
        size_t at = 0;
        for (size_t row = 0; row < planned.session.reading_count(); ++row) {
          const auto is_there = [&](size_t move) {
            for (int i = 0; i < machine.axis_count(); ++i)
              if (std::abs(visited[move][i] - ColumnOf(planned.session, machine.axes[i]).values[row]) > 5.1e-5)
                return false;
            return true;
          };
          // Beyond the target and back, where the stated side of approach asks for it.
          if (at + 1 < visited.size() && !is_there(at)) ++at;
          ASSERT_TRUE(at < visited.size() && is_there(at)) << planned.text << row;
          for (int i = 0; i < machine.axis_count(); ++i) {
            const session::Column* const sense = session::FindColumn(planned.session, machine.axes[i].name + "_sense");
            if (sense == nullptr || sense->values[row] == 0.0) continue;
            ASSERT_GT(at, 0u) << planned.text;
            ASSERT_GT((visited[at][i] - visited[at - 1][i]) * sense->values[row], 0.0) << planned.text << row;
          }
          ++at;
        }
        EXPECT_EQ(at, visited.size()) << planned.text;
        ++programs;
      }
    }
  }
  EXPECT_GT(programs, 30);
}

INSTANTIATE_TEST_SUITE_P(Programs, EveryDialect, ::testing::ValuesIn(ProgramDialects()));

TEST(Program, BallBarsRunAtTheirTimes) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const Situation situation = SituationOfMachine(machine, {});
  const auto program = ToProgram(machine, FindTest("ballbar-circle")->plan(situation)[0].session);
  ASSERT_TRUE(program.ok()) << program.status();
  EXPECT_NE(program->find("\nG93\n"), std::string::npos);
  EXPECT_NE(program->find("F240.0000\n"), std::string::npos);  // 0.25 s a reading
  EXPECT_EQ(program->find("G04"), std::string::npos);
  const auto at_rest = ToProgram(machine, FindTest("rtest-grid")->plan(situation)[0].session);
  ASSERT_TRUE(at_rest.ok());
  EXPECT_NE(at_rest->find("\nG04 P2000\n"), std::string::npos);
}

TEST(Program, TheTableIsASessionWithoutReadings) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const session::Session planned = FindTest("rtest-grid")->plan(SituationOfMachine(machine, {}))[0].session;
  std::string table = ToTable(planned);
  EXPECT_EQ(session::ReadSessionText(table, "t").status().code(),
            absl::StatusCode::kInvalidArgument);  // dx_mm is missing
  // Filled in, it reads as the session that was planned.
  std::string filled;
  size_t begin = 0;
  for (size_t end = table.find('\n'); end != std::string::npos; begin = end + 1, end = table.find('\n', begin)) {
    const std::string line = table.substr(begin, end - begin);
    filled += line + (line[0] == '#' ? "" : line[0] == 't' ? ",dx_mm,dy_mm,dz_mm" : ",0,0,0") + "\n";
  }
  const auto read = session::ReadSessionText(filled, "t");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->header, planned.header);
  for (size_t c = 0; c < planned.columns.size(); ++c) EXPECT_EQ(read->columns[c], planned.columns[c]);
}

// A short travel leaves room for the overrun at the ends, and one that is too short is no test.
TEST(Program, OverrunsKeepToTheTravel) {
  machine::Machine machine = machine::testing::MultiTasking();
  machine::Axis& x = machine.axes[machine::FindAxis(machine, "X")];
  x.min_position = 0.0;
  x.max_position = 20.0;
  const auto lines = FindTest("length-line")->plan(SituationOfMachine(machine, {}));
  ASSERT_EQ(lines.size(), 3u);
  for (const PlannedSession& line : lines) EXPECT_TRUE(ToProgram(machine, line.session).ok()) << line.text;
  // By hand: a target at the end of the travel that is to be approached from beyond it.
  session::Session by_hand = FindPlanned(SituationOfMachine(machine, {}), "line-X")->session;
  for (session::Column& column : by_hand.columns) {
    if (column.name != "X_mm") continue;
    const double last = *std::max_element(column.values.begin(), column.values.end());
    std::replace(column.values.begin(), column.values.end(), last, 19.0);
  }
  const auto refused = ToProgram(machine, by_hand);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_NE(refused.status().message().find("X must go to 21.0000 and back"), std::string::npos) << refused.status();
  x.max_position = 4.0;
  EXPECT_EQ(FindTest("length-line")->plan(SituationOfMachine(machine, {})).size(), 2u);
}

TEST(Program, RefusesWithWhatWasExpected) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const session::Session session = FindTest("rtest-grid")->plan(SituationOfMachine(machine, {}))[0].session;
  ProgramOptions options;
  options.dialect = "okuma";
  EXPECT_EQ(ToProgram(machine, session, options).status().code(), absl::StatusCode::kInvalidArgument);
  options = {};
  options.feed_mm_min = NAN;
  EXPECT_EQ(ToProgram(machine, session, options).status().code(), absl::StatusCode::kInvalidArgument);
  options = {};
  options.dwell_s = -1;
  EXPECT_EQ(ToProgram(machine, session, options).status().code(), absl::StatusCode::kInvalidArgument);
  machine::Machine other = machine;
  other.axes[0].name = "U";
  EXPECT_EQ(ToProgram(other, session, {}).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace axiscal::plan
