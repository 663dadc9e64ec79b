// What a machine's errors do to the tool at a pose, as the table sees it:
//   (ex, ey, ez) = tool point of the machine with its errors - tool point of the nominal machine, both in the table's
//                  frame (machine axes where every axis is at zero, carried by the last axis of the work branch)
//   (ea, eb, ec) = the rotation vector, about the table frame's x, y, z, that turns the nominal orientation of the tool
//                  into the actual one: R_actual R_nominal^T, right-handed
// So error = actual - nominal; a correction has the other sign. Both come from the one chain (core/machine/chain.h).
#ifndef AXISCAL_CORE_PREDICT_TOOL_POINT_H_
#define AXISCAL_CORE_PREDICT_TOOL_POINT_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/machine/error_covariance.h"
#include "core/machine/sensitivity.h"

namespace axiscal::predict {

using ToolPointError = Eigen::Matrix<double, 6, 1>;  // ex ey ez [mm], ea eb ec [rad]

// How the numbers of a model that are uncertain move the errors of the joints; the standard uncertainty of whatever the
// errors move, to first order.
class Propagation {
 public:
  // `model` must outlive it.
  Propagation(const machine::ErrorModel& model, const machine::ErrorCovariance& covariance);

  // Of r values: `by_error` is r x 6 joint_count, column 6 j + c: their derivative by component c of joint j (mm or rad
  // per mm or rad). `by_number` (r x numbers) is filled: the derivatives by the model's uncertain numbers at `state`.
  template <typename ByError>
  void ByNumber(const shapes::State& state, const ByError& by_error, Eigen::MatrixXd* by_number) const {
    by_number->setZero(by_error.rows(), static_cast<Eigen::Index>(numbers_.size()));
    for (size_t i = 0; i < numbers_.size(); ++i) {
      const double factor = FactorOf(numbers_[i], state);
      if (factor == 0.0) continue;
      auto column = by_number->col(static_cast<Eigen::Index>(i));
      const Eigen::Index first = machine::kComponents * numbers_[i].joint;
      if (numbers_[i].is_along_approach) {
        for (int c = 0; c < 3; ++c) column -= factor * state.approach.direction[c] * by_error.col(first + c);
      } else {
        column = factor * by_error.col(first + numbers_[i].component);
      }
    }
  }
  // covariance = root root'; a row per number.
  const Eigen::MatrixXd& root() const { return root_; }
  // Of the values whose derivatives these are.
  Eigen::VectorXd Sigma(const Eigen::MatrixXd& by_number) const { return (by_number * root_).rowwise().norm(); }
  // Variance by what is unknown at `state` beyond what the readings of an error reached (machine::UnknownAt).
  template <typename ByError>
  Eigen::VectorXd UnknownVariance(const shapes::State& state, const ByError& by_error) const {
    Eigen::VectorXd variance = Eigen::VectorXd::Zero(by_error.rows());
    for (const machine::ErrorTerm& term : reaching_) {
      const double unknown = machine::UnknownAt(term, state);
      if (unknown > 0.0)
        variance += unknown * unknown *
                    by_error.col(machine::kComponents * term.joint + static_cast<int>(term.component)).cwiseAbs2();
    }
    return variance;
  }

 private:
  struct Number {
    int joint = 0, component = 0;
    bool is_along_approach = false;
    shapes::Shape shape;
    std::array<double, shapes::kMaxBasisCount> amplitude;
    int basis = 0;
    bool is_nonlinear = false;
  };
  static double FactorOf(const Number& number, const shapes::State& state);

  std::vector<Number> numbers_;
  std::vector<machine::ErrorTerm> reaching_;  // that are known only as far as the readings reached
  Eigen::MatrixXd root_;
};

// The machine, the errors and the tool; DEMANDs nothing but valid ones. Not for use by two threads at once.
class ToolPoint {
 public:
  // `tip_mm`: nominal tool point at home, machine frame. All but the tip must outlive it.
  ToolPoint(const machine::Machine& machine, const machine::KnownErrors& errors, const Eigen::Vector3d& tip_mm)
      : machine_(machine), errors_(errors), tip_mm_(tip_mm), propagation_(errors.model, errors.covariance) {}

  ToolPointError ErrorAt(const shapes::State& state);
  // Standard uncertainty of each. Zero where the covariance is empty: ask that first.
  ToolPointError SigmaAt(const shapes::State& state);
  // Their derivatives (6 x numbers) by the model's uncertain numbers, in the order of the covariance. Until the next
  // call.
  const Eigen::MatrixXd& ByNumberAt(const shapes::State& state);
  const Propagation& propagation() const { return propagation_; }

 private:
  const machine::Machine& machine_;
  const machine::KnownErrors& errors_;
  const Eigen::Vector3d tip_mm_;
  const Propagation propagation_;
  machine::RelativePoint point_;
  Eigen::MatrixXd by_error_, by_number_;
};

// Errors that differ from zero and of which the covariance does not tell how good they are: taken for exact.
std::vector<std::string> TakenForExact(const machine::Machine& machine, const machine::KnownErrors& errors);

// machine::RequireState of the errors that differ from zero.
absl::Status RequireState(const machine::Machine& machine, const machine::ErrorModel& model, bool has_time,
                          const std::vector<std::string>& channels);

}  // namespace axiscal::predict

#endif  // AXISCAL_CORE_PREDICT_TOOL_POINT_H_
