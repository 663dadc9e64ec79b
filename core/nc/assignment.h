// Variables of a program that are set to a number.
#ifndef AXISCAL_CORE_NC_ASSIGNMENT_H_
#define AXISCAL_CORE_NC_ASSIGNMENT_H_

#include <optional>
#include <string>
#include <utility>

#include "core/nc/variables.h"

namespace axiscal::nc {

// A variable by name and its value; none: not known.
using Assigned = std::pair<std::string, std::optional<double>>;

// The end of the assignment that begins at `at`: "#100 = -5.2", "#<depth>=3", "R1=3", "_TOL=0.01"; in Klartext the rest
// of the block. nullptr when no assignment begins there, when its variable is one of the controller (#5221 is a work
// offset), or when its value is neither a plain number nor an expression of `variables` (nullptr: none is known).
// `is_first`: no word stands in front of it.
const char* EndOfAssignment(const char* at, const char* end, bool is_first, const Dialect& dialect,
                            const Variables* variables, Assigned* assigned);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_ASSIGNMENT_H_
