#include "core/compensate/nodes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/demand.h"

namespace axiscal::compensate {
namespace {

// Index of the node below each sample (the last piece's for the end), walking along.
class Walk {
 public:
  explicit Walk(const std::vector<double>& nodes) : nodes_(nodes) {}
  // Weight of the upper node; `lower` is set. Outside the nodes the end's value holds.
  double At(double position, size_t* lower) {
    while (piece_ + 2 < nodes_.size() && position > nodes_[piece_ + 1]) ++piece_;
    *lower = piece_;
    const double weight = (position - nodes_[piece_]) / (nodes_[piece_ + 1] - nodes_[piece_]);
    return std::clamp(weight, 0.0, 1.0);
  }

 private:
  const std::vector<double>& nodes_;
  size_t piece_ = 0;
};

double Departure(const std::vector<double>& position, const std::vector<double>& values,
                 const std::vector<double>& nodes, const std::vector<double>& fitted) {
  Walk walk(nodes);
  double largest = 0.0;
  for (size_t i = 0; i < position.size(); ++i) {
    size_t lower;
    const double weight = walk.At(position[i], &lower);
    largest = std::max(largest, std::abs(values[i] - (1.0 - weight) * fitted[lower] - weight * fitted[lower + 1]));
  }
  return largest;
}

// The curve's own values at the nodes; linear between its samples.
std::vector<double> OwnValues(const std::vector<double>& position, const std::vector<double>& values,
                              const std::vector<double>& nodes) {
  Walk walk(position);
  std::vector<double> own;
  for (const double node : nodes) {
    size_t lower;
    const double weight = walk.At(node, &lower);
    own.push_back((1.0 - weight) * values[lower] + weight * values[lower + 1]);
  }
  return own;
}

// Least squares over hat functions: normal equations are tridiagonal (Thomas). Empty when a node has no sample.
std::vector<double> LeastSquares(const std::vector<double>& position, const std::vector<double>& values,
                                 const std::vector<double>& nodes) {
  const size_t n = nodes.size();
  std::vector<double> diagonal(n, 0.0), upper(n, 0.0), right(n, 0.0);
  Walk walk(nodes);
  for (size_t i = 0; i < position.size(); ++i) {
    size_t k;
    const double b = walk.At(position[i], &k), a = 1.0 - b;
    diagonal[k] += a * a;
    diagonal[k + 1] += b * b;
    upper[k] += a * b;
    right[k] += a * values[i];
    right[k + 1] += b * values[i];
  }
  for (size_t k = 0; k < n; ++k) {
    if (k > 0) {
      const double factor = upper[k - 1] / diagonal[k - 1];
      diagonal[k] -= factor * upper[k - 1];
      right[k] -= factor * right[k - 1];
    }
    if (!(diagonal[k] > 1e-6)) return {};
  }
  for (size_t k = n; k-- > 0;) right[k] = (right[k] - (k + 1 < n ? upper[k] * right[k + 1] : 0.0)) / diagonal[k];
  return right;
}

}  // namespace

std::vector<size_t> FreeNodes(const Curve& curve, double tolerance, size_t max_nodes) {
  const size_t samples = curve.position.size(), functions = curve.values.size();
  DEMAND(samples >= 2);
  std::vector<size_t> nodes = {0};
  std::vector<double> low(functions), high(functions);
  while (nodes.back() + 1 < samples) {
    if (nodes.size() == max_nodes) return {};
    const size_t from = nodes.back();
    size_t reached = from + 1;
    // The slopes of straight lines from here that pass all samples so far within the tolerance.
    std::fill(low.begin(), low.end(), -std::numeric_limits<double>::infinity());
    std::fill(high.begin(), high.end(), std::numeric_limits<double>::infinity());
    for (size_t i = from + 1; i < samples; ++i) {
      const double distance = curve.position[i] - curve.position[from];
      bool is_open = true, passes = true;
      for (size_t f = 0; f < functions; ++f) {
        const double rise = curve.values[f][i] - curve.values[f][from];
        passes &= rise / distance >= low[f] && rise / distance <= high[f];
        low[f] = std::max(low[f], (rise - tolerance) / distance);
        high[f] = std::min(high[f], (rise + tolerance) / distance);
        is_open &= low[f] <= high[f];
      }
      if (passes) reached = i;
      if (!is_open) break;
    }
    nodes.push_back(reached);
  }
  return nodes;
}

std::vector<size_t> BestFreeNodes(const Curve& curve, size_t max_nodes) {
  DEMAND(max_nodes >= 2);
  std::vector<size_t> best = FreeNodes(curve, 1.0, max_nodes);
  if (!best.empty()) return best;
  double too_small = 1.0, enough = 2.0;
  while ((best = FreeNodes(curve, enough, max_nodes)).empty()) {
    too_small = enough;
    enough *= 2.0;
  }
  while (enough > 1.02 * too_small) {
    const double middle = std::sqrt(too_small * enough);
    std::vector<size_t> nodes = FreeNodes(curve, middle, max_nodes);
    (nodes.empty() ? too_small : enough) = middle;
    if (!nodes.empty()) best = std::move(nodes);
  }
  return best;
}

std::vector<double> FitNodes(const std::vector<double>& position, const std::vector<double>& values,
                             const std::vector<double>& nodes) {
  DEMAND(nodes.size() >= 2 && position.size() >= 2);
  std::vector<double> own = OwnValues(position, values, nodes);
  std::vector<double> fitted = LeastSquares(position, values, nodes);
  if (fitted.empty()) return own;
  return Departure(position, values, nodes, fitted) < Departure(position, values, nodes, own) ? fitted : own;
}

double LargestDeparture(const Curve& curve, const std::vector<double>& nodes) {
  double largest = 0.0;
  for (const std::vector<double>& values : curve.values)
    largest = std::max(largest, Departure(curve.position, values, nodes, FitNodes(curve.position, values, nodes)));
  return largest;
}

double LargestOwnDeparture(const Curve& curve, const std::vector<double>& nodes) {
  double largest = 0.0;
  for (const std::vector<double>& values : curve.values)
    largest = std::max(largest, Departure(curve.position, values, nodes, OwnValues(curve.position, values, nodes)));
  return largest;
}

}  // namespace axiscal::compensate
