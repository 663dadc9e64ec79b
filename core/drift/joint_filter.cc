#include "core/drift/joint_filter.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

namespace axiscal::drift {
namespace {

constexpr double kYearDays = 365.2425;
constexpr double kMiddleCelsius = 20.0, kUsualKelvin = 3.0;  // ISO 1; what shops differ from it by, so theta is about 1

}  // namespace

Regressors RegressorsAt(base::UtcTime at, std::optional<double> temperature_celsius) {
  const double days = static_cast<double>(base::ToUtcUs(at)) / 86'400e6;
  const double phase = 2.0 * std::numbers::pi * std::fmod(days / kYearDays, 1.0);
  return {1.0, std::sin(phase), std::cos(phase),
          temperature_celsius ? (*temperature_celsius - kMiddleCelsius) / kUsualKelvin : 0.0};
}

Eigen::VectorXd Predicted(const Joint& joint, const Regressors& at) {
  return joint.mean.head(joint.count()) + Seasonal(joint, at);
}

Eigen::VectorXd Seasonal(const Joint& joint, const Regressors& at) {
  const int n = joint.count();
  Eigen::VectorXd seasonal = Eigen::VectorXd::Zero(n);
  for (int part = 1; part < kParts; ++part) seasonal += at[part] * joint.mean.segment(part * n, n);
  return seasonal;
}

namespace {

// covariance H', 4 n x n.
Eigen::MatrixXd Through(const Joint& joint, const Regressors& at) {
  const int n = joint.count();
  Eigen::MatrixXd through = joint.covariance.leftCols(n);
  for (int part = 1; part < kParts; ++part) {
    if (at[part] != 0.0) through += at[part] * joint.covariance.middleCols(part * n, n);
  }
  return through;
}

Eigen::MatrixXd Gathered(const Eigen::MatrixXd& through, const Regressors& at) {
  const auto n = through.cols();
  Eigen::MatrixXd gathered = through.topRows(n);
  for (int part = 1; part < kParts; ++part) {
    if (at[part] != 0.0) gathered += at[part] * through.middleRows(part * n, n);
  }
  return gathered;
}

}  // namespace

Eigen::MatrixXd PredictedCovariance(const Joint& joint, const Regressors& at) {
  return Gathered(Through(joint, at), at);
}

Eigen::MatrixXd InverseOf(const Eigen::MatrixXd& matrix, const std::vector<int>& of) {
  const auto count = static_cast<Eigen::Index>(of.size());
  if (count == matrix.rows()) return Eigen::LLT<Eigen::MatrixXd>(matrix).solve(Eigen::MatrixXd::Identity(count, count));
  const Eigen::MatrixXd part = matrix(of, of);
  const Eigen::MatrixXd inverse = Eigen::LLT<Eigen::MatrixXd>(part).solve(Eigen::MatrixXd::Identity(count, count));
  Eigen::MatrixXd padded = Eigen::MatrixXd::Zero(matrix.rows(), matrix.cols());
  padded(of, of) = inverse;
  return padded;
}

void Update(const Regressors& at, const Eigen::VectorXd& y, const Eigen::MatrixXd& noise, const std::vector<int>& seen,
            Joint* joint) {
  const Eigen::MatrixXd through = Through(*joint, at);
  const Eigen::MatrixXd information = InverseOf(Gathered(through, at) + noise, seen);
  const Eigen::MatrixXd gain = through * information;  // columns of errors not seen are 0
  joint->mean += gain * (y - Predicted(*joint, at));
  joint->covariance.triangularView<Eigen::Lower>() -= gain * through.transpose();
  joint->covariance.triangularView<Eigen::StrictlyUpper>() = joint->covariance.transpose();
}

void Loosen(const Eigen::VectorXd& variances, Joint* joint) {
  joint->covariance.diagonal().head(variances.size()) += variances;
}

}  // namespace axiscal::drift
