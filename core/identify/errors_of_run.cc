#include "core/identify/errors_of_run.h"

#include "core/base/demand.h"

namespace axiscal::identify {

ErrorsOfRun::ErrorsOfRun(const Problem& problem, const Point& point, const std::vector<Parameter>& parameters)
    : fitted_(SumOf(point.model, parameters)),
      fixed_(SumOf(problem.fixed_model, {})),
      joint_count_(problem.machine->joint_count()),
      is_constant_(fitted_.is_constant && fixed_.is_constant),
      has_fixed_(!problem.fixed_model.terms.empty()),
      transforms_(*problem.machine),
      slopes_(Eigen::VectorXd::Ones(static_cast<Eigen::Index>(parameters.size()))) {}

ErrorsOfRun::Sum ErrorsOfRun::SumOf(const machine::ErrorModel& model, const std::vector<Parameter>& parameters) {
  Sum sum;
  size_t next = 0;
  for (size_t t = 0; t < model.terms.size(); ++t) {
    const machine::ErrorTerm& term = model.terms[t];
    Part part = {&term, shapes::BasisCount(term.shape), false, {}};
    for (int i = 0; i < part.basis_count; ++i) part.adds |= term.amplitude[i] != 0.0;
    for (; next < parameters.size() && parameters[next].term == static_cast<int>(t); ++next)
      part.parameters.push_back({static_cast<int>(next), parameters[next].basis, parameters[next].is_nonlinear});
    const bool is_constant = std::holds_alternative<shapes::Constant>(term.shape);
    sum.is_constant = sum.is_constant && is_constant;
    if (is_constant && sum.parts.empty()) {
      machine::AddErrors(term, {}, &sum.constant);  // the slope stays 1
    } else if (part.adds || !part.parameters.empty()) {
      sum.parts.push_back(std::move(part));
    }
  }
  DEMAND(next == parameters.size());
  return sum;
}

void ErrorsOfRun::Add(const Sum& sum, const shapes::State& state, machine::JointErrors<double>* errors) {
  *errors = sum.constant;
  double basis[shapes::kMaxBasisCount];
  for (const Part& part : sum.parts) {
    shapes::Basis(part.term->shape, state, basis);
    if (part.adds) machine::AddErrors(*part.term, part.basis_count, basis, state, errors);
    for (const Own& own : part.parameters) {
      double& slope = slopes_[own.at];
      if (!own.is_nonlinear) {
        slope = basis[own.basis];
        continue;
      }
      double by_parameter[shapes::kMaxBasisCount];
      shapes::BasisSlope(part.term->shape, state, by_parameter);
      slope = 0.0;
      for (int k = 0; k < part.basis_count; ++k) slope += part.term->amplitude[k] * by_parameter[k];
    }
  }
}

const machine::JointErrors<double>& ErrorsOfRun::At(const shapes::State& state) {
  if (is_constant_ && is_evaluated_) return errors_;
  Add(fitted_, state, &errors_);
  if (has_fixed_) {
    Add(fixed_, state, &fixed_errors_);
    for (int joint = 0; joint < joint_count_; ++joint) errors_[joint] += fixed_errors_[joint];
  }
  is_evaluated_ = true;
  return errors_;
}

const machine::JointTransforms& ErrorsOfRun::TransformsAt(const shapes::State& state) {
  if (is_constant_ && has_transforms_) return transforms_;
  transforms_.Set(At(state));
  has_transforms_ = true;
  return transforms_;
}

}  // namespace axiscal::identify
