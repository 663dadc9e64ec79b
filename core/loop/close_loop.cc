#include "core/loop/close_loop.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/units.h"
#include "core/identify/reduction.h"
#include "core/loop/check.h"
#include "core/loop/dictionary.h"
#include "core/loop/noise.h"
#include "core/loop/refine.h"
#include "core/loop/rivals.h"

namespace axiscal::loop {
namespace {

using identify::Fit;
using instruments::MeasuringRun;
using machine::ErrorModel;
using machine::ErrorTerm;
using machine::Machine;

// One effect in the model so far.
struct Added {
  Candidate candidate;
  double score = 0.0;
  std::vector<Candidate> equivalent, rivals;
};

class Loop {
 public:
  Loop(const Machine& machine, std::vector<MeasuringRun> fit, std::vector<MeasuringRun> check, const Options& options)
      : machine_(machine),
        runs_(std::move(fit)),
        options_(options),
        identify_options_(OptionsOf(options)),
        check_(machine, std::move(check), identify_options_) {
    report_.has_check = !check_.is_empty();
  }

  absl::StatusOr<Report> Run() {
    ASSIGN_OR_RETURN(Report report, Attempt());
    // An effect that swallowed two others leads astray: where the check sessions stay unexplained, another beginning
    // is tried, and taken if it explains them better without explaining the fit sessions worse.
    constexpr int kBeginnings = 3;
    for (int round = 1; round < kBeginnings && !is_check_explained_ && first_.has_value(); ++round) {
      // What was alike leads to the same end.
      not_first_.push_back(first_->candidate);
      not_first_.insert(not_first_.end(), first_->equivalent.begin(), first_->equivalent.end());
      ASSIGN_OR_RETURN(Report other, Attempt());
      constexpr double kBetter = 0.98, kNoWorse = 1.02;
      if (other.check_after.rms_mm < kBetter * report.check_after.rms_mm &&
          other.fit_after.rms_mm < kNoWorse * report.fit_after.rms_mm)
        report = std::move(other);
    }
    return report;
  }

 private:
  static identify::Options OptionsOf(const Options& options) {
    identify::Options out;
    out.cancelled = options.cancelled;
    out.scale_uncertainties = true;
    return out;
  }

  absl::StatusOr<Report> Attempt() {
    added_.clear();
    first_.reset();
    refused_.clear();
    report_ = Report();
    report_.has_check = !check_.is_empty();
    Say("fitting the declared model", 0.0, "");
    ASSIGN_OR_RETURN(Fit fit, FitModel());
    report_.fit_before = fit.result.fit;
    KeepResiduals(fit, runs_, &SessionResiduals::before_mm);
    ASSIGN_OR_RETURN(report_.check_before, CheckStatistics(fit.result.model, &SessionResiduals::before_mm));
    RETURN_IF_ERROR(Extend(&fit));
    ASSIGN_OR_RETURN(const bool has_replaced, Validate(&fit));
    if (has_replaced) {
      // What had no name beside the wrong member of a class may have one beside the right one, or not be there at all.
      std::erase_if(added_, [](const Added& one) { return IsUnnamed(one.candidate.family); });
      ASSIGN_OR_RETURN(fit, FitModel());
      RETURN_IF_ERROR(Extend(&fit));
      RETURN_IF_ERROR(Validate(&fit).status());
    }
    Describe(fit);
    KeepResiduals(fit, runs_, &SessionResiduals::after_mm);
    ASSIGN_OR_RETURN(report_.check_after, CheckStatistics(fit.result.model, &SessionResiduals::after_mm));
    is_check_explained_ = true;
    if (first_.has_value() && !check_.is_empty()) {
      RETURN_IF_ERROR(check_.Settle(fit));
      ASSIGN_OR_RETURN(const double squares, check_.Squares(fit.result.model));
      is_check_explained_ = check_.IsAdequate(squares);
    }
    return std::move(report_);
  }

  absl::Status Extend(Fit* fit) {
    // What is dropped may be found again: as many steps as twice the effects end that.
    for (int step = 0; step < 2 * options_.max_effects; ++step) {
      if (static_cast<int>(added_.size()) >= options_.max_effects) break;
      ASSIGN_OR_RETURN(const bool has_found, Forward(fit));
      if (!has_found) break;
      RETURN_IF_ERROR(Swap(fit));
      RETURN_IF_ERROR(Backward(fit));
    }
    return absl::OkStatus();
  }

  void Say(const std::string& stage, double fraction, const std::string& detail) {
    if (options_.progress) options_.progress({stage, fraction, detail});
  }

  void Note(Step::Change change, const std::string& name, const Fit& fit) {
    report_.steps.push_back({change, name, fit.result.fit.rms_mm});
  }

  ErrorModel ModelWith(const std::vector<Added>& added) const {
    ErrorModel model = machine::DeclaredModel(machine_);
    for (const Added& one : added) {
      if (one.candidate.family != Family::kStep) model.terms.push_back(one.candidate.term);
    }
    return model;
  }

  // A slipped artefact: from that reading on the session is another session with a setup of its own.
  static std::vector<MeasuringRun> Split(const std::vector<MeasuringRun>& runs, const std::vector<Added>& added) {
    std::vector<MeasuringRun> out;
    for (size_t i = 0; i < runs.size(); ++i) {
      std::vector<int> cuts = {0};
      for (const Added& one : added) {
        if (one.candidate.family == Family::kStep && one.candidate.run == static_cast<int>(i))
          cuts.push_back(one.candidate.first_reading);
      }
      std::sort(cuts.begin(), cuts.end());
      cuts.push_back(runs[i].reading_count());
      for (size_t c = 0; c + 1 < cuts.size(); ++c) {
        if (cuts.size() == 2) {
          out.push_back(runs[i]);
        } else {
          out.push_back(Part(runs[i], cuts[c], cuts[c + 1], absl::StrCat(runs[i].session, "#", c + 1)));
        }
      }
    }
    return out;
  }

  static MeasuringRun Part(const MeasuringRun& run, int begin, int end, const std::string& name) {
    MeasuringRun part = run;
    part.session = part.setup_name = name;
    const size_t axes = run.axis_count;
    part.positions.assign(run.positions.begin() + begin * axes, run.positions.begin() + end * axes);
    part.axis_states.assign(run.axis_states.begin() + begin * axes, run.axis_states.begin() + end * axes);
    part.time_s.assign(run.time_s.begin() + begin, run.time_s.begin() + end);
    part.temperature_celsius.assign(run.temperature_celsius.begin() + begin, run.temperature_celsius.begin() + end);
    part.measured_mm = run.measured_mm.middleCols(begin, end - begin);
    return part;
  }

  // Fits the model so far; then judges the noise from what is left and fits again until the two agree.
  absl::StatusOr<Fit> FitModel() { return FitWith(added_); }

  absl::StatusOr<Fit> FitWith(const std::vector<Added>& added) {
    identify::Options options = identify_options_;
    options.model = ModelWith(added);
    std::vector<MeasuringRun> runs = Split(runs_, added);
    ASSIGN_OR_RETURN(Fit fit, identify::FitRuns(machine_, std::move(runs), options));
    constexpr int kRounds = 2;
    for (int round = 0; round < kRounds; ++round) {
      identify::Problem problem = std::move(fit.problem);
      problem.noise = EstimateNoise(problem, fit.residuals_mm);
      options.model = fit.result.model;
      ASSIGN_OR_RETURN(fit, identify::FitProblem(std::move(problem), *options.model, options));
    }
    return fit;
  }

  // Another model on the same readings, with the noise and the bad readings of `fit`: to compare the two.
  absl::StatusOr<Fit> Refit(const Fit& fit, const ErrorModel& model) const {
    identify::Options options = identify_options_;
    options.set_outliers_aside = false;
    return identify::FitProblem(fit.problem, model, options);
  }

  static double SquaresOf(const Fit& fit) {
    return identify::WhitenedSquares(fit.problem, fit.residuals_mm) + identify::PriorSquares(fit.problem, fit.point);
  }

  using ResidualField = Eigen::MatrixXd SessionResiduals::*;

  // Parts of a session whose artefact slipped join again.
  void KeepResiduals(const Fit& fit, const std::vector<MeasuringRun>& runs, ResidualField field) {
    const bool is_check = &runs == &check_.runs();
    const size_t offset = is_check ? runs_.size() : 0;
    report_.residuals.resize(runs_.size() + check_.runs().size());
    size_t part = 0;
    for (size_t i = 0; i < runs.size(); ++i) {
      SessionResiduals& kept = report_.residuals[offset + i];
      kept.session = runs[i].session;
      kept.is_check = is_check;
      Eigen::MatrixXd& residuals_mm = kept.*field;
      residuals_mm.resize(runs[i].row_count, runs[i].reading_count());
      for (Eigen::Index at = 0; at < residuals_mm.cols(); ++part) {
        const Eigen::MatrixXd& columns = fit.residuals_mm[part];
        residuals_mm.middleCols(at, columns.cols()) = columns;
        at += columns.cols();
      }
    }
  }

  absl::StatusOr<identify::FitStatistics> CheckStatistics(const ErrorModel& model, ResidualField field) {
    if (check_.is_empty()) return identify::FitStatistics{};
    ASSIGN_OR_RETURN(const Fit check, check_.Under(model));
    KeepResiduals(check, check_.runs(), field);
    return check.result.fit;
  }

  absl::StatusOr<bool> Forward(Fit* fit) {
    const Signatures signatures(fit->problem, fit->point, identify::ListParameters(fit->point.model, true));
    std::vector<Candidate> candidates = MakeDictionary(fit->problem, fit->point.model);
    if (added_.empty() && !not_first_.empty()) {
      std::erase_if(candidates, [this](const Candidate& one) {
        return IsUnnamed(one.family) || std::any_of(not_first_.begin(), not_first_.end(), [&](const Candidate& other) {
                 return IsSameEffect(one.term, other.term);
               });
      });
    }
    std::erase_if(candidates, [this](const Candidate& one) {
      return std::any_of(refused_.begin(), refused_.end(), [&](const Candidate& other) {
        return one.family == other.family && one.run == other.run && one.first_reading == other.first_reading &&
               one.term.joint == other.term.joint && one.term.component == other.term.component &&
               one.term.shape == other.term.shape;
      });
    });
    const SearchResult found = Search(machine_, signatures, candidates, options_.search);
    if (report_.ranking.empty()) {
      report_.ranking = found.ranking;
      report_.candidates = found.candidate_count;
    }
    if (!found.is_significant) return false;
    ASSIGN_OR_RETURN(const Finding finding, Decide(*fit, found.finding));
    Added added;
    added.candidate = finding.effect.candidate;
    for (int b = 0; b < shapes::kMaxBasisCount; ++b) added.candidate.term.amplitude[b] = finding.effect.amplitude[b];
    added.score = finding.effect.score;
    SetClass(finding, &added);
    if (added.candidate.family == Family::kStep) {
      added.candidate = Refined(signatures, added.candidate, 0.0);
      MapStep(fit->problem, &added.candidate);
    }
    added_.push_back(added);
    ASSIGN_OR_RETURN(Fit extended, FitModel());
    // What is all but explained already may promise much and fit nothing: its amplitude runs away.
    constexpr double kNoWorse = 1.05;  // which readings are set aside changes too
    if (!(extended.result.fit.rms_without_outliers_mm < kNoWorse * fit->result.fit.rms_without_outliers_mm)) {
      Note(Step::kRefused, NameOf(added_.back()), extended);
      added_.pop_back();
      refused_.push_back(added.candidate);
      return true;
    }
    *fit = std::move(extended);
    if (!first_.has_value()) first_ = added;
    Note(Step::kAdded, NameOf(added_.back()), *fit);
    Say("closing the loop", static_cast<double>(added_.size()) / options_.max_effects,
        absl::StrFormat("%d candidates, added %s, rms %.3f um", found.candidate_count, NameOf(added_.back()),
                        fit->result.fit.rms_mm * base::kUmPerMm));
    return true;
  }

  // The class without the effect itself, each effect once, unnamed structure left out.
  static void SetClass(const Finding& finding, Added* added) {
    const auto fill = [&](const std::vector<Scored>& from, std::vector<Candidate>* to) {
      for (const Scored& other : from) {
        const auto is_listed = [&](const Candidate& one) { return IsSameEffect(one.term, other.candidate.term); };
        if (IsUnnamed(other.candidate.family) || is_listed(added->candidate) ||
            std::any_of(added->equivalent.begin(), added->equivalent.end(), is_listed) ||
            std::any_of(to->begin(), to->end(), is_listed))
          continue;
        to->push_back(other.candidate);
      }
    };
    added->equivalent.clear();
    added->rivals.clear();
    fill(finding.equivalent, &added->equivalent);
    fill(finding.rivals, &added->rivals);
  }

  // Where members of the class are equally simple, the full refit says which fits best: large amplitudes along what
  // setups nearly explain leave the linear estimate behind.
  absl::StatusOr<Finding> Decide(const Fit& fit, Finding finding) const {
    if (finding.effect.candidate.family == Family::kStep) return finding;
    constexpr size_t kContenders = 5;
    const int complexity = Complexity(machine_, finding.effect.candidate);
    size_t contenders = 0;
    while (contenders < std::min(kContenders, finding.equivalent.size()) &&
           Complexity(machine_, finding.equivalent[contenders].candidate) == complexity)
      ++contenders;
    if (contenders == 0) return finding;
    double least = INFINITY;
    size_t best = 0;  // 0: the effect itself, k: equivalent[k - 1]
    for (size_t k = 0; k <= contenders; ++k) {
      const Scored& one = k == 0 ? finding.effect : finding.equivalent[k - 1];
      ErrorModel model = fit.result.model;
      model.terms.push_back(one.candidate.term);
      const absl::StatusOr<Fit> refit = Refit(fit, model);
      if (absl::IsCancelled(refit.status())) return refit.status();
      if (!refit.ok()) continue;
      const double squares = SquaresOf(*refit);
      if (squares >= least) continue;
      least = squares;
      best = k;
    }
    if (best > 0) std::swap(finding.effect, finding.equivalent[best - 1]);
    return finding;
  }

  // The search saw runs that may be parts of a session already: back to the session's own readings.
  void MapStep(const identify::Problem& problem, Candidate* candidate) const {
    const MeasuringRun& part = problem.runs[candidate->run];
    for (size_t i = 0; i < runs_.size(); ++i) {
      const bool is_whole = runs_[i].session == part.session;
      const bool is_part = part.session.rfind(runs_[i].session + "#", 0) == 0;
      if (!is_whole && !is_part) continue;
      int before = 0;
      while (runs_[i].time_s[before] < part.time_s.front()) ++before;
      candidate->run = static_cast<int>(i);
      candidate->first_reading += before;
      return;
    }
  }

  std::string NameOf(const Added& added) const {
    if (added.candidate.family != Family::kStep) return machine::NameOf(machine_, added.candidate.term);
    return absl::StrCat("a slip in session ", runs_[added.candidate.run].session);
  }

  // Among effects that were alike when one of them was added, the others that have been found since may tell: the
  // member that fits clearly better takes the place, and the class is what is alike now.
  absl::Status Swap(Fit* fit) {
    for (size_t i = 0; i < added_.size(); ++i) {
      if (added_[i].candidate.family == Family::kStep || added_[i].equivalent.size() + added_[i].rivals.size() == 0)
        continue;
      ErrorModel lacking = fit->result.model;
      const int term = TermOf(i);
      lacking.terms.erase(lacking.terms.begin() + term);
      const absl::StatusOr<Fit> reduced = Refit(*fit, lacking);
      if (absl::IsCancelled(reduced.status())) return reduced.status();
      if (!reduced.ok()) continue;
      const Signatures signatures(reduced->problem, reduced->point,
                                  identify::ListParameters(reduced->point.model, true));
      std::vector<Candidate> members = {added_[i].candidate};
      members[0].term = fit->result.model.terms[term];  // its decay length or frequency as refitted
      members.insert(members.end(), added_[i].equivalent.begin(), added_[i].equivalent.end());
      members.insert(members.end(), added_[i].rivals.begin(), added_[i].rivals.end());
      std::vector<Scored> scored;
      const std::vector<Projection> projections = signatures.Project(members);
      for (size_t k = 0; k < members.size(); ++k) {
        Scored one;
        one.candidate = members[k];
        if (projections[k].visible > kVisible) {
          const double gain = Gain(projections[k], &one.amplitude);
          one.likelihood_ratio = LikelihoodRatio(signatures.residual_squares(), gain, signatures.degrees_of_freedom());
          one.score = one.likelihood_ratio - options_.search.per_column * (projections[k].columns - 1);
        }
        scored.push_back(one);
      }
      const double own = scored[0].likelihood_ratio;
      std::stable_sort(scored.begin(), scored.end(),
                       [](const Scored& a, const Scored& b) { return a.likelihood_ratio > b.likelihood_ratio; });
      Finding finding = ClassOf(machine_, signatures, scored, options_.search);
      Added changed = added_[i];
      bool is_swapped = false;
      if (finding.effect.likelihood_ratio > own + options_.search.indistinguishable) {
        ErrorModel other = fit->result.model;
        other.terms[term] = finding.effect.candidate.term;
        const absl::StatusOr<Fit> swapped = Refit(*fit, other);
        if (absl::IsCancelled(swapped.status())) return swapped.status();
        is_swapped = swapped.ok() && SquaresOf(*swapped) < SquaresOf(*fit) - options_.search.indistinguishable;
      }
      if (is_swapped) changed.candidate = finding.effect.candidate;
      finding.equivalent.insert(finding.equivalent.begin(), finding.effect);
      SetClass(finding, &changed);
      added_[i] = std::move(changed);
      if (!is_swapped) continue;
      ASSIGN_OR_RETURN(*fit, FitModel());
      Note(Step::kReplaced, NameOf(added_[i]), *fit);
    }
    return absl::OkStatus();
  }

  // Drops effects that the refitted model no longer needs.
  absl::Status Backward(Fit* fit) {
    while (added_.size() > 1) {
      int weakest = -1;
      double least = options_.search.evidence;
      for (size_t i = 0; i + 1 < added_.size(); ++i) {
        if (added_[i].candidate.family == Family::kStep) continue;
        const double evidence = EvidenceOf(*fit, i);
        if (evidence < least) {
          least = evidence;
          weakest = static_cast<int>(i);
        }
      }
      if (weakest < 0) return absl::OkStatus();
      const std::string name = NameOf(added_[weakest]);
      added_.erase(added_.begin() + weakest);
      ASSIGN_OR_RETURN(*fit, FitModel());
      Note(Step::kDropped, name, *fit);
    }
    return absl::OkStatus();
  }

  // Which term of the extended model an effect is (ModelWith's order).
  int TermOf(size_t effect) const {
    int term = static_cast<int>(machine::DeclaredModel(machine_).terms.size());
    for (size_t i = 0; i < effect; ++i) term += added_[i].candidate.family != Family::kStep;
    return term;
  }

  // Likelihood ratio of an effect that is in the model: how much chi-square its removal would cost (Wald).
  double EvidenceOf(const Fit& fit, size_t effect) const {
    const std::vector<identify::Parameter> parameters = identify::ListParameters(fit.point.model, true);
    const int term = TermOf(effect);
    double squares = 0.0;
    for (size_t i = 0; i < parameters.size(); ++i) {
      if (parameters[i].term != term || parameters[i].is_nonlinear) continue;
      const identify::Estimate& estimate = fit.result.estimates[i];
      if (estimate.identifiable && estimate.sigma > 0.0)
        squares += estimate.value * estimate.value / (estimate.sigma * estimate.sigma);
    }
    return squares;
  }

  // Withdraws what does not help on sessions that were not used; true where another member of a class took the place of
  // one.
  absl::StatusOr<bool> Validate(Fit* fit) {
    bool has_replaced = false;
    if (check_.is_empty() || added_.empty()) return has_replaced;
    RETURN_IF_ERROR(check_.Settle(*fit));
    for (size_t i = added_.size(); i-- > 0;) {
      if (IsUnnamed(added_[i].candidate.family)) continue;
      std::vector<Added> without = added_;
      without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
      ErrorModel lacking = fit->result.model;
      lacking.terms.erase(lacking.terms.begin() + TermOf(i));
      ASSIGN_OR_RETURN(const Fit reduced, Refit(*fit, lacking));
      ASSIGN_OR_RETURN(const double squares_without, check_.Squares(reduced.result.model));
      ASSIGN_OR_RETURN(const double squares_with, check_.Squares(fit->result.model));
      constexpr double kSpeaksAgainst = 9.0;  // chi-square units
      const bool speaks_against = squares_with > squares_without + kSpeaksAgainst || !std::isfinite(squares_with);
      if (!speaks_against && check_.IsAdequate(squares_with)) continue;
      // Of effects that the fit sessions could not tell apart another may be the one.
      ASSIGN_OR_RETURN(const bool is_replaced,
                       Replace(i, std::min(squares_without, squares_with - kSpeaksAgainst), fit));
      if (!is_replaced && !speaks_against) continue;
      if (!is_replaced) {
        report_.withdrawn.push_back(NameOf(added_[i]));
        added_ = std::move(without);
      }
      has_replaced = has_replaced || is_replaced;
      ASSIGN_OR_RETURN(*fit, FitModel());
      Note(is_replaced ? Step::kReplaced : Step::kWithdrawn, is_replaced ? NameOf(added_[i]) : report_.withdrawn.back(),
           *fit);
      RETURN_IF_ERROR(check_.Settle(*fit));
    }
    return has_replaced;
  }

  // Puts the member of effect i's class in its place that the check sessions speak for most; false when none leaves
  // less than `least` of their squares.
  absl::StatusOr<bool> Replace(size_t i, double least, Fit* fit) {
    constexpr size_t kTried = 40;
    std::vector<Candidate> members = added_[i].equivalent;
    members.insert(members.end(), added_[i].rivals.begin(), added_[i].rivals.end());
    members.resize(std::min(kTried, members.size()));
    std::vector<Added> best;
    for (const Candidate& member : members) {
      ErrorModel model = fit->result.model;
      model.terms[TermOf(i)] = member.term;
      const absl::StatusOr<Fit> replaced = Refit(*fit, model);
      if (absl::IsCancelled(replaced.status())) return replaced.status();
      if (!replaced.ok()) continue;  // a member that does not fit is no alternative
      ASSIGN_OR_RETURN(const double squares, check_.Squares(replaced->result.model));
      if (squares >= least) continue;
      least = squares;
      best = added_;
      best[i].candidate = member;
      const auto is_it = [&](const Candidate& one) { return IsSameEffect(one.term, member.term); };
      std::erase_if(best[i].equivalent, is_it);
      std::erase_if(best[i].rivals, is_it);
      best[i].equivalent.push_back(added_[i].candidate);
    }
    if (best.empty()) return false;
    added_ = std::move(best);
    return true;
  }

  void Describe(const Fit& fit) {
    const Signatures signatures(fit.problem, fit.point, {});
    const std::vector<identify::Parameter> parameters = identify::ListParameters(fit.point.model, true);
    for (size_t a = 0; a < added_.size(); ++a) {
      const Added& added = added_[a];
      if (added.candidate.family == Family::kStep) {
        const MeasuringRun& run = runs_[added.candidate.run];
        const int k = added.candidate.first_reading;
        report_.unexplained.push_back({"t", run.time_s[std::max(0, k - 1)], run.time_s[k], run.session, 0.0});
        continue;
      }
      const int t = TermOf(a);
      const ErrorTerm& term = fit.point.model.terms[t];
      Eigen::Vector3d amplitude(term.amplitude[0], term.amplitude[1], 0.0);
      Candidate fitted = added.candidate;
      fitted.term = term;
      const double rms_mm = signatures.RmsOf(fitted, amplitude);
      if (const auto* bump = std::get_if<shapes::Bump>(&term.shape)) {
        AddRange({machine_.axes[bump->axis].name, bump->at - bump->width, bump->at + bump->width,
                  SessionWhereItShows(fit, *bump), rms_mm});
        continue;
      }
      Effect effect;
      effect.term = term;
      effect.rms_mm = rms_mm;
      effect.evidence = added.score;
      for (const Candidate& other : added.equivalent) effect.equivalent.push_back(other.term);
      double variance = 0.0;
      effect.amplitude = shapes::BasisCount(term.shape) == 2 ? amplitude.norm() : term.amplitude[0];
      for (size_t i = 0; i < parameters.size(); ++i) {
        if (parameters[i].term != t || parameters[i].is_nonlinear) continue;
        const double share = shapes::BasisCount(term.shape) == 2 && effect.amplitude > 0.0
                                 ? amplitude[parameters[i].basis] / effect.amplitude
                                 : 1.0;
        const double sigma = fit.result.estimates[i].sigma;
        if (std::isfinite(sigma)) variance += share * share * sigma * sigma;
      }
      effect.amplitude_sigma = std::sqrt(variance);
      report_.effects.push_back(std::move(effect));
    }
    report_.verdict = !report_.unexplained.empty() ? Verdict::kUnexplained
                      : !report_.effects.empty()   ? Verdict::kExtended
                                                   : Verdict::kAdequate;
    Proposer proposer(fit.problem, fit.point);
    for (Effect& effect : report_.effects) {
      effect.equivalent = StillEquivalent(fit.problem, fit.point, effect.term, effect.equivalent,
                                          options_.search.same_class_correlation, options_.search.indistinguishable);
      const std::vector<Proposal> proposals = proposer.Propose(effect.term, effect.equivalent);
      report_.next_measurement.insert(report_.next_measurement.end(), proposals.begin(), proposals.end());
    }
    for (size_t i = 0; i < fit.problem.runs.size(); ++i) {
      const identify::Noise& noise = fit.problem.noise[i];
      report_.noise.push_back({fit.problem.runs[i].session, fit.problem.runs[i].sigma_mm, noise.sigma_mm, noise.ar1});
    }
    report_.fitted = fit.result;
    report_.fit_after = fit.result.fit;
  }

  // Ranges of one axis that overlap are one structure, its place that of the strongest part.
  void AddRange(const Unexplained& range) {
    for (Unexplained& known : report_.unexplained) {
      if (known.variable != range.variable || known.from > range.to || range.from > known.to) continue;
      if (range.rms_mm > known.rms_mm) known = range;
      return;
    }
    report_.unexplained.push_back(range);
  }

  std::string SessionWhereItShows(const Fit& fit, const shapes::Bump& bump) const {
    std::string session;
    int most = 0;
    for (const MeasuringRun& run : fit.problem.runs) {
      int count = 0;
      for (int k = 0; k < run.reading_count(); ++k)
        count += std::abs(run.PositionsOf(k)[bump.axis] - bump.at) < bump.width;
      if (count > most) {
        most = count;
        session = run.session;
      }
    }
    return session;
  }

  const Machine& machine_;
  const std::vector<MeasuringRun> runs_;
  const Options options_;
  const identify::Options identify_options_;
  Check check_;
  std::vector<Added> added_;
  std::optional<Added> first_;        // of this attempt
  std::vector<Candidate> refused_;    // that did not fit, of this attempt
  std::vector<Candidate> not_first_;  // beginnings of attempts that left the check sessions unexplained
  bool is_check_explained_ = true;
  Report report_;
};

}  // namespace

absl::StatusOr<Report> CloseLoop(const Machine& machine, std::vector<MeasuringRun> fit, std::vector<MeasuringRun> check,
                                 const Options& options) {
  return Loop(machine, std::move(fit), std::move(check), options).Run();
}

}  // namespace axiscal::loop
