#include "tests/rates/score.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <tuple>

namespace axiscal::rates {
namespace {

using machine::ErrorTerm;

// Amplitude of this data set's worst session: sigma by which the residuals were judged over the true one.
double SigmaRatio(const SimulatedCase& simulated, const loop::Report& report) {
  double worst = 1.0;
  for (size_t i = 0; i < report.noise.size(); ++i) {
    const double ratio = report.noise[i].sigma_mm / (simulated.sigma_scale * report.noise[i].stated_mm);
    if (std::abs(std::log(ratio)) > std::abs(std::log(worst))) worst = ratio;
  }
  return worst;
}

std::string Describe(const machine::Machine& machine, const ErrorTerm& term) {
  const double unit = machine::IsAngle(term.component) ? 1e6 : 1e3;
  return absl::StrFormat("%s %.3g", machine::NameOf(machine, term),
                         unit * std::hypot(term.amplitude[0], shapes::HasPhase(term.shape) ? term.amplitude[1] : 0.0));
}

std::string DescribeSlip(const loop::Slipped& slip) {
  const bool is_table = slip.carrier == instruments::Carrier::kTable;
  std::string text = absl::StrCat(is_table ? " table" : " tool", slip.may_be_other ? "?" : "");
  for (const std::optional<double>& moved_mm : slip.moved_mm)
    absl::StrAppend(&text, moved_mm ? absl::StrFormat(" %.3g", *moved_mm * 1e3) : " -");
  return text;
}

}  // namespace

bool IsSame(const ErrorTerm& a, const ErrorTerm& b) {
  const auto *one = std::get_if<shapes::Harmonic>(&a.shape), *other = std::get_if<shapes::Harmonic>(&b.shape);
  if (one == nullptr || other == nullptr) return loop::IsSameEffect(a, b);
  return a.joint == b.joint && a.component == b.component && one->axis == other->axis &&
         std::abs(one->frequency - other->frequency) < (one->is_frequency_free ? 0.05 * other->frequency : 1e-9);
}

Score Judge(const SimulatedCase& simulated, Kind kind, const decide::Options& options) {
  const machine::Machine& machine = simulated.machine;
  Score score;
  const auto start = std::chrono::steady_clock::now();
  const absl::StatusOr<loop::Report> run = decide::CloseLoop(machine, simulated.fit, simulated.check, options);
  score.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  score.effects = kind == Kind::kBump ? 0 : static_cast<int>(simulated.effects.terms.size());
  if (!run.ok()) {
    score.text = std::string(run.status().message());
    score.spurious = 1;
    return score;
  }
  const loop::Report& report = *run;

  score.text = machine.id + " in:";
  std::set<size_t> used;
  for (size_t t = 0; t < simulated.effects.terms.size(); ++t) {
    const ErrorTerm& truth = simulated.effects.terms[t];
    bool is_named = false;
    for (size_t i = 0; !is_named && i < report.effects.size(); ++i) {
      if (used.contains(i) || !IsSame(report.effects[i].term, truth)) continue;
      is_named = true;
      ++score.first;
      used.insert(i);
    }
    for (size_t i = 0; !is_named && i < report.effects.size(); ++i) {
      if (used.contains(i)) continue;
      for (const ErrorTerm& other : report.effects[i].equivalent) is_named = is_named || IsSame(other, truth);
      if (is_named) used.insert(i);
    }
    score.named += is_named;
    score.text += absl::StrFormat(" %s%s (%.1f)", is_named ? "" : "MISSED ", Describe(machine, truth),
                                  simulated.signal_to_noise[t]);
  }
  score.text += " out:";
  for (size_t i = 0; i < report.effects.size(); ++i) {
    score.spurious += !used.contains(i);
    score.text += absl::StrFormat(" %s%s ev %.0f eq %d", used.contains(i) ? "" : "SPURIOUS ",
                                  Describe(machine, report.effects[i].term), report.effects[i].evidence,
                                  report.effects[i].equivalent.size());
  }
  for (const loop::Cause& cause : report.causes) {
    ++score.spurious;  // none of these machines has one
    score.text += absl::StrCat(" SPURIOUS cause: ", cause.subject);
  }
  for (const loop::Unexplained& part : report.unexplained) {
    bool is_right = false;
    if (kind == Kind::kBump) {
      const auto& bump = std::get<shapes::Bump>(simulated.effects.terms[0].shape);
      is_right = part.variable == machine.axes[bump.axis].name && part.from < bump.at + bump.width &&
                 part.to > bump.at - bump.width;
    } else if (IsSlip(kind)) {
      const double tolerance_s = 20.0;
      is_right = part.variable == "t" && part.session == simulated.slipped_session &&
                 part.from < simulated.slip_s + tolerance_s && part.to > simulated.slip_s - tolerance_s && part.slip &&
                 (part.slip->carrier == simulated.carrier || part.slip->may_be_other);
    }
    score.is_structure_noticed = score.is_structure_noticed || is_right;
    // A defect or a slip that is not modelled to the last micrometre may show in a check session, too.
    const bool is_trace = part.kind == loop::Unexplained::kCheckSession && (kind == Kind::kBump || IsSlip(kind));
    score.spurious += !is_right && !is_trace;
    score.text += absl::StrFormat(" %sunexplained %s %.4g..%.4g %s", is_right ? "" : "WRONG ", part.variable, part.from,
                                  part.to, part.session);
    if (part.slip) score.text += DescribeSlip(*part.slip);
  }
  score.is_check_fitted = report.is_check_fitted;
  if (report.is_check_fitted) score.text += " CHECK FITTED";
  for (const std::string& name : report.withdrawn) score.text += " withdrawn " + name;
  if (IsSlip(kind))
    score.text += absl::StrFormat(" (slip in %s at %.0f s)", simulated.slipped_session, simulated.slip_s);
  if (kind == Kind::kBump) {
    const auto& bump = std::get<shapes::Bump>(simulated.effects.terms[0].shape);
    score.text += absl::StrFormat(" (bump at %.3g +- %.2g)", bump.at, bump.width);
  }

  std::set<std::tuple<std::string, int, int>> bad, listed;
  for (const synthetic::BadReading& one : simulated.bad) bad.insert({one.session, one.row, one.column});
  const auto is_of_fit = [&](const std::string& session) {
    return std::any_of(simulated.fit.begin(), simulated.fit.end(),
                       [&](const instruments::MeasuringRun& one) { return one.session == session; });
  };
  for (const identify::Outlier& one : report.fitted.outliers)
    if (is_of_fit(one.session)) listed.insert({one.session, one.row, one.column});
  int readings = 0;
  for (const instruments::MeasuringRun& session : simulated.fit)
    readings += static_cast<int>(session.measured_mm.size());
  score.bad = static_cast<int>(bad.size());
  for (const auto& one : listed) ++(bad.contains(one) ? score.bad_listed : score.good_listed);
  score.good = readings - score.bad;
  score.sigma_ratio = SigmaRatio(simulated, report);

  // The oracle fits the effects that went in, readings set aside as usual.
  identify::Options knowing;
  knowing.model = simulated.declared;
  for (const ErrorTerm& term : simulated.effects.terms) knowing.model->terms.push_back(term);
  const auto known = identify::FitRuns(machine, simulated.fit, knowing);
  if (known.ok() && kind != Kind::kBump && !IsSlip(kind)) {
    const auto check = identify::CheckRuns(machine, simulated.check, known->result.model, knowing);
    if (check.ok()) score.check_ratio = report.check_after.rms_mm / check->result.fit.rms_mm;
  }
  return score;
}

}  // namespace axiscal::rates
