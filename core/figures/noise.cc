#include "core/figures/noise.h"

#include <algorithm>
#include <cmath>

#include "core/base/random.h"

namespace axiscal::figures {

std::vector<Figure> WithNoise(const FiguresOfNoise& figures_of) {
  constexpr uint64_t kSeed = 230;
  constexpr int kDraws = 100;  // a standard deviation to 7 % of itself
  const auto none = [] { return 0.0; };
  std::vector<Figure> out = figures_of(none, false);
  std::vector<double> sums(out.size(), 0.0), squares(out.size(), 0.0), alone(out.size(), 0.0);
  base::Random random(kSeed);
  const auto draw = [&random] { return random.Normal(); };
  for (int i = 0; i < kDraws; ++i) {
    const std::vector<Figure> drawn = figures_of(draw, false), of_noise = figures_of(draw, true);
    for (size_t k = 0; k < out.size(); ++k) {
      sums[k] += drawn[k].value_mm;
      squares[k] += drawn[k].value_mm * drawn[k].value_mm;
      alone[k] += of_noise[k].value_mm / kDraws;
    }
  }
  for (size_t k = 0; k < out.size(); ++k) {
    const double mean = sums[k] / kDraws;
    out[k].sigma_mm = std::sqrt(std::max(0.0, squares[k] / kDraws - mean * mean));
    out[k].of_noise_mm = alone[k];
  }
  return out;
}

}  // namespace axiscal::figures
