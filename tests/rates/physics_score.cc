#include "tests/rates/physics_score.h"

#include <algorithm>
#include <chrono>
#include <vector>

#include "absl/strings/str_format.h"
#include "core/base/units.h"
#include "core/decide/close_loop.h"
#include "core/identify/identify.h"

namespace axiscal::rates {
namespace {

using machine::ErrorModel;
using machine::ErrorTerm;

// Which of what is there was named, and how.
void CountNames(const PhysicsCase& physics, const loop::Report& report, PhysicsScore* score) {
  const size_t effects = physics.scenario.effects.size();
  std::vector<int> named(effects, 0);  // 0: not at all, 1: in a class, 2: first
  const auto mark = [&](const ErrorTerm& term, int how) {
    bool any = false;
    for (size_t i = 0; i < effects; ++i) {
      if (!IsOfTheForm(physics.scenario.effects[i], term)) continue;
      named[i] = std::max(named[i], how);
      any = true;
    }
    return any;
  };
  for (const loop::Effect& effect : report.effects) {
    bool any = mark(effect.term, 2);
    for (const ErrorTerm& other : effect.equivalent) any |= mark(other, 1);
    score->wrong += !any;
  }
  // One instrument's fault is as good as another: what they read is alike.
  const auto said = [&](loop::Cause::Kind kind) {
    return std::any_of(report.causes.begin(), report.causes.end(),
                       [kind](const loop::Cause& cause) { return cause.kind == kind; });
  };
  const auto mark_causes = [&](size_t count, loop::Cause::Kind kind) {
    if (count == 0) {
      score->wrong += said(kind);
    } else {
      named.insert(named.end(), count, said(kind) ? 2 : 0);
    }
  };
  mark_causes(physics.scenario.faults.size(), loop::Cause::kInstrument);
  mark_causes(physics.scenario.nominal.size(), loop::Cause::kNominal);
  score->causes = static_cast<int>(named.size());
  for (const int how : named) {
    score->right += how == 2;
    score->in_class += how == 1;
    score->silent += how == 0;
  }
}

}  // namespace

PhysicsScore JudgePhysics(const PhysicsCase& physics, bool with_told) {
  PhysicsScore score;
  for (const std::string& name : physics.put_in) score.text += " " + name;
  const auto declared = identify::Identify(physics.machine, physics.simulated.measured.fit);
  const auto start = std::chrono::steady_clock::now();
  const auto closed = decide::CloseLoop(physics.machine, physics.fit, physics.check);
  score.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const auto error_um = [&](const ErrorModel& model) { return base::kUmPerMm * ErrorOverBox(physics, model); };
  score.before_um = score.after_um = score.all_um = error_um(declared.ok() ? declared->model : ErrorModel());
  score.known_um = base::kUmPerMm * ErrorOfOneWhoKnows(physics);
  if (with_told) {
    decide::Options told;
    told.may_name = [&](const loop::Candidate& candidate) { return IsOfTheForm(physics, candidate); };
    const auto of_form = decide::CloseLoop(physics.machine, physics.fit, physics.check, told);
    score.told_um = of_form.ok() ? error_um(machine::NamedErrors(of_form->fitted.model)) : score.before_um;
  }
  score.text += " ->";
  if (!closed.ok()) {  // what nobody can fit is said to be so; wrong nominal data are said by name
    score.text += " " + std::string(closed.status().message());
    score.causes = static_cast<int>(physics.put_in.size());
    const bool is_said = closed.status().message().find("nominal data are wrong") != std::string::npos;
    (is_said && !physics.scenario.nominal.empty() ? score.right : score.silent) = score.causes;
    return score;
  }
  const ErrorModel found = machine::NamedErrors(closed->fitted.model);
  score.after_um = error_um(found);
  score.all_um = error_um(machine::NamedErrors(closed->last_fit->result.model));
  score.held_back = static_cast<int>(closed->held_back.size());
  for (const loop::HeldBack& one : closed->held_back)
    score.text += absl::StrFormat(" held back %s (harm %.3f);", machine::NameOf(physics.machine, one.term), one.harm);
  CountNames(physics, *closed, &score);
  const reports::Loop report = loop::ReportOf(physics.machine, *closed);
  if (report.volumetric) {
    score.has_interval = true;
    score.is_gain_held = report.volumetric->gain_is_held;
    score.low_um = report.volumetric->after.low_um;
    score.high_um = report.volumetric->after.high_um;
    score.text += absl::StrFormat(" said %.2f -> %.2f [%.2f, %.2f] %s;", report.volumetric->before.rms_um,
                                  report.volumetric->after.rms_um, score.low_um, score.high_um,
                                  score.is_gain_held ? "held" : "not held");
  }
  score.text += absl::StrFormat(" design %.2f rms %.2f -> %.2f;", closed->design_effect,
                                1e3 * closed->fit_before.rms_mm, 1e3 * closed->fit_after.rms_mm);
  for (const loop::Effect& effect : closed->effects) {
    // With its amplitude, nm or urad, and what would be left without it.
    ErrorModel without = found;
    std::erase_if(without.terms, [&](const ErrorTerm& term) {
      return term.joint == effect.term.joint && term.component == effect.term.component &&
             term.shape == effect.term.shape;
    });
    score.text += " " + machine::NameOf(physics.machine, effect.term) +
                  absl::StrFormat(" %.4g +- %.2g (%.3f; %d alike)", 1e6 * effect.amplitude,
                                  1e6 * effect.amplitude_sigma, error_um(without), effect.equivalent.size());
  }
  for (const loop::Cause& cause : closed->causes)
    score.text += " [" + cause.subject.substr(0, cause.subject.find(';')) + "]";
  for (const loop::Unexplained& part : closed->unexplained)
    score.text += absl::StrFormat(" {%d %s %.3f..%.3f %s %.2f um}", part.kind, part.variable, part.from, part.to,
                                  part.session, part.rms_mm * base::kUmPerMm);
  return score;
}

}  // namespace axiscal::rates
