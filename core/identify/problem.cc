#include "core/identify/problem.h"

#include <map>
#include <set>

#include "core/base/demand.h"
#include "core/identify/whitening.h"
#include "core/instruments/evaluation.h"

namespace axiscal::identify {
namespace {

using instruments::MeasuringRun;

// Rows are gathered in a small buffer so that the rank update runs at full speed.
class GramBuilder {
 public:
  explicit GramBuilder(int width) : gram_(Eigen::MatrixXd::Zero(width, width)), buffer_(kRows, width) {}

  Eigen::MatrixXd::RowXpr NextRow() {
    if (used_ == kRows) Flush();
    return buffer_.row(used_++);
  }

  Eigen::MatrixXd Finish() {
    Flush();
    gram_.triangularView<Eigen::StrictlyUpper>() = gram_.transpose();
    return std::move(gram_);
  }

 private:
  static constexpr int kRows = 128;

  void Flush() {
    gram_.selfadjointView<Eigen::Lower>().rankUpdate(buffer_.topRows(used_).transpose());
    used_ = 0;
  }

  Eigen::MatrixXd gram_, buffer_;
  int used_ = 0;
};

bool IsConstant(const machine::ErrorModel& model) {
  return std::all_of(model.terms.begin(), model.terms.end(), [](const machine::ErrorTerm& term) {
    return std::holds_alternative<shapes::Constant>(term.shape);
  });
}

// Fitted and fixed errors together; evaluated once where no term depends on the state.
class ErrorsOfRun {
 public:
  ErrorsOfRun(const Problem& problem, const Point& point)
      : problem_(problem), point_(point), is_constant_(IsConstant(point.model) && IsConstant(problem.fixed_model)) {}

  bool is_constant() const { return is_constant_; }
  const machine::JointErrors<double>& At(const shapes::State& state) {
    if (is_constant_ && is_evaluated_) return errors_;
    errors_ = machine::ErrorsAt(*problem_.machine, point_.model, state);
    if (!problem_.fixed_model.terms.empty()) {
      const machine::JointErrors<double> fixed = machine::ErrorsAt(*problem_.machine, problem_.fixed_model, state);
      for (int joint = 0; joint < problem_.machine->joint_count(); ++joint) errors_[joint] += fixed[joint];
    }
    is_evaluated_ = true;
    return errors_;
  }

 private:
  const Problem& problem_;
  const Point& point_;
  const bool is_constant_;
  bool is_evaluated_ = false;
  machine::JointErrors<double> errors_;
};

// d(error component)/d(parameter) at a state.
void ParameterSlopes(const machine::ErrorModel& model, const std::vector<Parameter>& parameters,
                     const shapes::State& state, Eigen::VectorXd* slopes) {
  double values[shapes::kMaxBasisCount];
  for (size_t i = 0; i < parameters.size(); ++i) {
    const machine::ErrorTerm& term = model.terms[parameters[i].term];
    if (!parameters[i].is_nonlinear) {
      if (parameters[i].basis == 0) shapes::Basis(term.shape, state, values);
      (*slopes)[i] = values[parameters[i].basis];
      continue;
    }
    shapes::BasisSlope(term.shape, state, values);
    (*slopes)[i] = 0.0;
    for (int k = 0; k < shapes::BasisCount(term.shape); ++k) (*slopes)[i] += term.amplitude[k] * values[k];
  }
}

void AddRun(const Problem& problem, int run_index, const Point& point, const std::vector<Parameter>& parameters,
            GramBuilder* gram, int* row_count) {
  const MeasuringRun& run = problem.runs[run_index];
  const machine::Machine& machine = *problem.machine;
  const Eigen::VectorXd& setup = point.setup[problem.group_of_run[run_index]];
  const int setup_count = static_cast<int>(run.setup.size()), count = static_cast<int>(parameters.size());
  std::vector<int> column(count);
  for (int i = 0; i < count; ++i) {
    const machine::ErrorTerm& term = point.model.terms[parameters[i].term];
    column[i] = machine::kComponents * term.joint + static_cast<int>(term.component);
  }
  ErrorsOfRun errors_of_run(problem, point);
  Eigen::VectorXd slopes = Eigen::VectorXd::Ones(count);
  std::vector<SeriesWhitener> whiteners(run.row_count,
                                        SeriesWhitener(problem.noise[run_index], setup_count + count + 1));
  instruments::Evaluation evaluation;
  for (int k = 0; k < run.reading_count(); ++k) {
    const shapes::State state = run.StateOf(k);
    const machine::JointErrors<double>& errors = errors_of_run.At(state);
    if (!errors_of_run.is_constant()) ParameterSlopes(point.model, parameters, state, &slopes);
    instruments::Evaluate(machine, run, k, errors, setup.data(), &evaluation);
    for (int r = 0; r < run.row_count; ++r) {
      if (!problem.is_used[run_index][static_cast<size_t>(k) * run.row_count + r]) continue;
      auto row = gram->NextRow();
      row.head(setup_count) = evaluation.by_setup.row(r);
      for (int i = 0; i < count; ++i) row[setup_count + i] = evaluation.by_error(r, column[i]) * slopes[i];
      row[setup_count + count] = evaluation.predicted_mm[r] - run.measured_mm(r, k);
      whiteners[r].Apply(k, row);
      ++*row_count;
    }
  }
}

}  // namespace

absl::StatusOr<Problem> MakeProblem(const machine::Machine& machine, std::vector<MeasuringRun> runs) {
  Problem problem;
  problem.machine = &machine;
  std::map<std::string, int> group_of_name;
  std::set<std::string> sessions;
  for (size_t i = 0; i < runs.size(); ++i) {
    const MeasuringRun& run = runs[i];
    if (!sessions.insert(run.session).second) {
      return absl::InvalidArgumentError(absl::StrCat("session '", run.session, "' is there twice"));
    }
    const auto [it, is_new] = group_of_name.emplace(run.setup_name, static_cast<int>(problem.groups.size()));
    if (is_new) problem.groups.push_back({run.setup_name, run.setup, {}});
    SetupGroup& group = problem.groups[it->second];
    if (!group.runs.empty() && runs[group.runs[0]].kind != run.kind) {
      return absl::InvalidArgumentError(absl::StrCat("sessions '", runs[group.runs[0]].session, "' and '", run.session,
                                                     "' share the setup '", run.setup_name,
                                                     "' but not the instrument"));
    }
    group.runs.push_back(static_cast<int>(i));
    problem.group_of_run.push_back(it->second);
    problem.noise.push_back({run.sigma_mm, 0.0});
    problem.is_used.emplace_back(static_cast<size_t>(run.reading_count()) * run.row_count, true);
  }
  problem.runs = std::move(runs);
  return problem;
}

Point StartingPoint(const Problem& problem, const machine::ErrorModel& model) {
  Point point;
  point.model = model;
  for (const SetupGroup& group : problem.groups) point.setup.push_back(Eigen::VectorXd::Zero(group.parameters.size()));
  return point;
}

std::vector<Parameter> ListParameters(const machine::ErrorModel& model, bool with_nonlinear) {
  std::vector<Parameter> parameters;
  for (int i = 0; i < static_cast<int>(model.terms.size()); ++i) {
    for (int k = 0; k < shapes::BasisCount(model.terms[i].shape); ++k) parameters.push_back({i, k, false});
    if (with_nonlinear && shapes::NonlinearParameter(model.terms[i].shape)) parameters.push_back({i, 0, true});
  }
  return parameters;
}

double ValueOf(const machine::ErrorModel& model, const Parameter& parameter) {
  const machine::ErrorTerm& term = model.terms[parameter.term];
  return parameter.is_nonlinear ? *shapes::NonlinearParameter(term.shape) : term.amplitude[parameter.basis];
}

void SetValue(const Parameter& parameter, double value, machine::ErrorModel* model) {
  machine::ErrorTerm& term = model->terms[parameter.term];
  (parameter.is_nonlinear ? *shapes::NonlinearParameter(term.shape) : term.amplitude[parameter.basis]) = value;
}

NormalEquations Assemble(const Problem& problem, const Point& point, const std::vector<Parameter>& parameters) {
  NormalEquations normal;
  for (const SetupGroup& group : problem.groups) {
    GroupNormal block;
    block.setup_count = static_cast<int>(group.parameters.size());
    GramBuilder gram(block.setup_count + static_cast<int>(parameters.size()) + 1);
    for (const int run : group.runs) AddRun(problem, run, point, parameters, &gram, &normal.row_count);
    block.gram = gram.Finish();
    normal.groups.push_back(std::move(block));
  }
  return normal;
}

std::vector<Eigen::MatrixXd> ResidualsOf(const Problem& problem, const Point& point) {
  const machine::Machine& machine = *problem.machine;
  std::vector<Eigen::MatrixXd> residuals_mm;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const MeasuringRun& run = problem.runs[i];
    const double* setup = point.setup[problem.group_of_run[i]].data();
    Eigen::MatrixXd residual_mm(run.row_count, run.reading_count());
    ErrorsOfRun errors_of_run(problem, point);
    for (int k = 0; k < run.reading_count(); ++k) {
      instruments::Predict(machine, run, k, errors_of_run.At(run.StateOf(k)), setup, residual_mm.col(k).data());
    }
    residuals_mm.push_back(residual_mm - run.measured_mm);
  }
  return residuals_mm;
}

double WhitenedSquares(const Problem& problem, const std::vector<Eigen::MatrixXd>& residuals_mm) {
  double squares = 0.0;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const int rows = problem.runs[i].row_count;
    for (int r = 0; r < rows; ++r) {
      SeriesWhitener whitener(problem.noise[i], 1);
      Eigen::Matrix<double, 1, 1> value;
      for (int k = 0; k < residuals_mm[i].cols(); ++k) {
        if (!problem.is_used[i][static_cast<size_t>(k) * rows + r]) continue;
        value[0] = residuals_mm[i](r, k);
        whitener.Apply(k, value);
        squares += value[0] * value[0];
      }
    }
  }
  return squares;
}

}  // namespace axiscal::identify
