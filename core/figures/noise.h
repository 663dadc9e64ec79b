// How far figures scatter by the stated repeatability of the readings, and what readings of this noise would show on a
// machine without errors.
#ifndef AXISCAL_CORE_FIGURES_NOISE_H_
#define AXISCAL_CORE_FIGURES_NOISE_H_

#include <functional>
#include <vector>

#include "core/figures/figures.h"

namespace axiscal::figures {

// All figures again, in the same order: draws of `noise` (normal, variance 1) times their sigma are added to what was
// measured or, `is_alone`, to the readings of a machine without errors.
using FiguresOfNoise = std::function<std::vector<Figure>(const std::function<double()>& noise, bool is_alone)>;

// The figures without noise, with `sigma_mm` and `of_noise_mm` filled from 100 draws of a fixed seed.
std::vector<Figure> WithNoise(const FiguresOfNoise& figures_of);

}  // namespace axiscal::figures

#endif  // AXISCAL_CORE_FIGURES_NOISE_H_
