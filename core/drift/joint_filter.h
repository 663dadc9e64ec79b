// All errors of a machine together: a Kalman filter of their levels, seasons and reactions to temperature.
//   y = level + sin(phi) a + cos(phi) b + theta c + noise,   phi: phase of the year, theta: temperature
// State of n errors: level, a, b, c of n numbers each, one after the other. Units: stated sigma of each error.
#ifndef AXISCAL_CORE_DRIFT_JOINT_FILTER_H_
#define AXISCAL_CORE_DRIFT_JOINT_FILTER_H_

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "core/base/clock.h"

namespace axiscal::drift {

inline constexpr int kParts = 4;  // level, sine, cosine, temperature

struct Joint {
  Eigen::VectorXd mean;        // 4 n
  Eigen::MatrixXd covariance;  // 4 n x 4 n, symmetric
  int count() const { return static_cast<int>(mean.size()) / kParts; }
};

// What stands before level, sine, cosine and temperature at one moment: 1, sin, cos, theta.
using Regressors = std::array<double, kParts>;
Regressors RegressorsAt(base::UtcTime at, std::optional<double> temperature_celsius);

// H mean and, without the level, what season and temperature make of it; n numbers.
Eigen::VectorXd Predicted(const Joint& joint, const Regressors& at);
Eigen::VectorXd Seasonal(const Joint& joint, const Regressors& at);
// H covariance H', n x n.
Eigen::MatrixXd PredictedCovariance(const Joint& joint, const Regressors& at);

// The inverse of the rows and columns `of`, in their places among n x n zeros: what is not among them tells nothing.
Eigen::MatrixXd InverseOf(const Eigen::MatrixXd& matrix, const std::vector<int>& of);

// Measured `y` with `noise` (n, n x n) of the errors `seen`.
void Update(const Regressors& at, const Eigen::VectorXd& y, const Eigen::MatrixXd& noise, const std::vector<int>& seen,
            Joint* joint);

// Levels get more uncertain by these variances (n).
void Loosen(const Eigen::VectorXd& variances, Joint* joint);

}  // namespace axiscal::drift

#endif  // AXISCAL_CORE_DRIFT_JOINT_FILTER_H_
