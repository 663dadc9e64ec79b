// What a difference of errors does at the tool point over a box of positions.
#ifndef AXISCAL_CORE_COMPARE_TOOL_POINT_H_
#define AXISCAL_CORE_COMPARE_TOOL_POINT_H_

#include "core/compare/compare.h"
#include "core/compare/numbers.h"

namespace axiscal::compare {

struct OverBox {
  ToolPointDifference difference;
  std::vector<double> rms_mm;  // of each number's difference alone
};

OverBox DifferenceOver(const machine::Machine& machine, const Side& first, const Side& second, const Numbers& numbers,
                       const predict::Workspace& workspace);

}  // namespace axiscal::compare

#endif  // AXISCAL_CORE_COMPARE_TOOL_POINT_H_
