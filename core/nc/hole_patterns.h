// Patterns of holes of Sinumerik: HOLES1, a row, and HOLES2, a circle. They call the cycle of MCALL at positions that
// no word states, and are read as the blocks of these positions.
#ifndef AXISCAL_CORE_NC_HOLE_PATTERNS_H_
#define AXISCAL_CORE_NC_HOLE_PATTERNS_H_

#include <string>
#include <vector>

#include "core/nc/interpreter.h"

namespace axiscal::nc {

struct HolePattern {
  // In place of the line; none where it is no pattern, or cannot be followed.
  std::vector<std::string> lines;
  std::string problem;  // why not
};

// Whether the line, without its end, may be one. Inexpensive: every line is asked for.
bool MayBeHolePattern(const Dialect& dialect, const char* text, size_t size);
// `reader` stands in front of the line, which is given with its end.
HolePattern ReadHolePattern(const Interpreter& reader, const char* text, size_t size);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_HOLE_PATTERNS_H_
