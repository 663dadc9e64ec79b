// What a control or an instrument prints of a session that was measured by its plan, and the way back: for tests.
#ifndef AXISCAL_CORE_LOGS_TESTING_PLANNED_LOG_H_
#define AXISCAL_CORE_LOGS_TESTING_PLANNED_LOG_H_

#include <absl/strings/str_format.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/logs/reduce.h"
#include "core/machine/machine.h"
#include "core/plan/program.h"
#include "core/session/column_rules.h"
#include "core/session/instrument_format.h"
#include "core/session/read_session.h"
#include "core/session/session.h"

namespace axiscal::logs::testing {

using machine::Machine;
using session::Column;
using session::Session;

inline std::string ColumnOf(const machine::Axis& axis) {
  return axis.name + (axis.kind == machine::AxisKind::kLinear ? "_mm" : "_deg");
}

inline std::string HeaderOf(const Session& session, const std::string& key) {
  return session::FindHeader(session, key).value_or("");
}

// Positions by axis (mm, deg) as a control prints them: "dprnt" and "sinumerik-write" by letters, "linuxcnc-probe" nine
// numbers.
inline std::string Line(const std::string& format, const Machine& machine, const std::vector<double>& positions) {
  std::string line;
  if (format != "linuxcnc-probe") {
    for (int i = 0; i < machine.axis_count(); ++i)
      absl::StrAppend(&line, machine.axes[i].name, absl::StrFormat("%.4f ", positions[i]));
    return line + "\n";
  }
  for (const char* const axis : {"X", "Y", "Z", "A", "B", "C", "U", "V", "W"}) {
    const int i = machine::FindAxis(machine, axis);
    absl::StrAppend(&line, absl::StrFormat("%.6f ", i < 0 ? 0.0 : positions[i]));
  }
  return line + "\n";
}

inline absl::StatusOr<Reduced> ReduceText(const std::string& log, const LogTemplate& log_template,
                                          const Machine* machine, const Session& plan) {
  std::istringstream in(log);
  return Reduce(in, "probe.log", log_template, {.machine = machine, .plan = &plan});
}

// The line's form, every column by its name; or only what the instrument read.
inline LogTemplate TemplateOf(const std::vector<const Column*>& columns) {
  std::string text = "line:";
  for (const Column* const column : columns) absl::StrAppend(&text, " ", column->name, "= {", column->name, "}");
  return ParseTemplate(text + "\n", "t.txt").value();
}

inline std::string LogOf(const std::vector<const Column*>& columns, size_t count) {
  std::string log;
  for (size_t k = 0; k < count; ++k) {
    for (const Column* const column : columns) {
      absl::StrAppend(&log, column->name, "= ",
                      column->texts.empty() ? absl::StrFormat("%.4f", column->values[k]) : column->texts[k], " ");
    }
    log += "\n";
  }
  return log;
}

inline bool IsReading(const Session& session, const Column& column) {
  for (const session::ReadingColumn& reading :
       session::FindInstrumentFormat(HeaderOf(session, "instrument"))->columns) {
    if (reading.name == column.name) return reading.source != session::ColumnSource::kPlan;
  }
  return column.name == "temp_C";
}

// `measured`, the planned session with its readings, as it comes back from a log with the plan beside it: of touches
// the positions at which a control latched, of everything else the readings alone, four decimals each.
inline absl::StatusOr<Session> ThroughLog(const Machine& machine, const Session& planned, const Session& measured) {
  ASSIGN_OR_RETURN(const Session plan, session::ReadPlanText(plan::ToTable(planned), "plan.csv"));
  std::string log;
  LogTemplate log_template;
  if (HeaderOf(planned, "instrument") == "touch") {
    ASSIGN_OR_RETURN(log_template, FindFormat("dprnt"));
    for (size_t k = 0; k < measured.reading_count(); ++k) {
      std::vector<double> positions;
      for (const machine::Axis& axis : machine.axes)
        positions.push_back(session::FindColumn(measured, ColumnOf(axis))->values[k]);
      log += Line("dprnt", machine, positions);
    }
  } else {
    std::vector<const Column*> read;
    for (const Column& column : measured.columns) {
      if (IsReading(measured, column)) read.push_back(&column);
    }
    log = LogOf(read, measured.reading_count());
    log_template = TemplateOf(read);
  }
  ASSIGN_OR_RETURN(Reduced reduced, ReduceText(log, log_template, &machine, plan));
  return std::move(reduced.session);
}

}  // namespace axiscal::logs::testing

#endif  // AXISCAL_CORE_LOGS_TESTING_PLANNED_LOG_H_
