// What speaks against a calibration, in the words of its report's JSON.
#ifndef AXISCAL_CORE_REPORTS_WARNING_KINDS_H_
#define AXISCAL_CORE_REPORTS_WARNING_KINDS_H_

#include <string>
#include <vector>

#include "core/reports/loop.h"
#include "core/reports/warning.h"

namespace axiscal::reports {

// The kinds of warnings, then of causes, each once: "size", "nominal".
std::vector<std::string> KindsOf(const std::vector<Warning>& warnings, const std::vector<Cause>& causes);

}  // namespace axiscal::reports

#endif  // AXISCAL_CORE_REPORTS_WARNING_KINDS_H_
