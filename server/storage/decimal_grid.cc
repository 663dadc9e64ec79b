#include "server/storage/decimal_grid.h"

#include <algorithm>
#include <bit>

#include "server/storage/bytes.h"

namespace axiscal::storage {
namespace {

// Powers of ten are exact doubles, so n / 10^d is the double next to that decimal: what a correct reader of text makes
// of it.
constexpr double kPowers[kMaxDecimals + 1] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12};

// Added to |number| < 2^51, the sum has no bits behind the point: it is rounded to an integer, whose bits are the
// number's own.
constexpr double kMagic = 6755399441055744.0;  // 1.5 * 2^52

// The values' steps of 1 / `power`; true when every value comes back from its step bit by bit. All are looked at,
// without a branch: most columns are a grid, and processors take such a loop several values at a time.
bool TakeSteps(const double* values, size_t count, double power, int64_t* steps) {
  uint64_t differing_bits = 0, sum_bits = 0;
  for (size_t i = 0; i < count; ++i) {
    const double sum = values[i] * power + kMagic;
    steps[i] = static_cast<int64_t>(std::bit_cast<uint64_t>(sum) - std::bit_cast<uint64_t>(kMagic));
    differing_bits |= std::bit_cast<uint64_t>((sum - kMagic) / power) ^ std::bit_cast<uint64_t>(values[i]);
    sum_bits |= std::bit_cast<uint64_t>(sum) ^ std::bit_cast<uint64_t>(kMagic);
  }
  // The number was below 2^51 where the sum has the sign and the exponent of the magic number.
  return differing_bits == 0 && sum_bits >> 52 == 0;
}

uint64_t Unsigned(int64_t number) { return static_cast<uint64_t>(number); }

}  // namespace

// A value on a grid is on every finer one too (while its steps fit), so the finest that any value needs serves all.
std::optional<DecimalGrid> FindGrid(const std::vector<double>& values) {
  constexpr size_t kBlock = 64;
  DecimalGrid grid;
  // Block after block on the same grid; on a finer one from the start. The first value goes alone: where nothing is a
  // grid, it mostly tells.
  for (size_t first = 0; first < values.size();) {
    const size_t count = first == 0 ? 1 : std::min(kBlock, values.size() - first);
    grid.steps.resize(std::max(grid.steps.size(), first + count));
    if (TakeSteps(&values[first], count, kPowers[grid.decimals], &grid.steps[first])) {
      first += count;
    } else if (++grid.decimals <= kMaxDecimals) {
      first = 0;
    } else {
      return std::nullopt;
    }
  }
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
