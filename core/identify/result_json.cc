#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/units.h"
#include "core/identify/monte_carlo.h"
#include "core/identify/result.h"

namespace axiscal::identify {
namespace {

using base::kUmPerMm;
using base::kUradPerRad;
using json = nlohmann::ordered_json;

json NumberOrNull(double number) { return std::isfinite(number) ? json(number) : json(nullptr); }

json ErrorsJson(const Result& result) {
  json errors = json::array();
  for (const Estimate& estimate : result.estimates) {
    json entry = {{"symbol", estimate.symbol}};
    if (estimate.name != estimate.symbol) entry["name"] = estimate.name;
    entry["value"] = NumberOrNull(estimate.value / estimate.factor);
    entry["sigma"] = NumberOrNull(estimate.sigma / estimate.factor);
    entry["unit"] = estimate.unit;
    entry["identifiable"] = estimate.identifiable;
    errors.push_back(std::move(entry));
  }
  return errors;
}

json CorrelationJson(const Eigen::MatrixXd& correlation) {
  json rows = json::array();
  for (Eigen::Index i = 0; i < correlation.rows(); ++i) {
    json row = json::array();
    for (Eigen::Index j = 0; j < correlation.cols(); ++j) row.push_back(NumberOrNull(correlation(i, j)));
    rows.push_back(std::move(row));
  }
  return rows;
}

json HeldJson(const Result& result) {
  json errors = json::array();
  for (const Estimate& estimate : result.held_errors) {
    json entry = {{"symbol", estimate.symbol}};
    if (estimate.name != estimate.symbol) entry["name"] = estimate.name;
    entry["value"] = estimate.value / estimate.factor;
    entry["sigma"] = NumberOrNull(estimate.sigma / estimate.factor);
    entry["unit"] = estimate.unit;
    errors.push_back(std::move(entry));
  }
  json sessions = json::array();
  for (const MeasuredIn& from : result.held_from) {
    json session = {{"session", from.session}};
    if (from.setup != from.session) session["shared_setup"] = from.setup;
    sessions.push_back(std::move(session));
  }
  return {{"errors", std::move(errors)},
          {"correlation", CorrelationJson(result.held_correlation)},
          {"sessions", std::move(sessions)}};
}

json SessionsJson(const Result& result) {
  json sessions = json::array();
  for (const SessionFit& session : result.sessions) {
    json setup = json::object();
    for (const SetupOffset& offset : session.setup) {
      const double per_unit = offset.is_angle ? kUradPerRad : kUmPerMm;
      setup[offset.name] = {{"value", offset.value * per_unit},
                            {"sigma", offset.sigma * per_unit},
                            {"unit", offset.is_angle ? "urad" : "um"}};
    }
    json entry = {{"session", session.session}};
    if (session.setup_name != session.session) entry["shared_setup"] = session.setup_name;
    entry["readings"] = session.readings;
    entry["rms_um"] = session.rms_mm * kUmPerMm;
    entry["max_um"] = session.max_mm * kUmPerMm;
    entry["setup"] = std::move(setup);
    sessions.push_back(std::move(entry));
  }
  return sessions;
}

}  // namespace

std::string ToJson(const Result& result) {
  json root;
  root["errors"] = ErrorsJson(result);
  root["not_separable"] = result.not_separable;
  json determined = json::array();
  for (const Combination& combination : result.determined) {
    determined.push_back({{"name", combination.name},
                          {"value", combination.value / combination.factor},
                          {"sigma", combination.sigma / combination.factor},
                          {"unit", combination.unit}});
  }
  root["determined"] = std::move(determined);
  root["coverage_factor"] = result.coverage_factor;
  root["rank"] = result.rank;
  root["parameters"] = result.estimates.size();
  root["condition"] = NumberOrNull(result.condition);
  root["nominal"] = {{"rms_um", result.nominal.rms_mm * kUmPerMm}, {"max_um", result.nominal.max_mm * kUmPerMm}};
  root["fit"] = {{"rms_um", result.fit.rms_mm * kUmPerMm},
                 {"max_um", result.fit.max_mm * kUmPerMm},
                 {"rms_without_outliers_um", result.fit.rms_without_outliers_mm * kUmPerMm},
                 {"chi2_per_dof", result.fit.chi2_per_dof},
                 {"readings", result.fit.readings},
                 {"degrees_of_freedom", result.fit.degrees_of_freedom}};
  root["sessions"] = SessionsJson(result);
  json outliers = json::array();
  for (const Outlier& outlier : result.outliers) {
    json object = {{"session", outlier.session},
                   {"row", outlier.row},
                   {"column", outlier.column},
                   {"residual_um", outlier.residual_mm * kUmPerMm}};
    if (outlier.gate) {
      object["gate"] = outlier.gate->name;
      object["off_um"] = outlier.gate->off_mm * kUmPerMm;
      object["limit_um"] = outlier.gate->limit_mm * kUmPerMm;
    }
    outliers.push_back(std::move(object));
  }
  root["outliers"] = std::move(outliers);
  json warnings = json::array();
  for (const Warning& warning : result.warnings) warnings.push_back({{"kind", warning.kind}, {"text", warning.text}});
  root["warnings"] = std::move(warnings);
  root["correlation"] = CorrelationJson(result.correlation);
  if (!result.held_errors.empty()) root["held"] = HeldJson(result);
  root["iterations"] = result.iterations;
  root["noise_scale"] = result.noise_scale;
  return root.dump(1) + "\n";
}

nlohmann::ordered_json ToJson(const MonteCarloResult& result) {
  json errors = json::array();
  for (const Spread& spread : result.spreads) {
    errors.push_back({{"name", spread.name},
                      {"value", spread.value / spread.factor},
                      {"mean", spread.mean / spread.factor},
                      {"sigma", NumberOrNull(spread.sigma / spread.factor)},
                      {"low", spread.low / spread.factor},
                      {"high", spread.high / spread.factor},
                      {"linear_sigma", NumberOrNull(spread.linear_sigma / spread.factor)},
                      {"unit", spread.unit}});
  }
  return {{"runs", result.runs},
          {"failed", result.failed},
          {"seed", result.seed},
          {"errors", std::move(errors)},
          {"correlation", CorrelationJson(result.correlation)}};
}

}  // namespace axiscal::identify
