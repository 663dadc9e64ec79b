// The members of fitted.h, and of a cause, for the readers and writers of the reports that hold them.
#ifndef AXISCAL_CORE_REPORTS_FITTED_JSON_H_
#define AXISCAL_CORE_REPORTS_FITTED_JSON_H_

#include "core/base/json_members.h"
#include "core/reports/fitted.h"
#include "core/reports/loop.h"

namespace axiscal::reports {

inline const char* const* WordsOf(WarningKind) {
  static constexpr const char* kWords[] = {"scatter",     "set-aside", "interval", "no-number", "held",
                                           "resolution",  "size",      "quiet",    "datum",     "no-degree-of-freedom",
                                           "certificate", "clock",     "moved",    "other",     nullptr};
  return kWords;
}

template <typename Io>
void Members(Io& io, base::Like<Io, Warning> warning) {
  io.Required("kind", warning.kind);
  io.Required("text", warning.text);
  io.IfAny("text_de", warning.german);
}

inline const char* const* WordsOf(CauseKind) {
  static constexpr const char* kWords[] = {"instrument", "nominal", "not-repeatable", nullptr};
  return kWords;
}

template <typename Io>
void Members(Io& io, base::Like<Io, Cause> cause) {
  io.Required("kind", cause.kind);
  io.Required("subject", cause.subject);
  io.Member("evidence", cause.evidence);
  io.Member("correction", cause.correction);
  io.IfAny("subject_de", cause.subject_german);
  io.IfAny("correction_de", cause.correction_german);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Error> error) {
  io.Required("symbol", error.symbol);
  io.Unless(error.symbol, "name", error.name);
  io.Member("value", error.value);
  io.Member("sigma", error.sigma);
  io.Member("unit", error.unit);
  io.Member("identifiable", error.identifiable);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Combination> combination) {
  io.Required("name", combination.name);
  io.Member("value", combination.value);
  io.Member("sigma", combination.sigma);
  io.Member("unit", combination.unit);
}

template <typename Io>
void Members(Io& io, base::Like<Io, SetupOffset> offset) {
  io.Member("value", offset.value);
  io.Member("sigma", offset.sigma);
  io.Member("unit", offset.unit);
}

template <typename Io>
void Members(Io& io, base::Like<Io, MeasuredIn> in) {
  io.Required("session", in.session);
  io.Unless(in.session, "shared_setup", in.setup);
}

template <typename Io>
void Members(Io& io, base::Like<Io, SessionFit> session) {
  Members(io, session.in);
  io.Member("readings", session.readings);
  io.Member("rms_um", session.rms_um);
  io.Member("max_um", session.max_um);
  io.Member("setup", session.setup);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Gate> gate) {
  io.Member("gate", gate.gate);
  io.Member("off_um", gate.off_um);
  io.Member("limit_um", gate.limit_um);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Outlier> outlier) {
  io.Required("session", outlier.session);
  io.Member("row", outlier.row);
  io.Member("column", outlier.column);
  io.Member("residual_um", outlier.residual_um);
  io.Flat("gate", outlier.gate);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Statistics> statistics) {
  io.Member("rms_um", statistics.rms_um);
  io.Member("max_um", statistics.max_um);
  io.Member("rms_without_outliers_um", statistics.rms_without_outliers_um);
  io.Member("chi2_per_dof", statistics.chi2_per_dof);
  io.Member("readings", statistics.readings);
  io.Member("degrees_of_freedom", statistics.degrees_of_freedom);
}

template <typename Io>
void Members(Io& io, base::Like<Io, StatedFact> fact) {
  io.Required("of", fact.of);
  io.Member("moves", fact.moves);
}

template <typename Io>
void Members(Io& io, base::Like<Io, SimulatedError> error) {
  io.Required("name", error.name);
  io.Member("value", error.value);
  io.Member("mean", error.mean);
  io.Member("sigma", error.sigma);
  io.Member("low", error.low);
  io.Member("high", error.high);
  io.Member("linear_sigma", error.linear_sigma);
  io.Member("unit", error.unit);
}

template <typename Io>
void Members(Io& io, base::Like<Io, MonteCarlo> simulation) {
  io.Member("runs", simulation.runs);
  io.Member("failed", simulation.failed);
  io.Member("seed", simulation.seed);
  io.Member("errors", simulation.errors);
  io.Member("correlation", simulation.correlation);
}

}  // namespace axiscal::reports

#endif  // AXISCAL_CORE_REPORTS_FITTED_JSON_H_
