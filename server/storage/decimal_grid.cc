#include "server/storage/decimal_grid.h"

#include <bit>
#include <cmath>

#include "server/storage/bytes.h"

namespace axiscal::storage {
namespace {

// Powers of ten are exact doubles, so n / 10^d is the double next to that decimal: what a correct reader of text makes
// of it.
constexpr double kPowers[kMaxDecimals + 1] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12};

// Rounds |scaled| < 2^51 to the nearest integer, by letting the sum have no bits behind the point. Anything else gives
// a wrong integer, which the comparison that always follows refuses.
int64_t Round(double scaled) {
  constexpr double kMagic = 6755399441055744.0;  // 1.5 * 2^52
  return std::bit_cast<int64_t>(scaled + kMagic) - std::bit_cast<int64_t>(kMagic);
}

bool Returns(int64_t step, double power, double value) {
  constexpr double kMaxStep = 2251799813685248.0;  // 2^51
  return std::abs(value) * power < kMaxStep &&
         std::bit_cast<uint64_t>(static_cast<double>(step) / power) == std::bit_cast<uint64_t>(value);
}

// A value on a grid is on every finer one too (while its steps fit), so the finest that any value needs serves all.
int FindDecimals(const std::vector<double>& values) {
  int decimals = 0;
  for (const double value : values) {
    while (!Returns(Round(value * kPowers[decimals]), kPowers[decimals], value)) {
      if (++decimals > kMaxDecimals) return -1;
    }
  }
  return decimals;
}

uint64_t Unsigned(int64_t number) { return static_cast<uint64_t>(number); }

}  // namespace

std::optional<DecimalGrid> FindGrid(const std::vector<double>& values) {
  DecimalGrid grid;
  grid.decimals = FindDecimals(values);
  if (grid.decimals < 0) return std::nullopt;
  const double power = kPowers[grid.decimals];
  grid.steps.resize(values.size());
  bool exact = true;
  for (size_t i = 0; i < values.size(); ++i) {
    grid.steps[i] = Round(values[i] * power);
    exact &= Returns(grid.steps[i], power, values[i]);
  }
  if (!exact) return std::nullopt;
  return grid;
}

std::vector<double> FromGrid(const DecimalGrid& grid) {
  std::vector<double> values(grid.steps.size());
  for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(grid.steps[i]) / kPowers[grid.decimals];
  return values;
}

void Difference(std::vector<int64_t>& steps, int order) {
  for (int pass = 0; pass < order; ++pass) {
    for (size_t i = steps.size(); i-- > static_cast<size_t>(pass) + 1;) {
      steps[i] = static_cast<int64_t>(Unsigned(steps[i]) - Unsigned(steps[i - 1]));
    }
  }
}

void Integrate(std::vector<int64_t>& steps, int order) {
  for (int pass = order - 1; pass >= 0; --pass) {
    for (size_t i = static_cast<size_t>(pass) + 1; i < steps.size(); ++i) {
      steps[i] = static_cast<int64_t>(Unsigned(steps[i]) + Unsigned(steps[i - 1]));
    }
  }
}

int BestOrder(const std::vector<int64_t>& steps) {
  uint64_t bits[3] = {};
  for (size_t i = 2; i < steps.size(); ++i) {
    const int64_t first = steps[i] - steps[i - 1], second = first - (steps[i - 1] - steps[i - 2]);
    bits[0] += std::bit_width(ZigZag(steps[i]));
    bits[1] += std::bit_width(ZigZag(first));
    bits[2] += std::bit_width(ZigZag(second));
  }
  int best = 0;
  for (const int order : {1, 2}) best = bits[order] < bits[best] ? order : best;
  return best;
}

}  // namespace axiscal::storage
