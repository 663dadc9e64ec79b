// Variables of a program that are set to a number.
#ifndef AXISCAL_CORE_NC_ASSIGNMENT_H_
#define AXISCAL_CORE_NC_ASSIGNMENT_H_

#include "core/nc/dialect.h"

namespace axiscal::nc {

// The end of the assignment that begins at `at`: "#100 = -5.2", "#<depth>=3", "R1=3", "_TOL=0.01"; in Klartext the rest
// of the block. nullptr when no assignment begins there, when its variable is one of the controller (#5221 is a work
// offset), or when its value is not a plain number. `is_first`: no word stands in front of it.
const char* EndOfAssignment(const char* at, const char* end, bool is_first, const Dialect& dialect);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_ASSIGNMENT_H_
