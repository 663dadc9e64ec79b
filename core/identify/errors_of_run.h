// The errors that act at the readings of a problem, and what they do with each parameter: every shape is evaluated once
// per state for both.
#ifndef AXISCAL_CORE_IDENTIFY_ERRORS_OF_RUN_H_
#define AXISCAL_CORE_IDENTIFY_ERRORS_OF_RUN_H_

#include <vector>

#include "core/identify/problem.h"
#include "core/machine/joint_transforms.h"

namespace axiscal::identify {

// Fitted and fixed errors together; evaluated once where no term depends on the state. Problem and point must outlive
// it.
class ErrorsOfRun {
 public:
  // `parameters` in the order of the model's terms, none or some of ListParameters(point.model, true).
  ErrorsOfRun(const Problem& problem, const Point& point, const std::vector<Parameter>& parameters = {});

  bool is_constant() const { return is_constant_; }
  const machine::JointErrors<double>& At(const shapes::State& state);
  // The same as transforms.
  const machine::JointTransforms& TransformsAt(const shapes::State& state);
  // Per parameter, d(error component)/d(parameter) at the state of the last At().
  const Eigen::VectorXd& slopes() const { return slopes_; }

 private:
  struct Own {
    int at = 0;  // in slopes_
    int basis = 0;
    bool is_nonlinear = false;
  };
  // A term that adds something or has parameters.
  struct Part {
    const machine::ErrorTerm* term;
    int basis_count;
    bool adds;  // an amplitude is not zero
    std::vector<Own> parameters;
  };
  // Terms in their order. The sum starts from what the constant ones among the first are at any state.
  struct Sum {
    machine::JointErrors<double> constant;
    std::vector<Part> parts;
    bool is_constant = true;
  };

  static Sum SumOf(const machine::ErrorModel& model, const std::vector<Parameter>& parameters);
  void Add(const Sum& sum, const shapes::State& state, machine::JointErrors<double>* errors);

  const Sum fitted_, fixed_;
  const int joint_count_;
  const bool is_constant_, has_fixed_;
  bool is_evaluated_ = false, has_transforms_ = false;
  machine::JointErrors<double> errors_, fixed_errors_;
  machine::JointTransforms transforms_;
  Eigen::VectorXd slopes_;
};

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_ERRORS_OF_RUN_H_
