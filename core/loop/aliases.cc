#include "core/loop/aliases.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "core/base/random.h"

namespace axiscal::loop {
namespace {

// Mean of exp(i frequency position): of absolute value 1 where every position is the same point of the wave.
std::complex<double> MeanOf(const std::vector<double>& positions, double frequency) {
  double cosine = 0.0, sine = 0.0;
  for (const double position : positions) {
    cosine += std::cos(frequency * position);
    sine += std::sin(frequency * position);
  }
  return std::complex<double>(cosine, sine) / static_cast<double>(positions.size());
}

double Coherence(const std::vector<double>& positions, double frequency) {
  return std::abs(MeanOf(positions, frequency));
}

// The coherence at frequencies that rise from 0 by one step after the other: a multiplication a position, where
// Coherence() takes a sine and a cosine.
class Walk {
 public:
  Walk(const std::vector<double>& positions, double step)
      : phasors_(Eigen::ArrayXcd::Ones(static_cast<Eigen::Index>(positions.size()))), turns_(phasors_.size()) {
    for (size_t k = 0; k < positions.size(); ++k)
      turns_[static_cast<Eigen::Index>(k)] = std::polar(1.0, step * positions[k]);
  }
  double Next() {
    phasors_ *= turns_;
    return std::abs(phasors_.mean());
  }

 private:
  Eigen::ArrayXcd phasors_, turns_;  // exp(i frequency position), exp(i step position)
};

// A quarter of half the width of the peak of MeanOf() at 0.
double StepOf(const std::vector<double>& positions) {
  return 0.25 * std::numbers::pi / (positions.back() - positions.front());
}

// In ascending order, each once.
void SortOnce(std::vector<double>* positions) {
  constexpr double kSamePosition = 1e-6;  // rad or mm
  std::sort(positions->begin(), positions->end());
  positions->erase(std::unique(positions->begin(), positions->end(),
                               [](double a, double b) { return std::abs(a - b) < kSamePosition; }),
                   positions->end());
}

// Some of them by chance, which show where all are alike.
void Thin(std::vector<double>* positions) {
  constexpr size_t kLookedAt = 512;
  if (positions->size() <= kLookedAt) return;
  base::Random random(1);
  for (size_t k = 0; k < kLookedAt; ++k)
    std::swap((*positions)[k], (*positions)[k + static_cast<size_t>(random.Below(positions->size() - k))]);
  positions->resize(kLookedAt);
}

// The frequency near `frequency`, by at most `step`, of largest coherence.
double PeakNear(const std::vector<double>& positions, double frequency, double step) {
  double low = frequency - step, high = frequency + step;
  constexpr int kSteps = 40;
  for (int k = 0; k < kSteps; ++k) {
    const double third = (high - low) / 3.0;
    if (Coherence(positions, low + third) < Coherence(positions, high - third))
      low += third;
    else
      high -= third;
  }
  return 0.5 * (low + high);
}

}  // namespace

std::vector<Alias> AliasesOf(std::vector<double> positions, double frequency, double highest, double share) {
  SortOnce(&positions);
  std::vector<Alias> aliases;
  if (positions.size() < 3) return aliases;
  const double step = StepOf(positions), slowest = 2.0 * step;  // half a period in the range
  Thin(&positions);
  const double least = std::sqrt(std::max(0.0, 1.0 - share));
  const auto is_one = [step](double a, double b) { return std::abs(a - b) < 1e-4 * step; };
  const auto add = [&](double other, bool is_sum) {
    if (other < slowest || other > highest || is_one(other, frequency)) return;
    // exp(i f q) is near to exp(+-i other q) times this.
    const std::complex<double> factor =
        is_sum ? MeanOf(positions, frequency + other) : MeanOf(positions, frequency - other);
    if (std::abs(factor) < least) return;
    const double cosine = factor.real() / std::abs(factor), sine = factor.imag() / std::abs(factor);
    Alias alias;
    alias.frequency = other;
    // Real part of (a - i b) (cosine + i sine) exp(-+i other q).
    if (is_sum)
      alias.of_amplitudes << cosine, sine, sine, -cosine;
    else
      alias.of_amplitudes << cosine, sine, -sine, cosine;
    aliases.push_back(alias);
  };
  // Half a step beside a peak the coherence is lower by less than this.
  constexpr double kBesideThePeak = 0.9;
  Walk walk(positions, step);
  double before = 1.0, last = walk.Next();
  for (double apart = 2.0 * step; apart <= highest + frequency + step; apart += step) {
    const double next = walk.Next();
    if (last > before && last >= next && last > kBesideThePeak * least) {
      const double peak = PeakNear(positions, apart - step, step);
      add(peak - frequency, true);
      add(frequency + peak, false);
      add(frequency - peak, false);
    }
    before = std::exchange(last, next);
  }
  std::sort(aliases.begin(), aliases.end(), [](const Alias& a, const Alias& b) { return a.frequency < b.frequency; });
  // Half-way to a peak the sum and the difference are one wave.
  aliases.erase(std::unique(aliases.begin(), aliases.end(),
                            [&](const Alias& a, const Alias& b) { return is_one(a.frequency, b.frequency); }),
                aliases.end());
  return aliases;
}

double HighestFrequency(std::vector<double> positions, double limit) {
  SortOnce(&positions);
  if (positions.size() < 3) return 0.0;
  const double step = StepOf(positions);
  Thin(&positions);
  // A tenth of the squares of two waves differ.
  constexpr double kNearlyAlike = 0.95, kFallen = 0.5;
  bool has_fallen = false;
  Walk walk(positions, step);
  for (double frequency = step; frequency < 2.0 * limit; frequency += step) {
    const double coherence = walk.Next();
    has_fallen |= coherence < kFallen;
    if (has_fallen && coherence > kNearlyAlike) return 0.5 * frequency;
  }
  return has_fallen ? limit : 0.0;
}

std::vector<int> AliasOrders(std::vector<double> positions, int order, int highest) {
  // Of the squares at the positions; at even positions the images of whole orders are whole.
  constexpr double kMissed = 0.02, kWhole = 1e-3;
  std::vector<int> orders;
  for (const Alias& alias : AliasesOf(std::move(positions), order, highest + kWhole, kMissed)) {
    const auto whole = static_cast<int>(std::lround(alias.frequency));
    if (whole > order && std::abs(alias.frequency - whole) < kWhole) orders.push_back(whole);
  }
  return orders;
}

}  // namespace axiscal::loop
