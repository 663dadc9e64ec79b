#include "core/drift/calibration.h"

#include <absl/strings/str_cat.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <set>

namespace axiscal::drift {
namespace {

constexpr size_t kMostSymbolBytes = 200;
constexpr double kColdestCelsius = -60.0, kHottestCelsius = 150.0;  // no machine is measured outside
constexpr double kMostValue = 1e9;  // um (a kilometre), urad: beyond it squares of small sigmas would be no numbers
constexpr double kLeastSigma = 1e-6, kMostSigma = 1e9;
constexpr double kRounding = 1e-6;  // of correlations that were written with six digits

absl::Status CheckCovariance(const Calibration& calibration) {
  const std::vector<Value>& values = calibration.values;
  const Eigen::MatrixXd& covariance = calibration.covariance;
  const auto count = static_cast<Eigen::Index>(values.size());
  if (covariance.rows() != count || covariance.cols() != count)
    return absl::InvalidArgumentError(absl::StrCat("covariance has ", covariance.rows(), " x ", covariance.cols(),
                                                   " numbers, expected ", count, " x ", count));
  for (Eigen::Index i = 0; i < count; ++i) {
    const double variance = covariance(i, i);
    if (!(variance >= kLeastSigma * kLeastSigma && variance <= kMostSigma * kMostSigma))
      return absl::InvalidArgumentError(absl::StrCat("variance of ", values[i].symbol, " = ", variance,
                                                     ", must be > 0, and its root ", kLeastSigma, " to ", kMostSigma));
  }
  Eigen::MatrixXd correlation(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < count; ++j) {
      correlation(i, j) = covariance(i, j) / std::sqrt(covariance(i, i)) / std::sqrt(covariance(j, j));
      if (std::isfinite(correlation(i, j)) && std::abs(correlation(i, j)) <= 1.0 + kRounding &&
          (j > i || std::abs(correlation(i, j) - correlation(j, i)) <= kRounding))
        continue;
      return absl::InvalidArgumentError(absl::StrCat("covariance of ", values[i].symbol, " and ", values[j].symbol,
                                                     " = ", covariance(i, j),
                                                     ", must be symmetric and at most the product of their sigmas"));
    }
  }
  const double least = -kRounding * static_cast<double>(count);
  const Eigen::MatrixXd lifted = correlation - least * Eigen::MatrixXd::Identity(count, count);
  if (Eigen::LLT<Eigen::MatrixXd>(lifted).info() == Eigen::Success) return absl::OkStatus();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation, Eigen::EigenvaluesOnly);
  if (eigen.eigenvalues()(0) < least)
    return absl::InvalidArgumentError(absl::StrCat("covariance: an eigenvalue of its correlations is ",
                                                   eigen.eigenvalues()(0), ", must not be negative"));
  return absl::OkStatus();
}

}  // namespace

const char* Text(Unit unit) { return unit == Unit::kUm ? "um" : "urad"; }

Eigen::MatrixXd Uncorrelated(const std::vector<double>& sigmas) {
  const auto count = static_cast<Eigen::Index>(sigmas.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index i = 0; i < count; ++i) covariance(i, i) = sigmas[i] * sigmas[i];
  return covariance;
}

absl::Status Check(const Calibration& calibration) {
  if (calibration.values.empty()) return absl::InvalidArgumentError("values: none, expected at least one");
  if (calibration.values.size() > kMostErrors)
    return absl::InvalidArgumentError(
        absl::StrCat("values: ", calibration.values.size(), " errors, expected at most ", kMostErrors));
  std::set<std::string> symbols;
  for (size_t i = 0; i < calibration.values.size(); ++i) {
    const Value& value = calibration.values[i];
    if (value.symbol.empty() || value.symbol.size() > kMostSymbolBytes)
      return absl::InvalidArgumentError(
          absl::StrCat("values[", i, "].symbol has ", value.symbol.size(), " bytes, expected 1 to ", kMostSymbolBytes));
    if (!symbols.insert(value.symbol).second)
      return absl::InvalidArgumentError(absl::StrCat("values[", i, "].symbol: '", value.symbol, "' is there twice"));
    if (!(std::abs(value.value) <= kMostValue))
      return absl::InvalidArgumentError(absl::StrCat("value of ", value.symbol, " = ", value.value,
                                                     ", must be finite and at most ", kMostValue, " to either side"));
  }
  if (const std::optional<double>& celsius = calibration.temperature_celsius;
      celsius && !(*celsius >= kColdestCelsius && *celsius <= kHottestCelsius))
    return absl::InvalidArgumentError(
        absl::StrCat("temperature_celsius = ", *celsius, ", must be ", kColdestCelsius, " to ", kHottestCelsius));
  return CheckCovariance(calibration);
}

}  // namespace axiscal::drift
