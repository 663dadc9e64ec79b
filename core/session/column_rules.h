// What the cells of each column of a session must be. Places are those of the session's file: the header lines, the
// line of column names, then one line per reading.
#ifndef AXISCAL_CORE_SESSION_COLUMN_RULES_H_
#define AXISCAL_CORE_SESSION_COLUMN_RULES_H_

#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/session/header_rules.h"
#include "core/session/session.h"

namespace axiscal::session {

inline constexpr size_t kMaxColumns = 64;

enum class ColumnKind {
  kTime,
  kTemperature,
  kLinearAxis,
  kRotaryAxis,
  kLinearEncoder,
  kRotaryEncoder,
  kSense,
  kReading,
  kName
};

// What a cell of one column must be.
struct ColumnRule {
  std::string name;
  ColumnKind kind = ColumnKind::kReading;
  std::string axis;  // of the column of an axis, its encoder or its sense: "X"
  double min = 0, max = 0;
  std::string expected;
  bool may_be_empty = false;
  std::set<std::string> names;  // kName: the names it may have, any when empty

  // NaN fits nothing.
  bool Fits(double number) const {
    return number >= min && number <= max && (!IsSense() || number == std::trunc(number));
  }
  // Of a commanded (or latched) position, in contrast to what an encoder shows beside it.
  bool IsAxis() const { return kind == ColumnKind::kLinearAxis || kind == ColumnKind::kRotaryAxis; }
  bool IsEncoder() const { return kind == ColumnKind::kLinearEncoder || kind == ColumnKind::kRotaryEncoder; }
  // Of the side from which an axis came to where it stands.
  bool IsSense() const { return kind == ColumnKind::kSense; }
  bool IsLinear() const { return kind == ColumnKind::kLinearAxis || kind == ColumnKind::kLinearEncoder; }
};

// The line, from 1, of reading `index` (from 0): of the session's file, or where the session was made of a log, of that
// (`of_log`, a line by reading).
inline size_t ReadingLine(size_t header_entries, size_t index, const std::vector<size_t>* of_log = nullptr) {
  return of_log != nullptr ? (*of_log)[index] : header_entries + 2 + index;
}
// "line 9, column 3 (Y_mm)": line from 1, column from 0.
std::string Place(size_t line, size_t column, const std::string& name);

// What is read: a session that was measured, or the plan of one, in which readings (ColumnSource) are empty or missing.
enum class SessionKind { kMeasured, kPlan };

// The rules of the columns in their order; the header must be valid. INVALID_ARGUMENT at a missing, unknown or
// duplicate column.
absl::StatusOr<std::vector<ColumnRule>> ColumnRules(const std::vector<HeaderEntry>& header,
                                                    const std::vector<std::string>& columns,
                                                    SessionKind kind = SessionKind::kMeasured);

// The rule of a column that says in which state a reading is taken, whatever the instrument: t_s, temp_C, T_NAME_C,
// X_mm, B_deg, X_enc_mm, B_enc_deg, X_sense. Nothing for any other.
std::optional<ColumnRule> StateColumnRule(const std::string& name);

// OK when `text` may stand in a name column of this rule; the message has no place.
absl::Status CheckName(const ColumnRule& rule, const std::string& text);

// An axis column's axis and kind ("X_mm": X, linear), or false.
bool ParseAxisColumn(const std::string& column, std::string* axis, ColumnKind* kind);

}  // namespace axiscal::session

#endif  // AXISCAL_CORE_SESSION_COLUMN_RULES_H_
