// The lines of a controller's log that hold readings, as a template says.
#ifndef AXISCAL_CORE_LOGS_LOG_READER_H_
#define AXISCAL_CORE_LOGS_LOG_READER_H_

#include <functional>
#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/logs/log_template.h"

namespace axiscal::logs {

struct LogReading {
  size_t line = 0;                 // of the log, from 1
  std::vector<FieldValue> fields;  // per piece of the pattern
  std::string feature;             // of the last mark, empty before the first
};

// Where a log is wrong, from 1. Facts of an error, reason LOG_INVALID: `line`, `column`, `name`.
struct LogPlace {
  size_t line = 0;
  size_t column = 0;      // character; 0: the line as a whole
  std::string name = {};  // what it was read as, such as X_mm; empty: not known
};
// INVALID_ARGUMENT that names the place for programs; `message` says it for people.
absl::Status WrongAt(const LogPlace& place, const std::string& message);

// The log stopped within this line: no reading is made of it.
struct CutLine {
  size_t line = 0;
  std::string text;
};

// "Number of Points 40", and how many readings followed.
struct Announcement {
  size_t line = 0;
  long announced = 0, found = 0;
};

struct Log {
  std::vector<LogReading> readings;
  std::optional<CutLine> cut;
  std::vector<Announcement> announcements;  // in which `announced` differs from `found`
};

// Blank lines, lines of '%' and what a control sends at the end of a file (0x1A) are passed over; every other line is a
// reading or has a rule. The last line is cut, not wrong, where it has no line end (a cut number cannot be told from a
// whole one), where it ends before its form does, or where its last number has fewer decimals than all before it.
// INVALID_ARGUMENT naming log, line, column and what the template expected, as WrongAt() where it is about a line.
// CANCELLED where `cancelled`, asked now and then, says so.
absl::StatusOr<Log> ReadLog(std::istream& in, const std::string& log_name, const LogTemplate& log_template,
                            const LinePattern& line_pattern, const std::function<bool()>& cancelled = nullptr);

}  // namespace axiscal::logs

#endif  // AXISCAL_CORE_LOGS_LOG_READER_H_
