#include "core/reports/fitted_json.h"
#include "core/reports/report_json.h"

namespace axiscal::reports {

template <typename Io>
void Members(Io& io, base::Like<Io, HeldError> error) {
  io.Required("symbol", error.symbol);
  io.Unless(error.symbol, "name", error.name);
  io.Member("value", error.value);
  io.Member("sigma", error.sigma);
  io.Member("unit", error.unit);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Held> held) {
  io.Member("errors", held.errors);
  io.Member("correlation", held.correlation);
  io.Member("sessions", held.sessions);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Identification> report) {
  io.Member("errors", report.fitted.errors);
  io.Member("not_separable", report.fitted.not_separable);
  io.IfAny("measured", report.fitted.measured);
  io.Member("determined", report.fitted.determined);
  io.Member("coverage_factor", report.fitted.coverage_factor);
  io.Member("rank", report.rank);
  io.Derived("parameters", report.fitted.errors.size());
  io.Member("condition", report.condition);
  io.Member("nominal", report.nominal);
  io.Member("fit", report.fit);
  io.Member("sessions", report.fitted.sessions);
  io.Member("outliers", report.fitted.outliers);
  io.Member("warnings", report.fitted.warnings);
  io.IfAny("stated", report.fitted.stated);
  io.Member("correlation", report.correlation);
  io.Member("held", report.held);
  io.Member("iterations", report.iterations);
  io.Member("noise_scale", report.noise_scale);
  io.Member("before", report.before);
  io.Document("budget", report.fitted.budget_json);
  io.Member("monte_carlo", report.fitted.monte_carlo);
}

std::string ToJson(const Identification& report) { return base::WriteMembers(report); }

absl::StatusOr<Identification> ReadIdentification(const nlohmann::ordered_json& document) {
  return ReadReport<Identification>(document);
}

absl::StatusOr<Identification> ReadIdentification(const std::string& text) { return ReadReport<Identification>(text); }

}  // namespace axiscal::reports
