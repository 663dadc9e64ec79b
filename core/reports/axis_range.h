// Positions of an axis, in reports.
#ifndef AXISCAL_CORE_REPORTS_AXIS_RANGE_H_
#define AXISCAL_CORE_REPORTS_AXIS_RANGE_H_

#include <limits>
#include <string>

#include "core/base/json_like.h"

namespace axiscal::reports {

// From the least to the greatest, in `unit` (mm, deg).
struct AxisRange {
  std::string axis = {};
  double from = std::numeric_limits<double>::quiet_NaN(), to = from;
  std::string unit = {};
};

template <typename Io>
void Members(Io& io, base::Like<Io, AxisRange> range) {
  io.Required("axis", range.axis);
  io.Member("from", range.from);
  io.Member("to", range.to);
  io.Member("unit", range.unit);
}

}  // namespace axiscal::reports

#endif  // AXISCAL_CORE_REPORTS_AXIS_RANGE_H_
