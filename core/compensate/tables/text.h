// Numbers and lines of table files. Fixed notation only: no exponents, no "-0".
#ifndef AXISCAL_CORE_COMPENSATE_TABLES_TEXT_H_
#define AXISCAL_CORE_COMPENSATE_TABLES_TEXT_H_

#include <optional>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/machine/machine.h"

namespace axiscal::tables {

// mm or rad per unit of an axis' numbers in files: 1 of a linear axis, a degree of a rotary one.
double FileUnit(const machine::Axis& axis);
// "mm", "deg".
std::string UnitName(const machine::Axis& axis);

// The multiple of `step` that is nearest.
double Round(double value, double step);
// Decimals that show every multiple of `step` whole: 0.0005 has four. At most 12.
int DecimalsOf(double step);
// "-12.0500"; `value` is rounded to the decimals.
std::string Fixed(double value, int decimals);

// A decimal number as above, with or without sign and point; nothing for anything else, also for 1e-3, nan and 0x1.
std::optional<double> ParseFixed(const std::string& text);

// Lines without line ends (LF or CRLF); a last line without one counts too.
std::vector<std::string> Lines(const std::string& text);
std::vector<std::string> Words(const std::string& line);
std::vector<std::string> Split(const std::string& line, char separator);
std::string Strip(const std::string& text);

// "line 12: 'abc', expected ...". `line` counts from 1.
absl::Status BadLine(size_t line, const std::string& text, const std::string& expected);
// The axis of that name; INVALID_ARGUMENT with the line when the machine has none.
absl::StatusOr<int> AxisNamed(const machine::Machine& machine, const std::string& name, size_t line);
// INVALID_ARGUMENT when `position` does not lie above the last node.
absl::Status CheckIncreasing(const std::vector<double>& nodes, double position, size_t line);

// Node k of nodes at equal steps, as written: start + k * step.
std::vector<double> EqualNodes(double start, double step, size_t count);

}  // namespace axiscal::tables

#endif  // AXISCAL_CORE_COMPENSATE_TABLES_TEXT_H_
