#include "core/loop/test_rows.h"

#include "core/base/demand.h"
#include "core/identify/reduction.h"
#include "core/identify/rows.h"

namespace axiscal::loop {

class TestRowSink {
 public:
  TestRowSink(Eigen::Index width, TestRows* out)
      : weight_(1.0 / out->problem_.noise[0].sigma_mm), row_(width + 1), out_(out) {}

  Eigen::RowVectorXd& NextRow() { return row_; }
  void Close(int reading, int row, const instruments::Evaluation& evaluation, const Eigen::RowVectorXd& stored) {
    const auto at = static_cast<Eigen::Index>(out_->reading_.size());
    out_->reading_.push_back(reading);
    out_->sensitivity_.row(at) = weight_ * evaluation.by_error.row(row);
    out_->fitted_.row(at) = weight_ * stored.head(stored.size() - 1);
  }

 private:
  const double weight_;
  Eigen::RowVectorXd row_;
  TestRows* const out_;
};

TestRows::TestRows(identify::Problem problem, const machine::ErrorModel& fitted)
    : problem_(std::move(problem)), fitted_terms_(fitted.terms.size()) {
  const instruments::MeasuringRun& run = problem_.runs[0];
  DEMAND(problem_.runs.size() == 1 && problem_.noise[0].ar1 == 0.0 && run.path_readings == nullptr);
  const std::vector<identify::Parameter> parameters = identify::ListParameters(fitted, true);
  const auto rows = static_cast<Eigen::Index>(run.measured_mm.size());
  const auto width = static_cast<Eigen::Index>(run.setup.size() + parameters.size());
  sensitivity_.resize(rows, machine::kComponents * problem_.machine->joint_count());
  fitted_.resize(rows, width);
  TestRowSink sink(width, this);
  identify::VisitRows(problem_, 0, identify::StartingPoint(problem_, fitted), parameters, &sink);
  DEMAND(reading_.size() == static_cast<size_t>(rows));
  fitted_gram_.noalias() = fitted_.transpose() * fitted_;
}

Eigen::MatrixXd TestRows::ColumnsOf(const machine::ErrorModel& others) const {
  const std::vector<identify::Parameter> parameters = identify::ListParameters(others, true);
  const identify::Point point = {others, {}};
  identify::ErrorsOfRun errors(problem_, point, parameters);
  Eigen::MatrixXd columns(sensitivity_.rows(), static_cast<Eigen::Index>(parameters.size()));
  for (Eigen::Index row = 0; row < columns.rows(); ++row) {
    const shapes::State state = problem_.runs[0].StateOf(reading_[row]);
    if (row == 0 || reading_[row] != reading_[row - 1]) errors.At(state);
    for (Eigen::Index i = 0; i < columns.cols(); ++i) {
      const machine::ErrorTerm& term = others.terms[parameters[i].term];
      const double* const by_error =
          &sensitivity_(row, machine::kComponents * term.joint + static_cast<int>(term.component));
      columns(row, i) =
          errors.slopes()[i] * (shapes::IsAlongApproach(term.shape)
                                    ? machine::AlongApproach(state.approach, by_error, sensitivity_.outerStride())
                                    : *by_error);
    }
  }
  return columns;
}

Information TestRows::InformationOf(const machine::ErrorModel& model) const {
  DEMAND(model.terms.size() >= fitted_terms_);
  machine::ErrorModel others;
  others.terms.assign(model.terms.begin() + static_cast<std::ptrdiff_t>(fitted_terms_), model.terms.end());
  const Eigen::MatrixXd columns = ColumnsOf(others);
  const Eigen::Index known = fitted_.cols(), added = columns.cols();
  identify::GroupNormal block;
  block.setup_count = static_cast<int>(problem_.groups[0].parameters.size());
  // Nothing is measured yet: no residual.
  block.gram = Eigen::MatrixXd::Zero(known + added + 1, known + added + 1);
  block.gram.topLeftCorner(known, known) = fitted_gram_;
  block.gram.block(known, known, added, added).noalias() = columns.transpose() * columns;
  block.gram.block(known, 0, added, known).noalias() = columns.transpose() * fitted_;
  block.gram.block(0, known, known, added) = block.gram.block(known, 0, added, known).transpose();
  identify::NormalEquations normal;
  normal.row_count = static_cast<int>(columns.rows());
  normal.groups.push_back(std::move(block));
  const identify::Reduced reduced =
      identify::Reduce(problem_, identify::StartingPoint(problem_, {}), normal, identify::Priors::kAll);
  return identify::InformationOf(reduced);
}

}  // namespace axiscal::loop
