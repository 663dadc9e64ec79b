#include "core/reports/fitted_json.h"
#include "core/reports/report_json.h"

namespace axiscal::reports {

const char* const* WordsOf(Verdict) {
  static constexpr const char* kWords[] = {"adequate", "extended", "unexplained", nullptr};
  return kWords;
}

const char* const* WordsOf(Carrier) {
  static constexpr const char* kWords[] = {"table", "tool", nullptr};
  return kWords;
}

const char* const* WordsOf(PartKind) {
  static constexpr const char* kWords[] = {"local", "slip", "check-session", "bad-readings", "scatter", nullptr};
  return kWords;
}

const char* const* WordsOf(HeldBackKind) {
  static constexpr const char* kWords[] = {"uncertain", "undecided", "no-gain", "hidden", nullptr};
  return kWords;
}

const char* const* WordsOf(Change) {
  static constexpr const char* kWords[] = {"added", "dropped", "replaced", "withdrawn", "refused", nullptr};
  return kWords;
}

template <typename Io>
void Members(Io& io, base::Like<Io, NamedTerm> term) {
  Members(io, term.term);
  io.Member("name", term.name);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Effect> effect) {
  Members(io, effect.is);
  io.Member("amplitude", effect.amplitude);
  io.Member("amplitude_sigma", effect.amplitude_sigma);
  io.Member("unit", effect.unit);
  io.Member("phase_deg", effect.phase_deg);
  io.IfAny("alias_orders", effect.alias_orders);
  io.Member("rms_um", effect.rms_um);
  io.Member("evidence", effect.evidence);
  io.Member("equivalent", effect.equivalent);
  io.Member("same_always", effect.same_always);
}

template <typename Io>
void Members(Io& io, base::Like<Io, HeldBack> held) {
  io.Required("kind", held.kind);
  io.Required("subject", held.subject);
  io.Member("evidence", held.evidence);
  io.Member("harm", held.harm);
  io.Member("measure", held.measure);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Slip> slip) {
  io.Member("carrier", slip.carrier);
  io.Member("may_be", slip.may_be);
  io.Member("moved_um", slip.moved_um);
  io.Member("sigma_um", slip.sigma_um);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Unexplained> part) {
  io.Member("kind", part.kind);
  io.Member("variable", part.variable);
  io.Member("from", part.from);
  io.Member("to", part.to);
  io.Member("unit", part.unit);
  io.Member("session", part.session);
  io.Member("rms_um", part.rms_um);
  io.Member("slip", part.slip);
}

template <typename Io>
void Members(Io& io, base::Like<Io, SelectionStep> step) {
  io.Required("change", step.change);
  io.Required("name", step.name);
  io.Member("rms_um", step.rms_um);
}

template <typename Io>
void Members(Io& io, base::Like<Io, ProposedTest> test) {
  io.Member("session", test.session);
  io.Required("test", test.test);
  io.Member("text", test.text);
  io.Member("correlation_before", test.correlation_before);
  io.Member("correlation_after", test.correlation_after);
  io.Member("expected_chi2", test.expected_chi2);
  io.Unless(false, "needs_next", test.needs_next);
  io.Unless(std::string(), "beyond", test.beyond);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Proposal> proposal) {
  io.Required("effect", proposal.effect);
  io.Member("separates", proposal.separates);
  io.FlatOrNull("session", proposal.test);
  io.Member("remaining", proposal.remaining);
  io.Member("same_always", proposal.same_always);
}

template <typename Io>
void Members(Io& io, base::Like<Io, SessionNoise> noise) {
  io.Required("session", noise.session);
  io.Member("stated_sigma_um", noise.stated_sigma_um);
  io.Member("sigma_um", noise.sigma_um);
  io.Member("neighbour_correlation", noise.neighbour_correlation);
}

template <typename Io>
void Members(Io& io, base::Like<Io, BeforeAfter> fit) {
  io.Member("before", fit.before);
  io.Member("after", fit.after);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Check> check) {
  io.Member("before", check.before);
  io.Member("after", check.after);
  io.Member("fitted", check.fitted);
}

template <typename Io>
void Members(Io& io, base::Like<Io, VolumetricFigure> figure) {
  io.Member("rms_um", figure.rms_um);
  io.Member("low_um", figure.low_um);
  io.Member("high_um", figure.high_um);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Volumetric> volumetric) {
  io.Member("box", volumetric.box);
  io.Member("poses", volumetric.poses);
  io.Member("uncorrected", volumetric.uncorrected);
  io.Member("before", volumetric.before);
  io.Member("after", volumetric.after);
  io.Member("gain_is_held", volumetric.gain_is_held);
  io.Member("weakest", volumetric.weakest);
  io.IfAny("undecided", volumetric.undecided);
  io.Member("unknown", volumetric.unknown);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Loop> report) {
  io.Required("verdict", report.verdict);
  io.Member("effects", report.effects);
  io.IfAny("causes", report.causes);
  io.IfAny("held_back", report.held_back);
  io.Member("errors", report.fitted.errors);
  io.Member("coverage_factor", report.fitted.coverage_factor);
  io.Member("not_separable", report.fitted.not_separable);
  io.IfAny("measured", report.fitted.measured);
  io.Member("determined", report.fitted.determined);
  io.Member("warnings", report.fitted.warnings);
  io.IfAny("stated", report.fitted.stated);
  io.Member("fit", report.fit);
  io.Member("check", report.check);
  io.Member("volumetric", report.volumetric);
  io.Member("steps", report.steps);
  io.Member("unexplained", report.unexplained);
  io.Member("outliers", report.fitted.outliers);
  io.Member("next_measurement", report.next_measurement);
  io.Member("noise", report.noise);
  io.Member("withdrawn", report.withdrawn);
  io.Member("not_visible", report.not_visible);
  io.Member("axes_at_rest", report.axes_at_rest);
  io.Member("stopped_early", report.stopped_early);
  io.Member("sessions", report.fitted.sessions);
  io.Member("candidates", report.candidates);
  io.Document("budget", report.fitted.budget_json);
  io.Member("monte_carlo", report.fitted.monte_carlo);
}

std::string ToJson(const Loop& report) { return base::WriteMembers(report); }

absl::StatusOr<Loop> ReadLoop(const nlohmann::ordered_json& document) { return ReadReport<Loop>(document); }

absl::StatusOr<Loop> ReadLoop(const std::string& text) { return ReadReport<Loop>(text); }

}  // namespace axiscal::reports
