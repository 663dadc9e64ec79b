#include "core/identify/report.h"

#include <utility>

#include "core/base/units.h"
#include "core/identify/reduction.h"

namespace axiscal::identify {
namespace {

using base::kUmPerMm;
using base::kUradPerRad;

reports::Correlation CorrelationOf(const Eigen::MatrixXd& correlation) {
  reports::Correlation rows(static_cast<size_t>(correlation.rows()));
  for (Eigen::Index i = 0; i < correlation.rows(); ++i) {
    for (Eigen::Index j = 0; j < correlation.cols(); ++j) rows[static_cast<size_t>(i)].push_back(correlation(i, j));
  }
  return rows;
}

reports::SessionFit SessionOf(const SessionFit& fit) {
  reports::SessionFit session;
  session.in = {fit.session, fit.setup_name};
  session.readings = fit.readings;
  session.rms_um = fit.rms_mm * kUmPerMm;
  session.max_um = fit.max_mm * kUmPerMm;
  for (const SetupOffset& offset : fit.setup) {
    reports::SetupOffset written{.unit = offset.is_angle ? "urad" : "um"};
    // Wider than an error may be it is no number: nothing that is measured shows this offset.
    if (offset.sigma <= (offset.is_angle ? kLargestErrorRad : kLargestErrorMm)) {
      const double per_unit = offset.is_angle ? kUradPerRad : kUmPerMm;
      written.value = offset.value * per_unit;
      written.sigma = offset.sigma * per_unit;
    }
    session.setup.push_back({offset.name, std::move(written)});
  }
  return session;
}

reports::Outlier OutlierOf(const Outlier& found) {
  reports::Outlier outlier;
  outlier.session = found.session;
  outlier.row = found.row;
  outlier.column = found.column;
  outlier.residual_um = found.residual_mm * kUmPerMm;
  if (found.gate) outlier.gate = {found.gate->name, found.gate->off_mm * kUmPerMm, found.gate->limit_mm * kUmPerMm};
  return outlier;
}

reports::Held HeldOf(const Result& result) {
  reports::Held held;
  for (const Estimate& error : result.held_errors) {
    held.errors.push_back(
        {error.symbol, error.name, error.value / error.factor, error.sigma / error.factor, error.unit});
  }
  held.correlation = CorrelationOf(result.held_correlation);
  for (const MeasuredIn& from : result.held_from) held.sessions.push_back({from.session, from.setup});
  return held;
}

}  // namespace

reports::Fitted FittedOf(const Result& result) {
  reports::Fitted fitted;
  for (const Estimate& estimate : result.estimates) {
    fitted.errors.push_back({estimate.symbol, estimate.name, estimate.value / estimate.factor,
                             estimate.sigma / estimate.factor, estimate.unit, estimate.identifiable});
  }
  fitted.coverage_factor = result.coverage_factor;
  fitted.not_separable = result.not_separable;
  for (const Combination& combination : result.determined) {
    fitted.determined.push_back({combination.name, combination.value / combination.factor,
                                 combination.sigma / combination.factor, combination.unit});
  }
  for (const Result::Stated& stated : result.stated) {
    reports::StatedFact& fact = fitted.stated.emplace_back(reports::StatedFact{stated.of, {}});
    for (size_t i = 0; i < result.estimates.size(); ++i) {
      const Estimate& estimate = result.estimates[i];
      if (estimate.identifiable)
        fact.moves.push_back({estimate.name, stated.moved[static_cast<Eigen::Index>(i)] / estimate.factor});
    }
  }
  for (const reports::WarningFacts& facts : result.warnings) fitted.warnings.push_back(reports::InWords(facts));
  for (const Outlier& outlier : result.outliers) fitted.outliers.push_back(OutlierOf(outlier));
  for (const SessionFit& session : result.sessions) fitted.sessions.push_back(SessionOf(session));
  return fitted;
}

reports::Identification ReportOf(const Result& result) {
  reports::Identification report;
  report.fitted = FittedOf(result);
  report.rank = result.rank;
  report.condition = result.condition;
  report.nominal = {.rms_um = result.nominal.rms_mm * kUmPerMm, .max_um = result.nominal.max_mm * kUmPerMm};
  report.fit = {.rms_um = result.fit.rms_mm * kUmPerMm,
                .max_um = result.fit.max_mm * kUmPerMm,
                .rms_without_outliers_um = result.fit.rms_without_outliers_mm * kUmPerMm,
                .chi2_per_dof = result.fit.chi2_per_dof,
                .readings = result.fit.readings,
                .degrees_of_freedom = result.fit.degrees_of_freedom};
  report.correlation = CorrelationOf(result.correlation);
  if (!result.held_errors.empty()) report.held = HeldOf(result);
  report.iterations = result.iterations;
  report.noise_scale = result.noise_scale;
  return report;
}

reports::Statistics BeforeOf(const Result& without_errors) {
  return {.rms_um = without_errors.fit.rms_mm * kUmPerMm,
          .max_um = without_errors.fit.max_mm * kUmPerMm,
          .chi2_per_dof = without_errors.fit.chi2_per_dof};
}

reports::MonteCarlo ReportOf(const MonteCarloResult& result) {
  reports::MonteCarlo simulation;
  simulation.runs = result.runs;
  simulation.failed = result.failed;
  simulation.seed = result.seed;
  for (const Spread& spread : result.spreads) {
    simulation.errors.push_back({spread.name, spread.value / spread.factor, spread.mean / spread.factor,
                                 spread.sigma / spread.factor, spread.low / spread.factor, spread.high / spread.factor,
                                 spread.linear_sigma / spread.factor, spread.unit});
  }
  simulation.correlation = CorrelationOf(result.correlation);
  return simulation;
}

}  // namespace axiscal::identify
