// Variables of a program that are set to a number.
#ifndef AXISCAL_CORE_NC_ASSIGNMENT_H_
#define AXISCAL_CORE_NC_ASSIGNMENT_H_

#include "core/nc/dialect.h"

namespace axiscal::nc {

// Where the assignment that begins at `at` ends: "#100 = -5.2", "#<depth>=3", "R1=3", "_TOL=0.01", of Klartext the rest
// of the block. nullptr: none does, or it is of a variable of the controller (#5221 is a work offset), or not of a
// plain number. `is_first`: no word stands in front of it.
const char* EndOfAssignment(const char* at, const char* end, bool is_first, const Dialect& dialect);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_ASSIGNMENT_H_
