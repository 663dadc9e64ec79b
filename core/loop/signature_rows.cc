// The rows that signatures are made of: sensitivities, set-ups, errors and residuals of every used reading, once.
#include <algorithm>

#include "core/identify/noise.h"
#include "core/identify/reduction.h"
#include "core/identify/rows.h"
#include "core/identify/whitening.h"
#include "core/loop/signatures.h"

namespace axiscal::loop {

using instruments::MeasuringRun;

// Places the rows of one run: those of one series stand together, so that the neighbour in time is the row above.
class RowSink {
 public:
  // `columns`: those of `errors` stand last.
  RowSink(const identify::Problem& problem, int run, Eigen::Index errors, std::vector<int> next,
          Eigen::MatrixXd* columns, Eigen::VectorXd* residual, Signatures* out)
      : run_(run),
        next_(std::move(next)),
        whiteners_(problem.runs[run].row_count, identify::SeriesWhitener(problem.noise[run], 0)),
        has_echo_(problem.noise[run].white_share != 0.0),
        bounding_(problem.runs[run].row_count,
                  identify::SeriesWhitener(identify::BoundingAr1(problem.noise[run]).noise, 0)),
        row_(identify::SetupCount(problem, run) + errors + 1),
        columns_(columns),
        residual_(residual),
        out_(out) {}

  Eigen::RowVectorXd& NextRow() { return row_; }
  void Close(int reading, int row, const instruments::Evaluation& evaluation, const Eigen::RowVectorXd& stored) {
    const int at = next_[row]++;
    const identify::SeriesWhitener::Factors factors = whiteners_[row].Next(reading);
    out_->run_[at] = run_;
    out_->reading_[at] = reading;
    out_->weight_[at] = factors.weight;
    out_->correlation_[at] = factors.correlation;
    out_->echo_[at] = factors.echo;
    const identify::SeriesWhitener::Factors bounding = has_echo_ ? bounding_[row].Next(reading) : factors;
    out_->bounding_weight_[at] = bounding.weight;
    out_->bounding_correlation_[at] = bounding.correlation;
    out_->sensitivity_.row(at) = evaluation.by_error.row(row);
    out_->setup_raw_.row(at) = stored.head<3>();
    columns_->row(at).tail(stored.size() - 1) = stored.head(stored.size() - 1);
    (*residual_)[at] = stored[stored.size() - 1];
  }

 private:
  const int run_;
  std::vector<int> next_;
  std::vector<identify::SeriesWhitener> whiteners_;
  const bool has_echo_;
  std::vector<identify::SeriesWhitener> bounding_;
  Eigen::RowVectorXd row_;
  Eigen::MatrixXd* columns_;
  Eigen::VectorXd* residual_;
  Signatures* out_;
};

Signatures::Signatures(const identify::Problem& problem, const identify::Point& point,
                       const std::vector<identify::Parameter>& parameters)
    : problem_(problem) {
  size_t setup_width = 3;
  for (const identify::SetupGroup& group : problem.groups) setup_width = std::max(setup_width, group.parameters.size());
  int count = 0;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const MeasuringRun& run = problem.runs[i];
    for (int row = 0; row < run.row_count; ++row) {
      const int begin = count;
      for (int k = 0; k < run.reading_count(); ++k)
        count += problem.is_used[i][static_cast<size_t>(k) * run.row_count + row];
      series_.push_back({begin, count, static_cast<int>(i), problem.group_of_run[i]});
    }
  }
  const auto p = static_cast<Eigen::Index>(parameters.size());
  run_.resize(count);
  reading_.resize(count);
  weight_.resize(count);
  correlation_.resize(count);
  echo_.resize(count);
  bounding_weight_.resize(count);
  bounding_correlation_.resize(count);
  sensitivity_.resize(count, machine::kComponents * problem.machine->joint_count());
  setup_raw_.resize(count, 3);
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(count, static_cast<Eigen::Index>(setup_width) + p);
  Eigen::VectorXd residual(count);
  size_t first_series = 0;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    std::vector<int> next;
    for (int row = 0; row < problem.runs[i].row_count; ++row) next.push_back(series_[first_series++].begin);
    RowSink sink(problem, static_cast<int>(i), p, std::move(next), &columns, &residual, this);
    identify::VisitRows(problem, static_cast<int>(i), point, parameters, &sink);
  }
  is_white_ = (correlation_ == 0.0).all();
  has_echo_ = (echo_ != 0.0).any();
  for (const identify::Noise& noise : problem.noise)
    bounding_excess_ = std::max(bounding_excess_, identify::BoundingAr1(noise).excess);
  const auto whiten = [this](Eigen::Ref<Eigen::VectorXd> x) {
    for (Eigen::Index at = x.size() - 1; at > 0; --at) x[at] -= correlation_[at] * x[at - 1];
    for (Eigen::Index at = 1; has_echo_ && at < x.size(); ++at) x[at] += echo_[at] * x[at - 1];
    x.array() *= weight_;
  };
  for (Eigen::Index c = 0; c < columns.cols(); ++c) whiten(columns.col(c));
  whiten(residual);
  Eigen::VectorXd precision(p);
  for (Eigen::Index k = 0; k < p; ++k) {
    const double largest = identify::LargestOf(point.model, parameters[k]);
    precision[k] = 1.0 / (largest * largest);
  }
  nuisance_ = Nuisance(problem, series_, std::move(columns), precision);

  // The residual has the priors' rows too: offset / prior sigma.
  Eigen::MatrixXd coefficients = Eigen::MatrixXd::Zero(nuisance_.size(), 1);
  for (const Series& rows : series_)
    nuisance_.Accumulate(rows.group, rows.begin, residual.segment(rows.begin, rows.end - rows.begin), &coefficients);
  nuisance_.Finish(&coefficients);
  coefficients.col(0) += nuisance_.OfPriors(problem, point.setup);
  double squares = residual.squaredNorm();
  for (size_t g = 0; g < problem.groups.size(); ++g) {
    for (Eigen::Index k = 0; k < point.setup[g].size(); ++k)
      squares += point.setup[g][k] * point.setup[g][k] *
                 identify::PriorPrecision(problem.groups[g].parameters[k], identify::Priors::kAll);
  }
  residual_squares_ = squares - coefficients.squaredNorm();
  degrees_of_freedom_ = std::max<int>(1, count - static_cast<int>(p));
  residual_ = residual - nuisance_.Column(series_, coefficients.col(0));
}

}  // namespace axiscal::loop
