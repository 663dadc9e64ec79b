#include "core/decide/decide.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <tuple>

#include "core/base/units.h"
#include "core/effects/catalogue.h"
#include "core/effects/shaped.h"
#include "core/identify/noise.h"
#include "core/loop/check.h"
#include "core/loop/describe.h"
#include "core/loop/fitting.h"
#include "core/loop/moved_datum.h"
#include "core/loop/nominal.h"
#include "core/loop/same_always.h"
#include "core/objective/search.h"

namespace axiscal::decide {
namespace {

using effects::Effect;
using identify::Fit;
using instruments::MeasuringRun;
using loop::Added;
using loop::Candidate;
using loop::Extension;
using loop::Family;

// By how much a linearised objective may be off, share of what an effect explains: seen with machines' errors of a
// hundred micrometres.
constexpr double kLinear = 0.01;

// What makes two sets of effects the same: names, and for slips and bad rows their places.
using Key = std::tuple<std::string, int, int>;

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

// What would leave no trace. Constants are mostly only where a machine's zero is; crossed variables and fine scans
// would flood the list.
std::vector<machine::ErrorTerm> NotVisible(const objective::Scorer& scorer, const std::vector<Effect>& effects) {
  std::vector<machine::ErrorTerm> terms, visible;  // at any time constant or length
  for (size_t g = 0; g < effects.size(); ++g) {
    const Family family = effects[g].candidate.family;
    if (effects[g].bad_row >= 0 || IsUnnamed(family) || family == Family::kConstant || family == Family::kCross ||
        family == Family::kFineHarmonic || family == Family::kPitch)
      continue;
    const machine::ErrorTerm& term = effects[g].candidate.term;
    std::vector<machine::ErrorTerm>& list = scorer.IsVisible(static_cast<int>(g)) ? visible : terms;
    if (std::none_of(list.begin(), list.end(), [&](const auto& one) { return loop::IsSameEffect(term, one); }))
      list.push_back(term);
  }
  std::erase_if(terms, [&](const machine::ErrorTerm& term) {
    return std::any_of(visible.begin(), visible.end(), [&](const auto& one) { return loop::IsSameEffect(term, one); });
  });
  return terms;
}

class Decider {
 public:
  Decider(const machine::Machine& machine, std::vector<MeasuringRun> fit, std::vector<MeasuringRun> check,
          const Options& options)
      : machine_(machine),
        runs_(std::move(fit)),
        options_(options),
        policy_(options.policy),
        identify_options_(OptionsOf(options)),
        declared_(machine::DeclaredModel(machine)),
        check_(machine, std::move(check), identify_options_),
        all_(check_.After(runs_)) {
    if (options.max_effects) policy_.most_effects = std::min(policy_.most_effects, *options.max_effects);
  }

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
    KeepResiduals(ending.fit, runs_, 0, &loop::SessionResiduals::before_mm, &report);
    ASSIGN_OR_RETURN(report.check_before, CheckStatistics(ending.fit, &loop::SessionResiduals::before_mm, &report));
    if (nominal) {  // errors that are looked for now would stand for it
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
    std::vector<loop::Unexplained> sessions;
    if (check_.is_empty()) {
      RETURN_IF_ERROR(Describe(ending, runs_, &report));
    } else {
      ASSIGN_OR_RETURN(const identify::FitStatistics together,
                       CheckStatistics(ending.fit, &loop::SessionResiduals::after_mm, &report));
      ASSIGN_OR_RETURN(std::optional<Ending> alone, Alone(ending, together.rms_mm, &sessions));
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
    for (machine::ErrorTerm& term : report->fitted.model.terms) {
      const shapes::Shape found = term.shape;
      if (auto* const lag = std::get_if<shapes::ThermalLag>(&term.shape)) {
        const auto late = [&](const shapes::State& state) { return lag->LateAt(state, lag->tau_s).celsius; };
        keep_to(late, &lag->from_celsius, &lag->to_celsius);
      } else if (auto* const drift = std::get_if<shapes::Drift>(&term.shape)) {
        keep_to([](const shapes::State& state) { return state.time_s; }, &drift->from_s, &drift->to_s);
      } else {
        continue;
      }
      for (loop::Effect& effect : report->effects)
        if (effect.term.shape == found) effect.term.shape = term.shape;
    }
  }

  struct Ending {
    Extension extension;
    Fit fit;
  };

  absl::Status Describe(const Ending& ending, const std::vector<MeasuringRun>& runs, loop::Report* report) {
    ASSIGN_OR_RETURN(report->check_after, CheckStatistics(ending.fit, &loop::SessionResiduals::after_mm, report));
    loop::Describe(machine_, runs, ending.extension, ending.fit, report);
    KeepResiduals(ending.fit, runs_, 0, &loop::SessionResiduals::after_mm, report);
    return absl::OkStatus();
  }

  // The names of `whole` with amplitudes from the fit sessions alone, so that the check sessions still prove something.
  // Nothing where the fit sessions do not tell these amplitudes. `sessions`: check sessions that stay unexplained.
  absl::StatusOr<std::optional<Ending>> Alone(const Ending& whole, double check_rms_mm,
                                              std::vector<loop::Unexplained>* sessions) {
    constexpr double kNoWorse = 1.02;  // of the check sessions' rms: what a fit of them too would gain
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
    for (size_t i = 0; i < alone.extension.effects.size(); ++i) {
      if (!IsUnnamed(alone.extension.effects[i].candidate.family) &&
          loop::EvidenceOf(alone.fit, alone.extension.TermOf(i)) < policy_.evidence)
        return std::nullopt;
    }
    RETURN_IF_ERROR(check_.Settle(alone.fit));
    ASSIGN_OR_RETURN(*sessions, check_.UnexplainedSessions(alone.fit));
    ASSIGN_OR_RETURN(const Fit under, check_.Under(alone.fit));
    const bool is_foretold = under.result.fit.rms_mm <= kNoWorse * check_rms_mm;
    if (!alone.extension.effects.empty() && (!sessions->empty() || !is_foretold)) return std::nullopt;
    return alone;
  }

  static identify::Options OptionsOf(const Options& options) {
    identify::Options out;
    out.cancelled = options.cancelled;
    out.scale_uncertainties = true;
    out.profile_intervals = false;  // of fits on the way, which a model that misses bends
    return out;
  }

  Key KeyOf(const Candidate& one) const {
    if (one.family == Family::kStep) return {"slip", one.run, one.first_reading};
    if (one.family == Family::kInstrument)
      return {absl::StrCat(one.distortion.kind, " ", one.distortion.instrument),
              static_cast<int>(one.distortion.carrier), one.distortion.order};
    machine::ErrorTerm term = one.term;
    // Fitted lengths move a little in every fit.
    if (double* parameter = shapes::NonlinearParameter(term.shape)) *parameter = 1.0;
    return {machine::NameOf(machine_, term), term.joint, static_cast<int>(term.component)};
  }

  std::multiset<Key> KeysOf(const Extension& extension) const {
    std::multiset<Key> keys;
    for (const Added& one : extension.effects) keys.insert(KeyOf(one.candidate));
    for (const loop::BadRow& bad : extension.bad_rows) keys.insert({"row", bad.run, static_cast<int>(bad.row)});
    return keys;
  }

  // The effects of an extension as they were fitted.
  std::vector<Candidate> FittedEffects(const Extension& extension, const Fit& fit) const {
    std::vector<Candidate> fitted;
    for (size_t i = 0; i < extension.effects.size(); ++i) {
      Candidate one = extension.effects[i].candidate;
      if (IsTerm(one.family)) one.term = fit.point.model.terms[extension.TermOf(i)];
      fitted.push_back(one);
    }
    return fitted;
  }

  // Searches and fits until the set of effects stays.
  absl::Status Settle(Extension* extension, Fit* fit, loop::Report* report) {
    constexpr int kRounds = 5;
    std::vector<std::multiset<Key>> seen = {KeysOf(*extension)};
    for (int round = 0; round < kRounds; ++round) {
      Extension next(machine_, check_.is_empty() ? runs_ : all_);
      Search(*extension, *fit, round == 0, &next, report);
      if (options_.cancelled && options_.cancelled()) return absl::CancelledError("cancelled");
      const std::multiset<Key> keys = KeysOf(next);
      const bool stays = keys == seen.back();
      if (stays) {
        TakeOver(next, extension);
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
        continue;
      }
      absl::StatusOr<Fit> fitted = FitExtension(machine_, next, identify_options_);
      if (absl::IsCancelled(fitted.status())) return fitted.status();
      if (!fitted.ok()) return absl::OkStatus();
      NoteChanges(*extension, next, *fitted, report->fit_before.rms_mm, report);
      if (options_.progress) {
        options_.progress({"closing the loop", (round + 1.0) / (kRounds + 1.0),
                           absl::StrFormat("%d candidates, %d effects, rms %.3f um", report->candidates,
                                           next.effects.size(), fitted->result.fit.rms_mm * base::kUmPerMm)});
      }
      *extension = std::move(next);
      *fit = *std::move(fitted);
      if (std::find(seen.begin(), seen.end(), keys) != seen.end()) return absl::OkStatus();
      seen.push_back(keys);
    }
    return absl::OkStatus();
  }

  // Scores and classes of the last search, for the same effects in the order in which they were fitted.
  void TakeOver(const Extension& searched, Extension* extension) const {
    for (Added& one : extension->effects) {
      for (const Added& other : searched.effects) {
        if (KeyOf(other.candidate) != KeyOf(one.candidate)) continue;
        const machine::ErrorTerm term = one.candidate.term;
        one = other;
        one.candidate.term = term;
        break;
      }
    }
  }

  // The objective of a linearised model is off by a share of what an effect explains: members of a class that come that
  // near are fitted in full. The best takes the effect's place; those within Policy::alike of it stay its class.
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
      std::vector<double> squares(terms.size(), INFINITY);
      std::vector<std::optional<machine::ErrorModel>> models(terms.size());
      models[0] = fit->result.model;
      squares[0] = loop::SquaresOf(*fit);
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
        } else if (++asked <= kMostAsked) {
          const absl::StatusOr<Fit> other = fit_with(m);
          if (absl::IsCancelled(other.status())) return other.status();
          if (!other.ok()) continue;
          squares[m] = loop::SquaresOf(*other);
          models[m] = other->result.model;
        }
      }
      std::vector<Candidate> members = {added.candidate};
      members.insert(members.end(), added.equivalent.begin(), added.equivalent.end());
      // A plain name wins a tie here as it does in the search, or each would undo what the other did.
      for (size_t m = 0; m < members.size(); ++m)
        if (loop::IsFurther(members[m].family)) squares[m] += policy_.exotic;
      // The simplest of those that fit best.
      const double least = *std::min_element(squares.begin(), squares.end());
      size_t which = terms.size();
      for (size_t m = 0; m < members.size(); ++m) {
        if (squares[m] < least + policy_.replacement_gain &&
            (which == terms.size() ||
             loop::Complexity(machine_, members[m]) < loop::Complexity(machine_, members[which])))
          which = m;
      }
      absl::StatusOr<Fit> best = which == 0 ? *fit : fit_with(which);
      if (absl::IsCancelled(best.status())) return best.status();
      if (!best.ok()) which = 0;
      added.equivalent.clear();
      added.choice = {
          loop::IsTerm(members[which].family) ? machine::NameOf(machine_, members[which].term) : "", {}, {}};
      // The simplest of names of one error everywhere may be another than the one that was fitted.
      const int fitted = first[which];
      if (models[fitted]) added.choice.as_found = *models[fitted];
      for (size_t m = 0; m < members.size(); ++m) {
        if (m == which || !(squares[m] < squares[which] + policy_.alike)) continue;
        added.equivalent.push_back(members[m]);
        if (models[m] && models[fitted] && static_cast<int>(m) != fitted)
          added.choice.rivals.push_back({*models[m], std::exp(-0.5 * (squares[m] - squares[which]))});
      }
      if (which == 0) continue;
      any |= squares[0] > least + policy_.replacement_gain;
      added.candidate = members[which];
      added.candidate.term = best->result.model.terms[term];
      *fit = *std::move(best);
      report->steps.push_back({loop::SelectionStep::kReplaced, extension->NameOf(i), fit->result.fit.rms_mm});
    }
    return any;
  }

  void Search(const Extension& extension, const Fit& fit, bool is_first, Extension* next, loop::Report* report) {
    identify::Problem problem = fit.problem;
    for (const loop::BadRow& bad : extension.bad_rows) problem.is_used[bad.run][bad.row] = true;
    const effects::Linearised linearised =
        effects::Linearise(problem, fit.point, static_cast<int>(declared_.terms.size()));
    effects::Catalogue catalogue =
        effects::MakeCatalogue(linearised, declared_, FittedEffects(extension, fit), extension.bad_rows);
    objective::Scorer scorer(linearised.rows, std::move(catalogue.sources), policy_);
    for (size_t g = 0; options_.may_name && g < catalogue.effects.size(); ++g) {
      const Effect& effect = catalogue.effects[g];
      if (effect.bad_row < 0 && !options_.may_name(effect.candidate)) scorer.Exclude(static_cast<int>(g));
    }
    const objective::DesignEffect design(scorer);
    objective::Searcher searcher(&scorer, &design, options_.cancelled);
    std::vector<objective::Start> starts(1);
    for (const int group : catalogue.known) {
      const Candidate& known = catalogue.effects[group].candidate;
      const double variance = known.family == Family::kInstrument ? known.distortion.variance_mm2
                                                                  : known.term.prior_sigma * known.term.prior_sigma;
      starts[0].state.push_back({group, variance});
    }
    // A block of many amplitudes comes before the plain name that it resembles, as names stand on a grid until they are
    // refined: the plain names are followed by themselves, too.
    objective::Start plain;
    plain.without = {static_cast<int>(Family::kCurve), static_cast<int>(Family::kCrossed)};
    for (const objective::Member& member : starts[0].state) {
      const int family = scorer.group(member.group).family;
      if (std::find(plain.without.begin(), plain.without.end(), family) == plain.without.end())
        plain.state.push_back(member);
    }
    starts.push_back(std::move(plain));
    const objective::Found found = searcher.Search(starts);
    if (is_first) Rank(scorer, design, catalogue, report);
    const auto counted = std::count_if(found.state.begin(), found.state.end(), [&](const objective::Member& member) {
      return scorer.group(member.group).is_counted;
    });
    report->has_stopped_early = counted >= policy_.most_effects;
    Take(scorer, found, searcher.ClassesOf(found, kLinear), linearised, catalogue, next);
  }

  // What the declared model lacks at first sight.
  static void Rank(objective::Scorer& scorer, const objective::DesignEffect& design,
                   const effects::Catalogue& catalogue, loop::Report* report) {
    report->candidates = scorer.group_count();
    report->evidence = scorer.policy().evidence;
    report->not_visible = NotVisible(scorer, catalogue.effects);
    constexpr int kRanked = 20;
    const double all = design.Of(scorer.ResidualOf({}, 1.0)), base = scorer.ScoreOf({}, all).objective;
    for (const objective::Move& move : scorer.Additions({}, all, {}, kRanked)) {
      const Effect& effect = catalogue.effects[scorer.OriginOf(move.member.group)];
      if (effect.bad_row < 0)
        report->ranking.push_back({effect.candidate, base + scorer.policy().evidence - move.objective});
    }
  }

  void Take(objective::Scorer& scorer, const objective::Found& found,
            const std::vector<std::vector<objective::Move>>& classes, const effects::Linearised& linearised,
            const effects::Catalogue& catalogue, Extension* next) const {
    const objective::Score score = scorer.ScoreOf(found.state, found.design);
    const std::vector<Eigen::VectorXd> variances = scorer.VariancesOf(found.state, found.design);
    const double all = scorer.ScoreOf({}, found.design).squares;
    objective::State before;
    for (size_t i = 0; i < found.state.size(); ++i) {
      const int group = found.state[i].group;
      const Effect& effect = catalogue.effects[scorer.OriginOf(group)];
      before.push_back(found.state[i]);
      if (effect.bad_row >= 0) {
        const int run = linearised.run[effect.bad_row];
        const int rows = linearised.problem->runs[run].row_count;
        next->bad_rows.push_back(
            {run, static_cast<size_t>(linearised.reading[effect.bad_row]) * rows + linearised.channel[effect.bad_row]});
        continue;
      }
      objective::State without = found.state;
      without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
      Added added;
      added.candidate = effect.candidate;
      added.score = scorer.ScoreOf(without, found.design).objective - found.objective + policy_.evidence;
      added.left = std::sqrt(scorer.ScoreOf(before, found.design).squares / all);
      if (effect.candidate.family == Family::kStep && !HasRoomForSlip(*next, effect.candidate.run)) continue;
      if (effect.candidate.family == Family::kInstrument) {
        added.candidate.distortion.variance_mm2 = found.state[i].variance;
        if (added.candidate.distortion.tau_s > 0.0)
          added.candidate.distortion.tau_s = std::exp(scorer.group(group).place);
        TakeAmplitudes(score.amplitude[i], variances[i], linearised, &added.candidate.distortion);
        if (!HasRoom(*next, added.candidate.distortion)) continue;
      } else if (effect.candidate.family != Family::kStep) {
        added.candidate.term.shape = effects::AsIn(scorer.group(group), added.candidate.term.shape);
        for (Eigen::Index b = 0; b < score.amplitude[i].size(); ++b)
          added.candidate.term.amplitude[b] = score.amplitude[i][b];
        if (shapes::IsFree(added.candidate.term.shape))
          added.candidate.term.prior_sigma = std::sqrt(found.state[i].variance);
      }
      TakeClass(scorer, classes[i], catalogue, &added);
      next->effects.push_back(std::move(added));
    }
  }

  // What all sessions of the instrument have in common. Each may deviate by as much as lets their mean deviate as the
  // readings allow, twice its variance, as the readings are used again.
  static void TakeAmplitudes(const Eigen::VectorXd& amplitude, const Eigen::VectorXd& variance,
                             const effects::Linearised& linearised, instruments::Distortion* distortion) {
    double sessions = 0.0;
    for (const MeasuringRun& run : linearised.problem->runs) sessions += instruments::CanHave(run, *distortion);
    distortion->amplitude_mm.assign(amplitude.begin(), amplitude.end());
    distortion->sigma_mm.clear();
    constexpr double kLeastMm = 1e-7;  // far below any reading
    for (const double one : variance)
      distortion->sigma_mm.push_back(std::max(kLeastMm, std::sqrt(2.0 * sessions * one)));
  }

  // Whether a session's set-up holds one more fault.
  bool HasRoom(const Extension& extension, const instruments::Distortion& distortion) const {
    const std::vector<MeasuringRun> runs = extension.Runs();
    return std::all_of(runs.begin(), runs.end(), [&](const MeasuringRun& run) {
      return !instruments::CanHave(run, distortion) ||
             instruments::DistortionAmplitudes(run) + instruments::AmplitudeCount(distortion, run.row_count) <=
                 instruments::kMaxDistortionAmplitudes;
    });
  }

  // Whether a session's set-up holds one more slip; those that were found first stay.
  static bool HasRoomForSlip(const Extension& extension, int run) {
    return std::count_if(extension.effects.begin(), extension.effects.end(), [run](const Added& one) {
             return one.candidate.family == Family::kStep && one.candidate.run == run;
           }) < instruments::kMaxSlips;
  }

  static void TakeClass(const objective::Scorer& scorer, const std::vector<objective::Move>& members,
                        const effects::Catalogue& catalogue, Added* added) {
    Candidate& own = added->candidate;
    if (own.family == Family::kInstrument) return;
    if (own.family == Family::kStep) {
      own.earliest = own.latest = own.first_reading;
      // Where no rotary axis turns table and tool look alike: only one of them is in the catalogue.
      own.may_be_other = std::none_of(catalogue.effects.begin(), catalogue.effects.end(), [&](const Effect& other) {
        return other.bad_row < 0 && other.candidate.family == Family::kStep && other.candidate.run == own.run &&
               other.candidate.carrier != own.carrier;
      });
    }
    for (const objective::Move& move : members) {
      const Effect& effect = catalogue.effects[scorer.OriginOf(move.member.group)];
      Candidate one = effect.candidate;
      if (effect.bad_row >= 0) continue;
      if (own.family == Family::kStep) {
        if (one.family != Family::kStep || one.run != own.run) continue;
        own.may_be_other |= one.carrier != own.carrier;
        own.earliest = std::min(own.earliest, one.first_reading);
        own.latest = std::max(own.latest, one.first_reading);
        continue;
      }
      one.term.shape = effects::AtPlace(one.term.shape, scorer.group(move.member.group).place);
      if (shapes::IsFree(one.term.shape)) {
        // What can take any form explains whatever a name explains: no news about the name.
        if (!shapes::IsFree(own.term.shape)) continue;
        one.term.prior_sigma = std::sqrt(move.member.variance);
      }
      const auto is_it = [&](const Candidate& known) { return loop::IsSameEffect(known.term, one.term); };
      if (IsUnnamed(one.family) || is_it(own) || std::any_of(added->equivalent.begin(), added->equivalent.end(), is_it))
        continue;
      added->equivalent.push_back(one);
    }
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
  objective::Policy policy_;
  const identify::Options identify_options_;
  const machine::ErrorModel declared_;
  loop::Check check_;
  const std::vector<MeasuringRun> all_;  // fit sessions, then check sessions
};

}  // namespace

absl::StatusOr<loop::Report> Decide(const machine::Machine& machine, std::vector<MeasuringRun> fit,
                                    std::vector<MeasuringRun> check, const Options& options) {
  // What a machine remembers of temperatures runs on from the fit sessions into the check sessions.
  instruments::ShareTemperatures({&fit, &check});
  return Decider(machine, std::move(fit), std::move(check), options).Run();
}

}  // namespace axiscal::decide
