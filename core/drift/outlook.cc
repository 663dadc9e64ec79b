#include "core/drift/outlook.h"

#include <algorithm>
#include <cmath>

namespace axiscal::drift {
namespace {

// The prior of the scale: as if 12 calibrations had scattered by 1.2 times what they state.
constexpr double kPriorFreedom = 12.0, kPriorSquare = 1.44;
constexpr double kClip = 9.0;            // z^2 of one value counts as this at most
constexpr double kOutlier = 12.0;        // beyond it a value hardly moves the state
constexpr double kOutlierWeight = 0.02;  // of such a value
constexpr double kLeastKnown = 100.0;    // a stated variance above tells nothing of scatter
constexpr int kSettling = 2;             // values after a start without judgement

// Places in the lower triangle: level, slope, sine, cosine.
enum { kLL = 0, kSL = 1, kSS = 2, kAL = 3, kAS = 4, kAA = 5, kBL = 6, kBS = 7, kBA = 8, kBB = 9 };

void Predict(double rate, double weeks, OutlookModel* model) {
  std::array<double, 10>& p = model->covariance;
  model->mean[0] += weeks * model->mean[1];
  p[kLL] += weeks * (2.0 * p[kSL] + weeks * p[kSS]) + rate * rate * weeks;
  p[kSL] += weeks * p[kSS];
  p[kAL] += weeks * p[kAS];
  p[kBL] += weeks * p[kBS];
}

// covariance h of h = (1, 0, sine, cosine).
std::array<double, 4> Through(const OutlookModel& model, const Regressors& at) {
  const std::array<double, 10>& p = model.covariance;
  const double s = at[1], c = at[2];
  return {p[kLL] + s * p[kAL] + c * p[kBL], p[kSL] + s * p[kAS] + c * p[kBS], p[kAL] + s * p[kAA] + c * p[kBA],
          p[kBL] + s * p[kBA] + c * p[kBB]};
}

double ValueAt(const OutlookModel& model, const Regressors& at) {
  return model.mean[0] + at[1] * model.mean[2] + at[2] * model.mean[3];
}

}  // namespace

Outlook StartOutlook(double week, double level, double variance) {
  Outlook outlook;
  outlook.week = week;
  for (int k = 0; k < kModels; ++k) {
    OutlookModel& model = outlook.models[k];
    const double slope = kSlopeSizes[SlopeIndex(k)], season = kSeasonSizes[SeasonIndex(k)];
    model.mean[0] = level;
    model.covariance[kLL] = variance;
    model.covariance[kSS] = slope * slope;
    model.covariance[kAA] = model.covariance[kBB] = season * season;
  }
  return outlook;
}

double FreedomOf(const Outlook& outlook) { return kPriorFreedom + outlook.count; }

double ScaleOf(const Outlook& outlook, int model) {
  return (kPriorFreedom * kPriorSquare + outlook.models[model].squares) / FreedomOf(outlook);
}

void Absorb(double week, const Regressors& at, double y, double variance, Outlook* outlook) {
  const double weeks = week - outlook->week;
  outlook->week = week;
  const bool counts = variance < kLeastKnown && outlook->models[0].covariance[kLL] < kLeastKnown;
  for (int k = 0; k < kModels; ++k) {
    OutlookModel& model = outlook->models[k];
    Predict(kOutlookRates[RateIndex(k)], weeks, &model);
    const std::array<double, 4> through = Through(model, at);
    const double known = through[0] + at[1] * through[2] + at[2] * through[3];
    const double predicted = known + variance;
    const double off = y - ValueAt(model, at);
    const double square = off * off / predicted, scale = ScaleOf(*outlook, k);
    if (counts) {
      model.squares += std::min(square, kClip * scale);
      model.log_determinant += std::log(predicted);
    }
    const bool is_outlier = outlook->count >= kSettling && square > kOutlier * scale;
    const double trusted = is_outlier ? known + variance / kOutlierWeight : predicted;
    for (int i = 0; i < 4; ++i) model.mean[i] += through[i] / trusted * off;
    for (int i = 0, at_ij = 0; i < 4; ++i) {
      for (int j = 0; j <= i; ++j, ++at_ij) model.covariance[at_ij] -= through[i] * through[j] / trusted;
    }
  }
  outlook->count += counts;
}

void LoosenLevel(double variance, bool is_wear_new, Outlook* outlook) {
  for (int k = 0; k < kModels; ++k) {
    OutlookModel& model = outlook->models[k];
    model.covariance[kLL] += variance;
    if (!is_wear_new) continue;
    const double slope = kSlopeSizes[SlopeIndex(k)];
    model.mean[1] = 0.0;
    model.covariance[kSS] = slope * slope;
    for (const int cross : {kSL, kAS, kBS}) model.covariance[cross] = 0.0;
  }
}

void Rescale(double factor, Outlook* outlook) {
  for (OutlookModel& model : outlook->models) {
    for (double& mean : model.mean) mean /= factor;
    for (double& covariance : model.covariance) covariance /= factor * factor;
  }
}

const ModelWeights& FlatPrior() {
  // Most errors of most machines neither wander nor wear by what a calibration can see; a third of them know the
  // season.
  static const ModelWeights kPrior = [] {
    constexpr std::array<double, 5> kRate = {0.65, 0.13, 0.1, 0.07, 0.05};
    constexpr std::array<double, 3> kSlope = {0.8, 0.12, 0.08};
    constexpr std::array<double, 2> kSeason = {0.65, 0.35};
    ModelWeights prior;
    for (int k = 0; k < kModels; ++k) prior[k] = kRate[RateIndex(k)] * kSlope[SlopeIndex(k)] * kSeason[SeasonIndex(k)];
    return prior;
  }();
  return kPrior;
}

ModelWeights WeightsOf(const Outlook& outlook, const ModelWeights& prior) {
  ModelWeights weights;
  double most = -INFINITY, sum = 0.0;
  for (int k = 0; k < kModels; ++k) {
    const OutlookModel& model = outlook.models[k];
    weights[k] = std::log(prior[k]) - 0.5 * model.log_determinant -
                 0.5 * FreedomOf(outlook) * std::log(kPriorFreedom * kPriorSquare + model.squares);
    most = std::max(most, weights[k]);
  }
  for (double& weight : weights) sum += weight = std::exp(weight - most);
  for (double& weight : weights) weight /= sum;
  return weights;
}

Ahead LookAhead(const Outlook& outlook, int model, double weeks, const Regressors& at) {
  OutlookModel ahead = outlook.models[model];
  Predict(kOutlookRates[RateIndex(model)], weeks, &ahead);
  const std::array<double, 4> through = Through(ahead, at);
  return {ValueAt(ahead, at), std::max(0.0, through[0] + at[1] * through[2] + at[2] * through[3])};
}

}  // namespace axiscal::drift
