#include "core/decide/decide.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "core/base/units.h"
#include "core/decide/effect_search.h"
#include "core/decide/hold_back.h"
#include "core/effects/catalogue.h"
#include "core/identify/noise.h"
#include "core/instruments/clock.h"
#include "core/loop/check.h"
#include "core/loop/describe.h"
#include "core/loop/fitting.h"
#include "core/loop/moved_datum.h"
#include "core/loop/nominal.h"
#include "core/loop/same_always.h"
#include "core/shapes/depends_on.h"

namespace axiscal::decide {
namespace {

using identify::Fit;
using instruments::MeasuringRun;
using loop::Added;
using loop::Candidate;
using loop::Extension;
using loop::Family;

// Fitted sessions that scatter by more than noise may (identify::kMostScatter), and by more than that by chance.
std::vector<loop::Unexplained> ScatteringSessions(const Fit& fit) {
  constexpr double kBeyondChance = 6.0, kAtTheLimit = 1.0 - 1e-9;  // standard deviations
  std::vector<loop::Unexplained> sessions;
  for (size_t i = 0; i < fit.problem.runs.size(); ++i) {
    const MeasuringRun& run = fit.problem.runs[i];
    if (fit.problem.noise[i].sigma_mm < kAtTheLimit * identify::kMostScatter * run.sigma_mm) continue;
    const std::vector<bool>& used = fit.problem.is_used[i];
    const auto count = static_cast<double>(std::count(used.begin(), used.end(), true));
    if (identify::WhitenedSquaresOf(fit.problem, i, fit.residuals_mm[i]) <=
        count + kBeyondChance * std::sqrt(2.0 * count))
      continue;
    double squares = 0.0;
    for (Eigen::Index k = 0; k < fit.residuals_mm[i].size(); ++k)
      if (used[static_cast<size_t>(k)]) squares += std::pow(fit.residuals_mm[i].data()[k], 2);
    sessions.push_back({loop::Unexplained::kScatter, "t", run.time_s.front(), run.time_s.back(), run.session,
                        std::sqrt(squares / count)});
  }
  return sessions;
}

class Decider {
 public:
  Decider(const machine::Machine& machine, std::vector<MeasuringRun> fit, std::vector<MeasuringRun> check,
          const Options& options)
      : machine_(machine),
        runs_(std::move(fit)),
        options_(options),
        policy_(PolicyOf(options)),
        identify_options_(OptionsOf(options)),
        declared_(machine::DeclaredModel(machine)),
        check_(machine, std::move(check), identify_options_),
        all_(check_.After(runs_)),
        search_(machine, declared_, policy_, options_) {}

  absl::StatusOr<loop::Report> Run() {
    loop::Report report;
    report.has_check = !check_.is_empty();
    Ending ending{Extension(machine_, runs_), {}};
    if (options_.progress) options_.progress({"fitting the declared model", 0.0, ""});
    absl::StatusOr<Fit> declared = FitExtension(machine_, ending.extension, identify_options_);
    ASSIGN_OR_RETURN(const std::optional<loop::Cause> nominal,
                     loop::FindNominalFault(machine_, runs_, declared, identify_options_));
    if (nominal && !declared.ok())
      return absl::FailedPreconditionError(
          absl::StrCat("nominal data are wrong: ", nominal->subject, "; ", nominal->correction));
    RETURN_IF_ERROR(declared.status());
    ending.fit = *std::move(declared);
    report.fit_before = ending.fit.result.fit;
    report.declared = ending.fit.result.model;
    const identify::Result of_declared = ending.fit.result;
    KeepResiduals(ending.fit, runs_, 0, &loop::SessionResiduals::before_mm, &report);
    ASSIGN_OR_RETURN(report.check_before, CheckStatistics(ending.fit, &loop::SessionResiduals::before_mm, &report));
    // Errors that are looked for now would stand for it, and nothing is known of the tool point of a machine that is
    // described wrongly.
    if (nominal) {
      RETURN_IF_ERROR(Describe(ending, runs_, &report));
      report.causes.push_back(*nominal);
      report.verdict = loop::Verdict::kUnexplained;
      report.last_fit = std::make_shared<Fit>(std::move(ending.fit));
      return report;
    }
    // Names are those that all sessions ask for.
    if (!check_.is_empty()) {
      ending.extension = Extension(machine_, all_);
      ASSIGN_OR_RETURN(ending.fit, FitExtension(machine_, ending.extension, identify_options_));
    }
    RETURN_IF_ERROR(Settle(&ending.extension, &ending.fit, &report));
    RETURN_IF_ERROR(DropUntold(&ending, &report));
    std::optional<Ending> of_fit_sessions;
    RETURN_IF_ERROR(AskWhetherStartsAreAlike(&ending, &of_fit_sessions, &report));
    std::vector<loop::Unexplained> sessions;
    if (check_.is_empty()) {
      RETURN_IF_ERROR(Describe(ending, runs_, &report));
    } else {
      ASSIGN_OR_RETURN(std::optional<Ending> alone, Alone(ending, std::move(of_fit_sessions), &sessions));
      report.is_check_fitted = !alone.has_value();
      if (alone) {
        RETURN_IF_ERROR(Describe(*alone, runs_, &report));
        ending = *std::move(alone);
      } else {
        RETURN_IF_ERROR(Describe(ending, all_, &report));
        RETURN_IF_ERROR(check_.Settle(ending.fit));
        sessions = check_.UnexplainedWhereFitted();
      }
      report.unexplained.insert(report.unexplained.end(), sessions.begin(), sessions.end());
    }
    // Before anything is added to what was fitted: it may be fitted again.
    RETURN_IF_ERROR(HoldBack(machine_, ending.extension, ending.fit, of_declared, policy_, identify_options_, &report));
    ASSIGN_OR_RETURN(const std::vector<reports::WarningFacts> datum,
                     loop::ProposeDatum(ending.fit, ending.extension, identify_options_));
    report.fitted.warnings.insert(report.fitted.warnings.end(), datum.begin(), datum.end());
    const std::vector<loop::Unexplained> scattering = ScatteringSessions(ending.fit);
    report.unexplained.insert(report.unexplained.end(), scattering.begin(), scattering.end());
    KeepToWhatWasSeen(&report);
    if (!report.unexplained.empty()) report.verdict = loop::Verdict::kUnexplained;
    // Steps are of fits of all sessions; what the last one left is said of those that amplitudes are fitted to.
    if (!report.steps.empty()) report.steps.back().rms_mm = report.fit_after.rms_mm;
    for (loop::Cause& cause : loop::NominalConstants(machine_, ending.fit)) report.causes.push_back(std::move(cause));
    report.last_fit = std::make_shared<Fit>(std::move(ending.fit));
    return report;
  }

 private:
  // Late warmths are known for the temperatures that the readings saw, drifts for their time, not beyond.
  void KeepToWhatWasSeen(loop::Report* report) const {
    const std::vector<MeasuringRun>& runs = report->is_check_fitted ? all_ : runs_;
    // The least and the greatest value in all readings.
    const auto keep_to = [&](const auto& value, double* from, double* to) {
      double least = INFINITY, greatest = -INFINITY;
      for (const MeasuringRun& run : runs) {
        if (run.path_readings != nullptr) continue;
        for (int k = 0; k < run.reading_count(); ++k) {
          least = std::min(least, value(run.StateOf(k)));
          greatest = std::max(greatest, value(run.StateOf(k)));
        }
      }
      if (least > greatest) return;  // readings along a path alone: no moment belongs to them
      *from = least;
      *to = greatest;
    };
    const auto keep = [&](machine::ErrorTerm* term) {
      if (auto* const lag = std::get_if<shapes::ThermalLag>(&term->shape)) {
        const auto late = [&](const shapes::State& state) { return lag->LateAt(state, lag->tau_s).celsius; };
        keep_to(late, &lag->from_celsius, &lag->to_celsius);
      } else if (auto* const drift = std::get_if<shapes::Drift>(&term->shape)) {
        keep_to([](const shapes::State& state) { return state.time_s; }, &drift->from_s, &drift->to_s);
      }
    };
    for (machine::ErrorTerm& term : report->fitted.model.terms) keep(&term);
    for (loop::Effect& effect : report->effects) keep(&effect.term);
  }

  struct Ending {
    Extension extension;
    Fit fit;
  };

  absl::Status Describe(const Ending& ending, const std::vector<MeasuringRun>& runs, loop::Report* report) {
    ASSIGN_OR_RETURN(report->check_after, CheckStatistics(ending.fit, &loop::SessionResiduals::after_mm, report));
    loop::Describe(machine_, runs, all_, ending.extension, ending.fit, {policy_.alike, policy_.order_falloff}, report);
    KeepResiduals(ending.fit, runs_, 0, &loop::SessionResiduals::after_mm, report);
    return absl::OkStatus();
  }

  // Where sessions overlap in time each counts from a start of its own (instruments::FindOverlap), and a drift says
  // that the machine does the same after every start. Where the check sessions are foretold better without, it does
  // not.
  // `of_fit_sessions`: AmplitudesOfFitSessions of what stays, where they were asked for.
  absl::Status AskWhetherStartsAreAlike(Ending* ending, std::optional<Ending>* of_fit_sessions, loop::Report* report) {
    const auto needs_one_clock = [](const Candidate& one) {
      return loop::IsTerm(one.family)
                 ? shapes::NeedsOneClock(one.term.shape)
                 : one.family == Family::kInstrument && one.distortion.kind == instruments::Distortion::kMotion;
    };
    const auto any = [&](const Extension& extension) {
      return std::any_of(extension.effects.begin(), extension.effects.end(),
                         [&](const Added& one) { return needs_one_clock(one.candidate); });
    };
    if (check_.is_empty() || !any(ending->extension) || !instruments::FindOverlap(all_)) return absl::OkStatus();
    Ending other{Extension(machine_, all_), {}};
    for (size_t i = 0; i < ending->extension.effects.size(); ++i) {
      Added one = ending->extension.effects[i];
      if (needs_one_clock(one.candidate)) continue;
      if (IsTerm(one.candidate.family)) one.candidate.term = ending->fit.point.model.terms[ending->extension.TermOf(i)];
      one.choice = {};
      other.extension.effects.push_back(std::move(one));
    }
    other.extension.bad_rows = ending->extension.bad_rows;
    absl::StatusOr<Fit> fit = FitExtension(machine_, other.extension, identify_options_);
    if (absl::IsCancelled(fit.status())) return fit.status();
    if (!fit.ok()) return absl::OkStatus();  // nothing else stands for it
    other.fit = *std::move(fit);
    loop::Report its = *report;
    search_.LeaveOut(needs_one_clock);
    RETURN_IF_ERROR(Settle(&other.extension, &other.fit, &its));
    RETURN_IF_ERROR(DropUntold(&other, &its));
    ASSIGN_OR_RETURN(*of_fit_sessions, AmplitudesOfFitSessions(*ending));
    ASSIGN_OR_RETURN(std::optional<Ending> without, AmplitudesOfFitSessions(other));
    if (!*of_fit_sessions || !without) return absl::OkStatus();
    ASSIGN_OR_RETURN(const Fit under_with, check_.Under((*of_fit_sessions)->fit));
    ASSIGN_OR_RETURN(const Fit under_without, check_.Under(without->fit));
    if (!(under_without.result.fit.rms_mm < under_with.result.fit.rms_mm)) return absl::OkStatus();
    *of_fit_sessions = std::move(without);
    *ending = std::move(other);
    *report = std::move(its);
    return absl::OkStatus();
  }

  // The names of `whole` with amplitudes from the fit sessions alone; nothing where they do not tell these amplitudes.
  absl::StatusOr<std::optional<Ending>> AmplitudesOfFitSessions(const Ending& whole) const {
    const auto fitted = static_cast<int>(runs_.size());
    Ending alone{Extension(machine_, runs_), {}};
    const auto is_of_check = [&](const Candidate& one) {
      const auto can_have = [&](const MeasuringRun& run) { return instruments::CanHave(run, one.distortion); };
      if (one.family == Family::kInstrument) return std::none_of(runs_.begin(), runs_.end(), can_have);
      return one.family == Family::kStep && one.run >= fitted;
    };
    for (size_t i = 0; i < whole.extension.effects.size(); ++i) {
      Added one = whole.extension.effects[i];
      if (is_of_check(one.candidate)) return std::nullopt;
      if (IsTerm(one.candidate.family)) one.candidate.term = whole.fit.point.model.terms[whole.extension.TermOf(i)];
      alone.extension.effects.push_back(std::move(one));
    }
    for (const loop::BadRow& bad : whole.extension.bad_rows)
      if (bad.run < fitted) alone.extension.bad_rows.push_back(bad);
    absl::StatusOr<Fit> fit = FitExtension(machine_, alone.extension, identify_options_);
    if (absl::IsCancelled(fit.status())) return fit.status();
    if (!fit.ok()) return std::nullopt;
    alone.fit = *std::move(fit);
    return alone;
  }

  // The same, so that the check sessions still prove something. Nothing where they are not foretold.
  // `sessions`: check sessions that stay unexplained.
  // `alone`: what AmplitudesOfFitSessions has said of it; nothing where it was not asked.
  absl::StatusOr<std::optional<Ending>> Alone(const Ending& whole, std::optional<Ending> alone,
                                              std::vector<loop::Unexplained>* sessions) {
    if (!alone) {
      ASSIGN_OR_RETURN(alone, AmplitudesOfFitSessions(whole));
    }
    if (!alone) return std::nullopt;
    for (size_t i = 0; i < alone->extension.effects.size(); ++i) {
      if (IsUnnamed(alone->extension.effects[i].candidate.family)) continue;
      if (WorthOf(*alone, i) < 0.0) return std::nullopt;
    }
    RETURN_IF_ERROR(check_.Settle(alone->fit));
    ASSIGN_OR_RETURN(*sessions, check_.UnexplainedSessions(alone->fit));
    if (alone->extension.effects.empty()) return alone;
    const absl::StatusOr<std::shared_ptr<const Fit>> joint = check_.Joint(alone->fit);
    if (absl::IsCancelled(joint.status())) return joint.status();
    if (!joint.ok() || !loop::Check::IsForetold(**joint, alone->fit)) return std::nullopt;
    return alone;
  }

  static objective::Policy PolicyOf(const Options& options) {
    objective::Policy policy = options.policy;
    if (options.max_effects) policy.most_effects = std::min(policy.most_effects, *options.max_effects);
    return policy;
  }

  static identify::Options OptionsOf(const Options& options) {
    identify::Options out;
    out.cancelled = options.cancelled;
    out.scale_uncertainties = true;
    out.profile_intervals = false;  // of fits on the way, which a model that misses bends
    return out;
  }

  std::multiset<Key> KeysOf(const Extension& extension) const {
    std::multiset<Key> keys;
    for (const Added& one : extension.effects) keys.insert(KeyOf(machine_, one.candidate));
    for (const loop::BadRow& bad : extension.bad_rows) keys.insert({"row", bad.run, static_cast<int>(bad.row)});
    return keys;
  }

  // What the amplitudes of an effect are worth in a full fit beyond what they cost, chi-square units. Those of a free
  // curve are one size. 0 where the fit does not tell any of them.
  double WorthOf(const Ending& ending, size_t effect) const {
    const int term = ending.extension.TermOf(effect);
    const std::vector<identify::Parameter> parameters = identify::ListParameters(ending.fit.point.model, true);
    bool is_told = false;
    for (size_t i = 0; i < parameters.size(); ++i)
      is_told |=
          parameters[i].term == term && !parameters[i].is_nonlinear && ending.fit.result.estimates[i].identifiable;
    const shapes::Shape& shape = ending.extension.effects[effect].candidate.term.shape;
    const int count = shapes::IsFree(shape) ? 1 : shapes::BasisCount(shape);
    return (is_told ? loop::EvidenceOf(ending.fit, term) : 0.0) - policy_.per_column * count;
  }

  // Whether the full fit has left what machines have (effects::LargestErrorOf), which the search keeps to.
  bool IsBeyondMachines(const Ending& ending, size_t effect) const {
    const machine::ErrorTerm& term = ending.fit.point.model.terms[ending.extension.TermOf(effect)];
    if (shapes::IsFree(term.shape)) return false;  // of these the prior is in the fit
    const double most = effects::LargestErrorOf(ending.extension.effects[effect].candidate);
    return !(loop::InReadings(ending.fit.problem.runs, term).largest <= most);
  }

  // Takes off effects that the full fit does not tell, the faintest first: the linearised model had seen a trace of
  // them, or one stood for what another was too large by, and the two would part where nothing was measured; what is
  // larger than machines have before all others.
  absl::Status DropUntold(Ending* ending, loop::Report* report) const {
    for (;;) {
      std::optional<size_t> faintest;
      double least = 0.0;
      for (size_t i = 0; i < ending->extension.effects.size(); ++i) {
        if (!IsTerm(ending->extension.effects[i].candidate.family)) continue;
        const double worth = IsBeyondMachines(*ending, i) ? -INFINITY : WorthOf(*ending, i);
        if (worth < least) faintest = i, least = worth;
      }
      if (!faintest) return absl::OkStatus();
      Extension told = ending->extension;
      const std::string name = told.NameOf(*faintest);
      const int term = told.TermOf(*faintest);
      told.effects.erase(told.effects.begin() + static_cast<std::ptrdiff_t>(*faintest));
      // Of what others may be the models hold it too.
      for (Added& other : told.effects) {
        const auto drop = [term](machine::ErrorModel& model) {
          if (term < static_cast<int>(model.terms.size())) model.terms.erase(model.terms.begin() + term);
        };
        drop(other.choice.as_found);
        for (auto& rival : other.choice.rivals) drop(rival.model);
      }
      ASSIGN_OR_RETURN(ending->fit, FitExtension(machine_, told, identify_options_));
      ending->extension = std::move(told);
      report->steps.push_back({loop::SelectionStep::kDropped, name, ending->fit.result.fit.rms_mm});
    }
  }

  // Searches and fits until the set of effects stays.
  absl::Status Settle(Extension* extension, Fit* fit, loop::Report* report) {
    constexpr int kRounds = 10;  // bounds what goes on changing; dirty readings with several effects needed six
    std::vector<std::multiset<Key>> seen = {KeysOf(*extension)};
    bool is_asked = false;  // the last change was AskExactly()'s
    for (int round = 0; round < kRounds; ++round) {
      Extension next(machine_, check_.is_empty() ? runs_ : all_);
      search_.Run(*extension, *fit, round == 0 ? report : nullptr, &next);
      if (options_.cancelled && options_.cancelled()) return absl::CancelledError("cancelled");
      report->has_stopped_early = search_.has_stopped_early();
      report->design_effect = search_.design_effect();
      const std::multiset<Key> keys = KeysOf(next);
      const bool stays = keys == seen.back();
      if (stays) {
        TakeOver(machine_, next, extension);
        const bool any_fault = std::any_of(extension->effects.begin(), extension->effects.end(), [](const Added& one) {
          return one.candidate.family == Family::kInstrument;
        });
        if (any_fault) {  // its amplitudes moved a little
          absl::StatusOr<Fit> again = FitExtension(machine_, *extension, identify_options_);
          if (absl::IsCancelled(again.status())) return again.status();
          if (again.ok()) *fit = *std::move(again);
        }
        ASSIGN_OR_RETURN(const bool is_replaced, AskExactly(extension, fit, report));
        if (!is_replaced || round + 1 == kRounds) return absl::OkStatus();
        seen.push_back(KeysOf(*extension));
        is_asked = true;
        continue;
      }
      const bool is_known = std::find(seen.begin(), seen.end(), keys) != seen.end();
      // The linearised model would take back what full fits have shown.
      if (is_known && is_asked) return absl::OkStatus();
      is_asked = false;
      absl::StatusOr<Fit> fitted = FitExtension(machine_, next, identify_options_);
      if (absl::IsCancelled(fitted.status())) return fitted.status();
      if (!fitted.ok()) return absl::OkStatus();
      NoteChanges(*extension, next, *fitted, report->fit_before.rms_mm, report);
      if (options_.progress) {
        progress_ = std::max(progress_, (round + 1.0) / (kRounds + 1.0));  // of a second search it stands for a while
        options_.progress({"closing the loop", progress_,
                           absl::StrFormat("%d candidates, %d effects, rms %.3f um", report->candidates,
                                           next.effects.size(), fitted->result.fit.rms_mm * base::kUmPerMm)});
      }
      *extension = std::move(next);
      *fit = *std::move(fitted);
      if (is_known) return AskExactly(extension, fit, report).status();  // it goes round in a circle
      seen.push_back(keys);
    }
    return absl::OkStatus();
  }

  // The objective of a linearised model is off by a share of what an effect explains: members of a class that come that
  // near are fitted in full. The best takes the effect's place, by chi-square and by how much it leaned on set-ups: the
  // backlash of an angle on a target whose height is free in every session has an amplitude for each. Those within
  // Policy::alike of it, with that or by chi-square alone, stay its class.
  absl::StatusOr<bool> AskExactly(Extension* extension, Fit* fit, loop::Report* report) {
    bool any = false;
    for (size_t i = 0; i < extension->effects.size(); ++i) {
      Added& added = extension->effects[i];
      if (IsUnnamed(added.candidate.family) || added.equivalent.empty()) continue;
      if (shapes::IsFree(added.candidate.term.shape)) continue;  // of free curves the evidence is asked, not chi-square
      const int term = extension->TermOf(i);
      std::vector<machine::ErrorTerm> terms = {fit->result.model.terms[term]};
      for (const Candidate& one : added.equivalent) terms.push_back(one.term);
      const std::vector<int> first = loop::FirstOfTheSame(machine_, fit->problem.runs.front().tip_mm, terms);
      std::vector<double> squares(terms.size(), INFINITY), costs(terms.size(), INFINITY);
      std::vector<std::optional<machine::ErrorModel>> models(terms.size());
      models[0] = fit->result.model;
      squares[0] = loop::SquaresOf(*fit);
      costs[0] = squares[0] + loop::LeaningOf(*fit);
      const auto fit_with = [&](size_t m) {
        machine::ErrorModel model = fit->result.model;
        model.terms[term] = terms[m];
        return loop::Refit(*fit, model, identify_options_);
      };
      int asked = 0;
      constexpr int kMostAsked = 8;
      for (size_t m = 1; m < terms.size(); ++m) {
        if (first[m] < static_cast<int>(m)) {
          squares[m] = squares[first[m]];
          costs[m] = costs[first[m]];
        } else if (++asked <= kMostAsked) {
          const absl::StatusOr<Fit> other = fit_with(m);
          if (absl::IsCancelled(other.status())) return other.status();
          if (!other.ok()) continue;
          squares[m] = loop::SquaresOf(*other);
          costs[m] = squares[m] + loop::LeaningOf(*other);
          models[m] = other->result.model;
        }
      }
      std::vector<Candidate> members = {added.candidate};
      members.insert(members.end(), added.equivalent.begin(), added.equivalent.end());
      // A plain name wins a tie here as it does in the search, or each would undo what the other did.
      for (size_t m = 0; m < members.size(); ++m)
        if (loop::IsFurther(members[m].family)) squares[m] += policy_.exotic, costs[m] += policy_.exotic;
      // The simplest of those that fit best.
      const double least = *std::min_element(costs.begin(), costs.end());
      size_t which = terms.size();
      for (size_t m = 0; m < members.size(); ++m) {
        if (costs[m] < least + policy_.replacement_gain &&
            (which == terms.size() ||
             loop::Complexity(machine_, members[m]) < loop::Complexity(machine_, members[which])))
          which = m;
      }
      absl::StatusOr<Fit> best = which == 0 ? *fit : fit_with(which);
      if (absl::IsCancelled(best.status())) return best.status();
      if (!best.ok()) which = 0;
      added.equivalent.clear();
      added.choice = {
          loop::IsTerm(members[which].family) ? machine::NameOf(machine_, members[which].term) : "", {}, {}, {}};
      // The simplest of names of one error everywhere may be another than the one that was fitted.
      const int fitted = first[which];
      if (models[fitted]) added.choice.as_found = *models[fitted];
      for (size_t m = 0; m < members.size(); ++m) {
        if (m == which || !(std::min(squares[m] - squares[which], costs[m] - costs[which]) < policy_.alike)) continue;
        added.equivalent.push_back(members[m]);
        if (models[m] && models[fitted] && static_cast<int>(m) != fitted)
          added.choice.rivals.push_back({*models[m], std::exp(-0.5 * (costs[m] - costs[which]))});
      }
      if (which == 0) continue;
      any |= costs[0] > least + policy_.replacement_gain;
      added.candidate = members[which];
      added.candidate.term = best->result.model.terms[term];
      *fit = *std::move(best);
      report->steps.push_back({loop::SelectionStep::kReplaced, extension->NameOf(i), fit->result.fit.rms_mm});
    }
    return any;
  }

  // What each effect leaves of the readings is that of the linearised model: nothing is fitted for it.
  static void NoteChanges(const Extension& before, const Extension& after, const Fit& fit, double declared_rms_mm,
                          loop::Report* report) {
    const auto names_of = [](const Extension& extension) {
      std::vector<std::string> names;
      for (size_t i = 0; i < extension.effects.size(); ++i) names.push_back(extension.NameOf(i));
      return names;
    };
    const std::vector<std::string> old_names = names_of(before), new_names = names_of(after);
    const auto has = [](const std::vector<std::string>& names, const std::string& name) {
      return std::find(names.begin(), names.end(), name) != names.end();
    };
    for (const std::string& name : old_names)
      if (!has(new_names, name)) report->steps.push_back({loop::SelectionStep::kDropped, name, fit.result.fit.rms_mm});
    for (size_t i = 0; i < new_names.size(); ++i) {
      if (has(old_names, new_names[i])) continue;
      const double rms_mm = i + 1 < new_names.size() ? after.effects[i].left * declared_rms_mm : fit.result.fit.rms_mm;
      report->steps.push_back({loop::SelectionStep::kAdded, new_names[i], rms_mm});
    }
  }

  void KeepResiduals(const Fit& fit, const std::vector<MeasuringRun>& runs, size_t offset,
                     Eigen::MatrixXd loop::SessionResiduals::*field, loop::Report* report) const {
    report->residuals.resize(runs_.size() + check_.runs().size());
    for (size_t i = 0; i < runs.size(); ++i) {
      loop::SessionResiduals& kept = report->residuals[offset + i];
      kept.session = runs[i].session;
      kept.is_check = offset > 0;
      kept.*field = fit.residuals_mm[i];
    }
  }

  absl::StatusOr<identify::FitStatistics> CheckStatistics(const Fit& best,
                                                          Eigen::MatrixXd loop::SessionResiduals::*field,
                                                          loop::Report* report) {
    if (check_.is_empty()) return identify::FitStatistics{};
    ASSIGN_OR_RETURN(const Fit fit, check_.Under(best));
    KeepResiduals(fit, check_.runs(), runs_.size(), field, report);
    return fit.result.fit;
  }

  const machine::Machine& machine_;
  const std::vector<MeasuringRun> runs_;
  const Options options_;
  const objective::Policy policy_;
  const identify::Options identify_options_;
  const machine::ErrorModel declared_;
  loop::Check check_;
  const std::vector<MeasuringRun> all_;  // fit sessions, then check sessions
  EffectSearch search_;
  double progress_ = 0.0;  // share that was reported last
};

}  // namespace

absl::StatusOr<loop::Report> Decide(const machine::Machine& machine, std::vector<MeasuringRun> fit,
                                    std::vector<MeasuringRun> check, const Options& options) {
  // What a machine remembers of temperatures runs on from the fit sessions into the check sessions.
  instruments::ShareTemperatures({&fit, &check});
  return Decider(machine, std::move(fit), std::move(check), options).Run();
}

}  // namespace axiscal::decide
