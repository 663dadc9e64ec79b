#include "core/drift/peers.h"

#include <cmath>

#include "core/drift/student.h"

namespace axiscal::drift {
namespace {

constexpr double kRounding = 1e-12;

}  // namespace

std::optional<Unlikeness> UnlikePeers(double value, double sigma, const std::vector<double>& peers) {
  if (peers.size() < static_cast<size_t>(kLeastPeers)) return std::nullopt;
  const auto count = static_cast<double>(peers.size());
  Unlikeness unlike;
  for (const double peer : peers) unlike.usual += peer;
  unlike.usual /= count;
  double squares = 0.0;
  for (const double peer : peers) squares += (peer - unlike.usual) * (peer - unlike.usual);
  unlike.spread = std::sqrt(squares / (count - 1.0));
  // Of equal values a sum leaves rounding.
  if (unlike.spread <= kRounding * std::abs(unlike.usual)) return std::nullopt;
  unlike.away = value - unlike.usual;
  unlike.sigma = std::sqrt(unlike.spread * unlike.spread * (1.0 + 1.0 / count) + sigma * sigma);
  unlike.probability = 2.0 * StudentBelow(-std::abs(unlike.away) / unlike.sigma, count - 1.0);
  return unlike;
}

}  // namespace axiscal::drift
