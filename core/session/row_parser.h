// What session files and files of poses share: header lines, and rows of cells that follow the rules of their columns.
#ifndef AXISCAL_CORE_SESSION_ROW_PARSER_H_
#define AXISCAL_CORE_SESSION_ROW_PARSER_H_

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/session/column_rules.h"
#include "core/session/line_reader.h"
#include "core/session/session.h"

namespace axiscal::session {

// INVALID_ARGUMENT for a last line without line end: a cut number cannot be told from a whole one.
absl::Status CheckLineEnd(const Line& line);

// Header lines '# key: value' up to the line of column names, which `line` is then. INVALID_ARGUMENT for anything else.
absl::StatusOr<std::vector<HeaderEntry>> ReadHeaderLines(LineReader& reader, Line* line);

std::vector<std::string> SplitCells(std::string_view text);

// Reads the lines behind the column names into columns. Both must outlive it; whoever empties the columns between two
// lines reads a file of any length in pieces.
class RowParser {
 public:
  RowParser(const std::vector<ColumnRule>& rules, std::vector<Column>& columns) : rules_(rules), columns_(columns) {}

  // Appends the row. INVALID_ARGUMENT naming line, column, value and rule; columns are then of unequal length.
  absl::Status Add(const Line& line);

 private:
  absl::Status Explain(const Line& line) const;
  std::string Problem(const ColumnRule& rule, const std::string& cell) const;

  const std::vector<ColumnRule>& rules_;
  std::vector<Column>& columns_;
  double last_time_s_ = -std::numeric_limits<double>::infinity();
  double time_before_s_ = last_time_s_;
};

}  // namespace axiscal::session

#endif  // AXISCAL_CORE_SESSION_ROW_PARSER_H_
