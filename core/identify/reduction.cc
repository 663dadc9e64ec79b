#include "core/identify/reduction.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace axiscal::identify {
namespace {

// A symmetric positive block, factored with unit diagonal. Offsets that a session cannot tell apart leave it singular;
// the ridge, far below any reading's weight and far above rounding, keeps them where they are.
class ScaledFactor {
 public:
  explicit ScaledFactor(Eigen::MatrixXd block, double damping = 0.0) : scale_(block.rows()) {
    constexpr double kRidge = 1e-12;
    for (int i = 0; i < block.rows(); ++i) scale_[i] = block(i, i) > 0.0 ? 1.0 / std::sqrt(block(i, i)) : 0.0;
    block = scale_.asDiagonal() * block * scale_.asDiagonal();
    block.diagonal().array() += kRidge + damping;
    for (int i = 0; i < block.rows(); ++i) {
      if (scale_[i] == 0.0) block(i, i) = 1.0;
    }
    factor_.compute(block);
  }

  Eigen::MatrixXd Solve(const Eigen::MatrixXd& right) const {
    return scale_.asDiagonal() * factor_.solve(scale_.asDiagonal() * right);
  }

 private:
  Eigen::VectorXd scale_;
  Eigen::LDLT<Eigen::MatrixXd> factor_;
};

// One group's part of the arrow, setup block factored.
struct Eliminated {
  ScaledFactor setup;
  Eigen::MatrixXd setup_by_errors;  // s x p; zero for offsets that are held
  Eigen::VectorXd setup_gradient;   // s
};

Eliminated Eliminate(const SetupGroup& group, const Eigen::VectorXd& value, const GroupNormal& normal, Priors priors,
                     double damping = 0.0) {
  const int s = normal.setup_count, p = static_cast<int>(normal.gram.cols()) - s - 1;
  Eigen::MatrixXd block = normal.gram.topLeftCorner(s, s);
  Eigen::VectorXd gradient = normal.gram.col(s + p).head(s);
  Eigen::MatrixXd by_errors = normal.gram.block(0, s, s, p);
  for (int i = 0; i < s; ++i) {
    const std::optional<double>& held = group.parameters[i].held;
    if (held) {  // it stays where it starts: at its value
      block.row(i).setZero();
      block.col(i).setZero();
      by_errors.row(i).setZero();
      gradient[i] = 0.0;
      continue;
    }
    const double precision = PriorPrecision(group.parameters[i], priors);
    block(i, i) += precision;
    gradient[i] += value[i] * precision;
  }
  // Damped by the best-seen offset of the same unit: an offset that hardly shows in the readings (a ball across the
  // bar) must not be the one that is moved far where the model is wrong.
  double largest[2] = {0.0, 0.0};
  for (int i = 0; i < s; ++i)
    largest[group.parameters[i].is_angle] = std::max(largest[group.parameters[i].is_angle], block(i, i));
  // An offset whose whole effect is rounding (the table ball on an eccentricity) has none.
  constexpr double kRounding = 1e-9;
  for (int i = 0; i < s; ++i) {
    double& own = block(i, i);
    if (own <= kRounding * kRounding * largest[group.parameters[i].is_angle]) own = 0.0;
    own += damping * largest[group.parameters[i].is_angle];
  }
  return {ScaledFactor(std::move(block)), std::move(by_errors), std::move(gradient)};
}

int ErrorCount(const NormalEquations& normal) {
  const GroupNormal& first = normal.groups.front();
  return static_cast<int>(first.gram.cols()) - first.setup_count - 1;
}

std::vector<int> FreeErrors(int count, const std::vector<int>& held) {
  std::vector<int> free;
  for (int i = 0; i < count; ++i) {
    if (std::find(held.begin(), held.end(), i) == held.end()) free.push_back(i);
  }
  return free;
}

}  // namespace

double PriorPrecision(const instruments::SetupParameter& parameter, Priors priors) {
  if (!std::isfinite(parameter.prior_sigma) || (priors == Priors::kInformative && parameter.is_weak)) return 0.0;
  return 1.0 / (parameter.prior_sigma * parameter.prior_sigma);
}

Reduced Reduce(const Problem& problem, const Point& point, const NormalEquations& normal, Priors priors,
               double damping) {
  const int p = ErrorCount(normal);
  Reduced reduced{Eigen::MatrixXd::Zero(p, p), Eigen::VectorXd::Zero(p), Eigen::VectorXd::Zero(p)};
  for (size_t g = 0; g < normal.groups.size(); ++g) {
    const GroupNormal& block = normal.groups[g];
    const int s = block.setup_count;
    const Eliminated eliminated = Eliminate(problem.groups[g], point.setup[g], block, priors, damping);
    const auto own = block.gram.block(s, s, p, p);
    reduced.information +=
        own - eliminated.setup_by_errors.transpose() * eliminated.setup.Solve(eliminated.setup_by_errors);
    reduced.gradient += block.gram.col(s + p).segment(s, p) -
                        eliminated.setup_by_errors.transpose() * eliminated.setup.Solve(eliminated.setup_gradient);
    reduced.column_norm += own.diagonal();
  }
  for (int i = 0; i < static_cast<int>(normal.parameters.size()); ++i) {
    const Parameter& parameter = normal.parameters[static_cast<size_t>(i)];
    const double precision = PriorPrecision(point.model, parameter);
    if (precision == 0.0) continue;
    reduced.information(i, i) += precision;
    reduced.gradient[i] += precision * ValueOf(point.model, parameter);
    reduced.column_norm[i] += precision;
  }
  reduced.column_norm = reduced.column_norm.cwiseMax(0.0).cwiseSqrt();
  return reduced;
}

double LargestOf(const machine::ErrorModel& model, const Parameter& parameter) {
  if (parameter.is_nonlinear) return INFINITY;
  return machine::IsAngle(model.terms[parameter.term].component) ? kLargestErrorRad : kLargestErrorMm;
}

Reduced ReduceVisible(const Problem& problem, const Point& point, const NormalEquations& normal) {
  Reduced reduced = Reduce(problem, point, normal, Priors::kInformative);
  const std::vector<Parameter> parameters = ListParameters(point.model, false);
  for (size_t i = 0; i < parameters.size(); ++i) {
    if (reduced.column_norm[i] * LargestOf(point.model, parameters[i]) >= 1.0) continue;
    if (PriorPrecision(point.model, parameters[i]) > 0.0) continue;
    reduced.column_norm[i] = 0.0;
    reduced.information.row(i).setZero();
    reduced.information.col(i).setZero();
  }
  return reduced;
}

Eigen::MatrixXd InformationBeside(const Reduced& reduced, const std::vector<int>& kept) {
  const std::vector<int> others = FreeErrors(static_cast<int>(reduced.gradient.size()), kept);
  const Eigen::MatrixXd own = reduced.information(kept, kept);
  if (others.empty()) return own;
  const Eigen::MatrixXd cross = reduced.information(others, kept);
  return own - cross.transpose() * ScaledFactor(reduced.information(others, others)).Solve(cross);
}

Eigen::MatrixXd InverseBeside(const Reduced& reduced, const std::vector<int>& held) {
  const int p = static_cast<int>(reduced.gradient.size());
  const std::vector<int> free = FreeErrors(p, held);
  const int n = static_cast<int>(free.size());
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(p, p);
  inverse(free, free) = ScaledFactor(reduced.information(free, free)).Solve(Eigen::MatrixXd::Identity(n, n));
  return inverse;
}

GaussNewtonStep SolveStep(const Problem& problem, const Point& point, const NormalEquations& normal,
                          const std::vector<int>& held, double damping) {
  const Reduced reduced = Reduce(problem, point, normal, Priors::kAll, damping);
  GaussNewtonStep step;
  step.errors = Eigen::VectorXd::Zero(reduced.gradient.size());
  const std::vector<int> free = FreeErrors(static_cast<int>(reduced.gradient.size()), held);
  const Eigen::VectorXd gradient = reduced.gradient(free);
  const Eigen::VectorXd solution = -ScaledFactor(reduced.information(free, free), damping).Solve(gradient);
  for (size_t i = 0; i < free.size(); ++i) step.errors[free[i]] = solution[i];
  step.decrement = -gradient.dot(solution);
  for (size_t g = 0; g < normal.groups.size(); ++g) {
    const Eliminated eliminated = Eliminate(problem.groups[g], point.setup[g], normal.groups[g], Priors::kAll, damping);
    step.setup.push_back(-eliminated.setup.Solve(eliminated.setup_gradient + eliminated.setup_by_errors * step.errors));
    step.decrement += eliminated.setup_gradient.dot(eliminated.setup.Solve(eliminated.setup_gradient).col(0));
  }
  return step;
}

Covariance CovarianceOf(const Problem& problem, const Point& point, const NormalEquations& normal,
                        const std::vector<int>& held, double scale, const Eigen::MatrixXd& known) {
  const Reduced reduced = Reduce(problem, point, normal, Priors::kAll);
  const int p = static_cast<int>(reduced.gradient.size()), h = static_cast<int>(known.rows());
  Covariance out;
  out.errors = Eigen::MatrixXd::Zero(p, p);
  const std::vector<int> free = FreeErrors(p - h, held);
  const int n = static_cast<int>(free.size());
  const ScaledFactor information(reduced.information(free, free));
  out.errors(free, free) = scale * scale * information.Solve(Eigen::MatrixXd::Identity(n, n));
  const Eigen::MatrixXd as_stated = out.errors / (scale * scale);
  if (h > 0) {
    // A known error that is off by d moves the fitted ones by slopes * d.
    Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(p, h);
    slopes.bottomRows(h).setIdentity();
    const Eigen::MatrixXd by_known = reduced.information.rightCols(h);
    slopes(free, Eigen::all) = -information.Solve(by_known(free, Eigen::all));
    out.errors += slopes * known * slopes.transpose();
  }
  for (size_t g = 0; g < normal.groups.size(); ++g) {
    const Eliminated eliminated = Eliminate(problem.groups[g], point.setup[g], normal.groups[g], Priors::kAll);
    const int s = normal.groups[g].setup_count;
    const Eigen::MatrixXd by_errors = eliminated.setup.Solve(eliminated.setup_by_errors);
    const Eigen::MatrixXd own = scale * scale * eliminated.setup.Solve(Eigen::MatrixXd::Identity(s, s));
    Eigen::MatrixXd setup = own + by_errors * out.errors * by_errors.transpose();
    for (int i = 0; i < s; ++i) {
      if (!problem.groups[g].parameters[i].held) continue;
      setup.row(i).setZero();
      setup.col(i).setZero();
    }
    out.setup_sigma.push_back(setup.diagonal().cwiseMax(0.0).cwiseSqrt());
    out.setup.push_back(std::move(setup));
    out.with_setup.push_back(-as_stated * by_errors.transpose());
  }
  return out;
}

std::vector<Eigen::MatrixXd> StepsOf(const Problem& problem, const Point& point, const NormalEquations& normal,
                                     const std::vector<int>& held, const std::vector<Eigen::MatrixXd>& by_change) {
  const Reduced reduced = Reduce(problem, point, normal, Priors::kAll);
  const int p = static_cast<int>(reduced.gradient.size());
  const std::vector<int> free = FreeErrors(p, held);
  const ScaledFactor information(reduced.information(free, free));
  std::vector<Eigen::MatrixXd> steps;
  for (size_t g = 0; g < normal.groups.size(); ++g) {
    const Eliminated eliminated = Eliminate(problem.groups[g], point.setup[g], normal.groups[g], Priors::kAll);
    const int s = normal.groups[g].setup_count;
    Eigen::MatrixXd by_setup = by_change[g].topRows(s);
    for (int i = 0; i < s; ++i) {
      if (problem.groups[g].parameters[i].held) by_setup.row(i).setZero();
    }
    const Eigen::MatrixXd gradient =
        by_change[g].bottomRows(p) - eliminated.setup_by_errors.transpose() * eliminated.setup.Solve(by_setup);
    steps.push_back(Eigen::MatrixXd::Zero(p, gradient.cols()));
    steps.back()(free, Eigen::all) = -information.Solve(gradient(free, Eigen::all));
  }
  return steps;
}

namespace {

// Or is no unknown at all.
bool Judges(const instruments::SetupParameter& parameter) {
  return parameter.held || (parameter.is_placed && std::isfinite(parameter.prior_sigma));
}

template <typename Counts>
double SquaresOfPriors(const Problem& problem, const Point& point, const Counts& counts) {
  double squares = 0.0;
  for (size_t g = 0; g < problem.groups.size(); ++g) {
    for (size_t i = 0; i < problem.groups[g].parameters.size(); ++i) {
      const instruments::SetupParameter& parameter = problem.groups[g].parameters[i];
      if (counts(parameter) && !parameter.held)
        squares += point.setup[g][i] * point.setup[g][i] * PriorPrecision(parameter, Priors::kAll);
    }
  }
  return squares;
}

}  // namespace

double PriorSquares(const Problem& problem, const Point& point) {
  double squares = SquaresOfPriors(problem, point, [](const instruments::SetupParameter&) { return true; });
  for (const Parameter& parameter : ListParameters(point.model, false)) {
    const double value = ValueOf(point.model, parameter);
    squares += value * value * PriorPrecision(point.model, parameter);
  }
  return squares;
}

double JudgingPriorSquares(const Problem& problem, const Point& point) {
  return SquaresOfPriors(problem, point, Judges);
}

double AmplitudesFromPriors(const Problem& problem, const Point& point, const NormalEquations& normal,
                            const std::vector<int>& held) {
  if (std::none_of(point.model.terms.begin(), point.model.terms.end(),
                   [](const machine::ErrorTerm& term) { return term.prior_sigma > 0.0; }))
    return 0.0;
  const Eigen::MatrixXd covariance = InverseBeside(Reduce(problem, point, normal, Priors::kAll), held);
  double determined = 0.0;
  for (size_t i = 0; i < normal.parameters.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    determined += std::min(1.0, covariance(at, at) * PriorPrecision(point.model, normal.parameters[i]));
  }
  return determined;
}

double OffsetsFromReadings(const Problem& problem, const Point& point, const NormalEquations& normal,
                           const std::vector<int>& held) {
  const bool all_judge = std::all_of(problem.groups.begin(), problem.groups.end(), [](const SetupGroup& group) {
    return std::all_of(group.parameters.begin(), group.parameters.end(), Judges);
  });
  if (all_judge) return 0.0;
  const Covariance covariance = CovarianceOf(problem, point, normal, held, 1.0);
  double determined = 0.0;
  for (size_t g = 0; g < problem.groups.size(); ++g) {
    for (size_t i = 0; i < problem.groups[g].parameters.size(); ++i) {
      const instruments::SetupParameter& parameter = problem.groups[g].parameters[i];
      const auto at = static_cast<Eigen::Index>(i);
      if (Judges(parameter) || !(normal.groups[g].gram(at, at) > 0.0)) continue;
      const double sigma = covariance.setup_sigma[g][at];
      determined += std::max(0.0, 1.0 - sigma * sigma * PriorPrecision(parameter, Priors::kAll));
    }
  }
  return determined;
}

double LeaningOnSetups(const Problem& problem, const NormalEquations& normal) {
  double leaning = 0.0;
  for (size_t g = 0; g < normal.groups.size(); ++g) {
    const std::vector<instruments::SetupParameter>& offsets = problem.groups[g].parameters;
    std::vector<int> stated, free;
    for (int i = 0; i < normal.groups[g].setup_count; ++i) {
      const instruments::SetupParameter& offset = offsets[static_cast<size_t>(i)];
      if (!offset.held) (std::isfinite(offset.prior_sigma) ? stated : free).push_back(i);
    }
    if (stated.empty()) continue;
    const Eigen::MatrixXd& gram = normal.groups[g].gram;
    Eigen::MatrixXd information = gram(stated, stated);
    if (!free.empty()) {
      const Eigen::MatrixXd by_free = gram(free, stated);
      information -= by_free.transpose() * ScaledFactor(gram(free, free)).Solve(by_free);
    }
    Eigen::VectorXd sigma(information.rows());
    for (size_t i = 0; i < stated.size(); ++i)
      sigma[static_cast<Eigen::Index>(i)] = offsets[static_cast<size_t>(stated[i])].prior_sigma;
    information = sigma.asDiagonal() * information * sigma.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(information, Eigen::EigenvaluesOnly);
    for (const double ruled_out : solver.eigenvalues()) leaning += std::log1p(std::max(ruled_out, 0.0));
  }
  return leaning;
}

}  // namespace axiscal::identify
