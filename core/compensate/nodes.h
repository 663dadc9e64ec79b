// Where the nodes of a table's axis stand, and what their values are: as few nodes as keep the linear interpolation
// within a tolerance of the curve; where the controller holds fewer, all that it holds, with a larger tolerance.
#ifndef AXISCAL_CORE_COMPENSATE_NODES_H_
#define AXISCAL_CORE_COMPENSATE_NODES_H_

#include <vector>

#include "core/base/status.h"

namespace axiscal::compensate {

// Samples of several functions of one position. Values are in units of the tolerance: a departure of 1 is allowed.
struct Curve {
  std::vector<double> position;             // increasing, at least two
  std::vector<std::vector<double>> values;  // [function][sample]
};

// Indices of samples to put nodes at, the first and the last among them: each piece as long as it can be without
// departing by more than `tolerance` (of the values' unit). Empty when more than `max_nodes` are needed.
std::vector<size_t> FreeNodes(const Curve& curve, double tolerance, size_t max_nodes);

// The same with the smallest tolerance >= 1 that `max_nodes` (>= 2) allow.
std::vector<size_t> BestFreeNodes(const Curve& curve, size_t max_nodes);

// Values at `nodes` (increasing, spanning the curve) of a function: by least squares over all samples, or the curve's
// own values there, whichever has the smaller largest departure.
std::vector<double> FitNodes(const std::vector<double>& position, const std::vector<double>& values,
                             const std::vector<double>& nodes);

// The largest departure of the curve, over all functions, from the interpolation between its fitted values at `nodes`;
// the second function: between its own values there.
double LargestDeparture(const Curve& curve, const std::vector<double>& nodes);
double LargestOwnDeparture(const Curve& curve, const std::vector<double>& nodes);

}  // namespace axiscal::compensate

#endif  // AXISCAL_CORE_COMPENSATE_NODES_H_
