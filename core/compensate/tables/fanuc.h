// What Fanuc's two table formats share: data between two lines `%`, and behind them, where the control reads no more,
// notes in parentheses. A note `(KEY name=value ...)` says what stands in parameters.
#ifndef AXISCAL_CORE_COMPENSATE_TABLES_FANUC_H_
#define AXISCAL_CORE_COMPENSATE_TABLES_FANUC_H_

#include <map>
#include <string>
#include <vector>

#include "core/base/status.h"

namespace axiscal::tables {

struct FanucNote {
  size_t line = 0;
  std::string key;
  std::map<std::string, std::string> values;
};

struct FanucFile {
  std::vector<std::pair<size_t, std::string>> data;  // line number and text, without those of '%'
  std::vector<FanucNote> notes;                      // those that begin with a key in capitals and '='
};

// INVALID_ARGUMENT when a '%' is missing or text stands where none may.
absl::StatusOr<FanucFile> ReadFanucFile(const std::string& text);
// A value of a note, as a number or a whole number; INVALID_ARGUMENT with line and name.
absl::StatusOr<double> NumberIn(const FanucNote& note, const std::string& name);
absl::StatusOr<int> IntegerIn(const FanucNote& note, const std::string& name);
// "N10005P-3": letters with whole numbers in this order; INVALID_ARGUMENT with the line.
absl::StatusOr<std::vector<int>> ReadWords(size_t line, const std::string& text, const std::string& letters);

// A note in parentheses with a line end; parentheses inside become brackets.
std::string FanucNoteText(const std::string& text);

}  // namespace axiscal::tables

#endif  // AXISCAL_CORE_COMPENSATE_TABLES_FANUC_H_
