// Random draws that are the same with every compiler and library: distributions of the standard library are not.
#ifndef AXISCAL_CORE_BASE_RANDOM_H_
#define AXISCAL_CORE_BASE_RANDOM_H_

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace axiscal::base {

// A Mersenne twister with normal draws by Box and Muller.
class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}
  // In (0, 1).
  double Uniform() { return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1p-53; }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  bool Chance(double share) { return Uniform() < share; }
  // One of 0 ... count - 1.
  int Below(size_t count) { return static_cast<int>(engine_() % count); }
  // Mean 0, variance 1.
  double Normal() { return std::sqrt(-2.0 * std::log(Uniform())) * std::cos(2.0 * std::numbers::pi * Uniform()); }

 private:
  std::mt19937_64 engine_;
};

// The seed of one of many streams: what stream 7 draws does not depend on who draws streams 0 to 6 (splitmix64).
inline uint64_t StreamSeed(uint64_t seed, uint64_t stream) {
  uint64_t mixed = seed + 0x9E3779B97F4A7C15u * (stream + 1);
  mixed = (mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9u;
  mixed = (mixed ^ (mixed >> 27)) * 0x94D049BB133111EBu;
  return mixed ^ (mixed >> 31);
}

// Noise of variance 1: a share of it is white, the rest first-order autoregressive (servo ripple remembers).
class RippleNoise {
 public:
  explicit RippleNoise(double ar1, double white_share = 0.0)
      : ar1_(ar1), fresh_(std::sqrt(1.0 - ar1 * ar1)), white_share_(white_share) {}
  double Next(Random& random) {
    const double fresh = random.Normal();
    value_ = is_first_ ? fresh : ar1_ * value_ + fresh_ * fresh;
    is_first_ = false;
    if (white_share_ == 0.0) return value_;
    return std::sqrt(1.0 - white_share_) * value_ + std::sqrt(white_share_) * random.Normal();
  }

 private:
  double ar1_, fresh_, white_share_, value_ = 0.0;
  bool is_first_ = true;
};

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_RANDOM_H_
