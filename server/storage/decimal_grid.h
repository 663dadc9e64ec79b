// Decimals as integers: value = n / 10^decimals, exactly.
#ifndef AXISCAL_SERVER_STORAGE_DECIMAL_GRID_H_
#define AXISCAL_SERVER_STORAGE_DECIMAL_GRID_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace axiscal::storage {

struct DecimalGrid {
  int decimals = 0;
  std::vector<int64_t> steps;  // n of each value
};

inline constexpr int kMaxDecimals = 12;

// The coarsest grid from which every value comes back bit by bit (so no -0, no NaN), if there is one.
std::optional<DecimalGrid> FindGrid(const std::vector<double>& values);
// `decimals` 0 .. kMaxDecimals.
std::vector<double> FromGrid(const DecimalGrid& grid);

// Differences of `order` 0, 1 or 2 in place; the first `order` entries stay what they need to be undone. Wraps around,
// and so does the inverse.
void Difference(std::vector<int64_t>& steps, int order);
void Integrate(std::vector<int64_t>& steps, int order);
// The order whose differences have the fewest bits.
int BestOrder(const std::vector<int64_t>& steps);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_DECIMAL_GRID_H_
