#include "core/loop/aliases.h"

#include <algorithm>
#include <cmath>

namespace axiscal::loop {
namespace {

// |mean of exp(i frequency position)|: 1 where every position is the same point of the wave.
double Coherence(const std::vector<double>& positions, double frequency) {
  double cosine = 0.0, sine = 0.0;
  for (const double position : positions) {
    cosine += std::cos(frequency * position);
    sine += std::sin(frequency * position);
  }
  return std::hypot(cosine, sine) / static_cast<double>(positions.size());
}

}  // namespace

std::vector<int> AliasOrders(std::vector<double> positions, int order, int highest) {
  constexpr double kSamePosition = 1e-6;  // rad
  std::sort(positions.begin(), positions.end());
  positions.erase(std::unique(positions.begin(), positions.end(),
                              [](double a, double b) { return std::abs(a - b) < kSamePosition; }),
                  positions.end());
  std::vector<int> orders;
  if (positions.empty()) return orders;
  constexpr double kAlike = 0.99;
  for (int other = order + 1; other <= highest; ++other) {
    if (Coherence(positions, other - order) > kAlike || Coherence(positions, other + order) > kAlike)
      orders.push_back(other);
  }
  return orders;
}

}  // namespace axiscal::loop
