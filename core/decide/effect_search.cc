#include "core/decide/effect_search.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "core/effects/shaped.h"
#include "core/effects/thinned.h"
#include "core/loop/candidate.h"

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

// The effects of an extension as they were fitted.
std::vector<Candidate> FittedEffects(const Extension& extension, const Fit& fit) {
  std::vector<Candidate> fitted;
  for (size_t i = 0; i < extension.effects.size(); ++i) {
    Candidate one = extension.effects[i].candidate;
    if (loop::IsTerm(one.family)) one.term = fit.point.model.terms[extension.TermOf(i)];
    fitted.push_back(one);
  }
  return fitted;
}

// What the declared model lacks at first sight.
void Rank(objective::Scorer& scorer, const objective::DesignEffect& design, const effects::Catalogue& catalogue,
          loop::Report* report) {
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

// What all sessions of the instrument have in common. Each may deviate by as much as lets their mean deviate as the
// readings allow, twice its variance, as the readings are used again.
void TakeAmplitudes(const Eigen::VectorXd& amplitude, const Eigen::VectorXd& variance,
                    const effects::Linearised& linearised, instruments::Distortion* distortion) {
  double sessions = 0.0;
  for (const MeasuringRun& run : linearised.problem->runs) sessions += instruments::CanHave(run, *distortion);
  distortion->amplitude_mm.assign(amplitude.begin(), amplitude.end());
  distortion->sigma_mm.clear();
  constexpr double kLeastMm = 1e-7;  // far below any reading
  for (const double one : variance) distortion->sigma_mm.push_back(std::max(kLeastMm, std::sqrt(2.0 * sessions * one)));
}

// Whether a session's set-up holds one more fault.
bool HasRoom(const Extension& extension, const instruments::Distortion& distortion) {
  const std::vector<MeasuringRun> runs = extension.Runs();
  return std::all_of(runs.begin(), runs.end(), [&](const MeasuringRun& run) {
    return !instruments::CanHave(run, distortion) ||
           instruments::DistortionAmplitudes(run) + instruments::AmplitudeCount(distortion, run.row_count) <=
               instruments::kMaxDistortionAmplitudes;
  });
}

// Whether a session's set-up holds one more slip; those that were found first stay.
bool HasRoomForSlip(const Extension& extension, int run) {
  return std::count_if(extension.effects.begin(), extension.effects.end(), [run](const Added& one) {
           return one.candidate.family == Family::kStep && one.candidate.run == run;
         }) < instruments::kMaxSlips;
}

void TakeClass(const objective::Scorer& scorer, const std::vector<objective::Move>& members,
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

}  // namespace

Key KeyOf(const machine::Machine& machine, const Candidate& one) {
  if (one.family == Family::kStep) return {"slip", one.run, one.first_reading};
  if (one.family == Family::kInstrument)
    return {absl::StrCat(one.distortion.kind, " ", one.distortion.instrument), static_cast<int>(one.distortion.carrier),
            one.distortion.order};
  machine::ErrorTerm term = one.term;
  // Fitted lengths move a little in every fit.
  if (double* parameter = shapes::NonlinearParameter(term.shape)) *parameter = 1.0;
  return {machine::NameOf(machine, term), term.joint, static_cast<int>(term.component)};
}

void TakeOver(const machine::Machine& machine, const Extension& searched, Extension* extension) {
  for (Added& one : extension->effects) {
    for (const Added& other : searched.effects) {
      if (KeyOf(machine, other.candidate) != KeyOf(machine, one.candidate)) continue;
      const machine::ErrorTerm term = one.candidate.term;
      one = other;
      one.candidate.term = term;
      break;
    }
  }
}

void EffectSearch::Run(const Extension& extension, const Fit& fit, loop::Report* first, Extension* next) {
  identify::Problem problem = fit.problem;
  for (const loop::BadRow& bad : extension.bad_rows) problem.is_used[bad.run][bad.row] = true;
  const effects::Linearised linearised =
      effects::Linearise(problem, fit.point, static_cast<int>(declared_.terms.size()));
  std::vector<Candidate> known = FittedEffects(extension, fit);
  const std::optional<effects::Linearised> thinned = effects::Thinned(linearised, extension.bad_rows);
  if (!thinned) {
    SearchRows(linearised, {}, known, extension.bad_rows, first, next);
    return;
  }
  // Dense series are searched from afar, then for what only the readings themselves tell beside that.
  const auto is_told = [&](const Candidate& one) {
    return !loop::IsTerm(one.family) || thinned->Tells(one.term.shape);
  };
  const auto finer = std::stable_partition(known.begin(), known.end(), is_told);
  Extension rough = *next;
  const Seen seen{&*thinned, SearchRows(*thinned, {}, {known.begin(), finer}, {}, first, &rough)};
  // Sums do not tell at which of their readings something slipped.
  const auto key_of = [this](const Candidate& one) {
    Key key = KeyOf(machine_, one);
    if (one.family == Family::kStep) std::get<2>(key) = 0;
    return key;
  };
  std::multiset<Key> before, after;
  for (const Added& one : extension.effects)
    if (is_told(one.candidate)) before.insert(key_of(one.candidate));
  for (const Added& one : rough.effects) after.insert(key_of(one.candidate));
  if (before != after) {  // fitted first: what is finer comes when these stay
    for (const Added& one : extension.effects)
      if (!is_told(one.candidate)) rough.effects.push_back(one);
    rough.bad_rows = extension.bad_rows;
    *next = std::move(rough);
    return;
  }
  std::vector<Candidate> found;
  for (const Added& one : rough.effects) found.push_back(one.candidate);
  found.insert(found.end(), finer, known.end());
  SearchRows(linearised, seen, found, extension.bad_rows, nullptr, next);
  // Slips and instruments were searched again.
  std::erase_if(rough.effects, [](const Added& one) {
    return one.candidate.family == Family::kStep || one.candidate.family == Family::kInstrument;
  });
  TakeOver(machine_, rough, next);
}

std::map<int, double> EffectSearch::SearchRows(const effects::Linearised& linearised, const Seen& seen,
                                               const std::vector<Candidate>& known,
                                               const std::vector<loop::BadRow>& bad_rows, loop::Report* first,
                                               Extension* next) {
  effects::Catalogue catalogue = effects::MakeCatalogue(linearised, declared_, known, bad_rows, seen.thinned);
  objective::Policy policy = policy_;
  // From several beginnings only where nothing is known yet: neither by thinned rows nor by an earlier round.
  const bool is_first = seen.thinned == nullptr && known.empty();
  if (!is_first) policy.beam = 1;
  objective::Scorer scorer(linearised.rows, std::move(catalogue.sources), policy);
  scorer.AddLooks(seen.looks);
  for (size_t g = 0; g < catalogue.effects.size(); ++g) {
    const Effect& effect = catalogue.effects[g];
    if (effect.bad_row >= 0) continue;
    if (is_left_out_(effect.candidate) || (options_.may_name && !options_.may_name(effect.candidate)))
      scorer.Exclude(static_cast<int>(g));
  }
  const objective::DesignEffect design(scorer);
  objective::Searcher searcher(&scorer, &design, options_.cancelled);
  std::vector<objective::Start> starts(1);
  for (const int group : catalogue.known) {
    const Candidate& one = catalogue.effects[group].candidate;
    const double variance =
        one.family == Family::kInstrument ? one.distortion.variance_mm2 : one.term.prior_sigma * one.term.prior_sigma;
    starts[0].state.push_back({group, variance});
  }
  // A block of many amplitudes comes before the plain name that it resembles, as names stand on a grid until they are
  // refined, and one of two axes before those of one: at first, and where one was found, all others are followed by
  // themselves, too. One for two is a step of the search, two for one are not.
  for (const Family family : {Family::kCurve, Family::kCrossed}) {
    const auto is_of_family = [&](const objective::Member& member) {
      return scorer.group(member.group).family == static_cast<int>(family);
    };
    objective::State others = starts[0].state;
    if (std::erase_if(others, is_of_family) == 0 && !is_first) continue;
    starts.push_back({std::move(others), {static_cast<int>(family)}});
  }
  const objective::Found found = searcher.Search(starts);
  if (first != nullptr) Rank(scorer, design, catalogue, first);
  const auto counted = std::count_if(found.state.begin(), found.state.end(), [&](const objective::Member& member) {
    return scorer.group(member.group).is_counted;
  });
  has_stopped_early_ = counted >= policy_.most_effects;
  design_effect_ = found.design;
  Take(scorer, found, searcher.ClassesOf(found, kLinear), linearised, catalogue, next);
  return scorer.looks();
}

void EffectSearch::Take(objective::Scorer& scorer, const objective::Found& found,
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

}  // namespace axiscal::decide
