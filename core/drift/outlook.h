// One error by itself for forecasts: level, wear and season under thirty models at once.
//   y = level + sin(phi) a + cos(phi) b + noise,  d level = slope dt + q dW,  slope ~ N(0, u^2), a, b ~ N(0, v^2)
// for each rate q, slope size u and season size v of a grid; the scale of all variances is integrated out, so that what
// is predicted has a Student distribution. Units: stated sigma of the error, weeks.
#ifndef AXISCAL_CORE_DRIFT_OUTLOOK_H_
#define AXISCAL_CORE_DRIFT_OUTLOOK_H_

#include <array>

#include "core/drift/joint_filter.h"

namespace axiscal::drift {

inline constexpr std::array<double, 5> kOutlookRates = {0.0, 0.03, 0.08, 0.2, 0.5};  // sigma per root of a week
inline constexpr std::array<double, 3> kSlopeSizes = {0.0, 0.02, 0.08};              // sigma per week
inline constexpr std::array<double, 2> kSeasonSizes = {0.0, 0.8};                    // sigma
inline constexpr int kModels = 30;

using ModelWeights = std::array<double, kModels>;

struct OutlookModel {
  std::array<double, 4> mean{};         // level, slope, sine, cosine
  std::array<double, 10> covariance{};  // lower triangle, row by row
  double log_determinant = 0.0;         // sum of ln of the predicted variances
  double squares = 0.0;                 // sum of z^2, clipped
};

struct Outlook {
  std::array<OutlookModel, kModels> models;
  int count = 0;      // values that tell of scatter
  double week = 0.0;  // of the last one
};

// Rate, slope and season of a model: kOutlookRates[Rate(k)] and so on.
inline int RateIndex(int model) { return model / 6; }
inline int SlopeIndex(int model) { return model / 2 % 3; }
inline int SeasonIndex(int model) { return model % 2; }

// Nothing is known but that the level is near `level` with `variance`.
Outlook StartOutlook(double week, double level, double variance);
// At `week` the value `y` with the stated variance `variance`.
void Absorb(double week, const Regressors& at, double y, double variance, Outlook* outlook);
// The level may have jumped; with `is_wear_new` the wear is another from now on, too.
void LoosenLevel(double variance, bool is_wear_new, Outlook* outlook);
// As if the unit were `factor` times as large.
void Rescale(double factor, Outlook* outlook);

// Weights of the models for one error: prior times evidence; they sum to 1.
ModelWeights WeightsOf(const Outlook& outlook, const ModelWeights& prior);
// Without knowledge of the group.
const ModelWeights& FlatPrior();

// The scale of the variances of a model: squared, and the degrees of freedom of its Student distribution.
double ScaleOf(const Outlook& outlook, int model);
double FreedomOf(const Outlook& outlook);

// `weeks` later: mean and variance (before the scale) of the level with its season.
struct Ahead {
  double mean = 0.0, variance = 0.0;
};
Ahead LookAhead(const Outlook& outlook, int model, double weeks, const Regressors& at);

}  // namespace axiscal::drift

#endif  // AXISCAL_CORE_DRIFT_OUTLOOK_H_
