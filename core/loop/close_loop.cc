#include "core/loop/close_loop.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/identify/reduction.h"
#include "core/loop/dictionary.h"
#include "core/loop/noise.h"
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
  std::vector<ErrorTerm> equivalent;
};

class Loop {
 public:
  Loop(const Machine& machine, std::vector<MeasuringRun> fit, std::vector<MeasuringRun> check, const Options& options)
      : machine_(machine), runs_(std::move(fit)), check_runs_(std::move(check)), options_(options) {
    identify_options_.cancelled = options.cancelled;
    identify_options_.scale_uncertainties = true;
  }

  absl::StatusOr<Report> Run() {
    Say("fitting the declared model", 0.0, "");
    ASSIGN_OR_RETURN(Fit fit, FitModel());
    report_.fit_before = fit.result.fit;
    KeepResiduals(fit, runs_, &SessionResiduals::before_mm);
    ASSIGN_OR_RETURN(report_.check_before, CheckStatistics(fit.result.model, &SessionResiduals::before_mm));
    for (int step = 0; step < options_.max_effects; ++step) {
      ASSIGN_OR_RETURN(const bool has_found, Forward(&fit));
      if (!has_found) break;
      RETURN_IF_ERROR(Backward(&fit));
    }
    RETURN_IF_ERROR(Validate(&fit));
    Describe(fit);
    KeepResiduals(fit, runs_, &SessionResiduals::after_mm);
    ASSIGN_OR_RETURN(report_.check_after, CheckStatistics(fit.result.model, &SessionResiduals::after_mm));
    return std::move(report_);
  }

 private:
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

  using ResidualField = Eigen::MatrixXd SessionResiduals::*;

  // Parts of a session whose artefact slipped join again.
  void KeepResiduals(const Fit& fit, const std::vector<MeasuringRun>& runs, ResidualField field) {
    const bool is_check = &runs == &check_runs_;
    const size_t offset = is_check ? runs_.size() : 0;
    report_.residuals.resize(runs_.size() + check_runs_.size());
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
    report_.has_check = !check_runs_.empty();
    if (check_runs_.empty()) return identify::FitStatistics{};
    ASSIGN_OR_RETURN(const Fit check, identify::CheckRuns(machine_, check_runs_, model, identify_options_));
    KeepResiduals(check, check_runs_, field);
    return check.result.fit;
  }

  absl::StatusOr<bool> Forward(Fit* fit) {
    const Signatures signatures(fit->problem, fit->point, identify::ListParameters(fit->point.model, true));
    const std::vector<Candidate> candidates = MakeDictionary(fit->problem, fit->point.model);
    const SearchResult found = Search(machine_, signatures, candidates, options_.search);
    if (report_.ranking.empty()) {
      report_.ranking = found.ranking;
      report_.candidates = found.candidate_count;
    }
    if (!found.is_significant) return false;
    Added added;
    added.candidate = found.finding.effect.candidate;
    for (int b = 0; b < shapes::kMaxBasisCount; ++b)
      added.candidate.term.amplitude[b] = found.finding.effect.amplitude[b];
    added.score = found.finding.effect.score;
    for (const Scored& other : found.finding.equivalent) {
      if (!IsUnnamed(other.candidate.family)) added.equivalent.push_back(other.candidate.term);
    }
    if (added.candidate.family == Family::kStep) {
      RefineStep(signatures, fit->problem, &added.candidate);
      MapStep(fit->problem, &added.candidate);
    }
    if (added.candidate.family == Family::kBump) RefineBump(signatures, &added.candidate);
    added_.push_back(added);
    ASSIGN_OR_RETURN(*fit, FitModel());
    Note(Step::kAdded, NameOf(added_.back()), *fit);
    Say("closing the loop", static_cast<double>(added_.size()) / options_.max_effects,
        absl::StrFormat("%d candidates, added %s, rms %.3f um", found.candidate_count, NameOf(added_.back()),
                        fit->result.fit.rms_mm * base::kUmPerMm));
    return true;
  }

  // Place and width between the dictionary's: a grid around the best that shrinks.
  static void RefineBump(const Signatures& signatures, Candidate* candidate) {
    double spread = 0.5;
    for (int round = 0; round < 6; ++round) {
      const shapes::Bump best = std::get<shapes::Bump>(candidate->term.shape);
      std::vector<Candidate> around;
      for (int i = -2; i <= 2; ++i) {
        for (int j = -2; j <= 2; ++j) {
          Candidate moved = *candidate;
          moved.term.shape = shapes::Bump{best.axis, best.at + 0.5 * i * spread * best.width,
                                          best.width * std::pow(1.0 + spread, 0.5 * j)};
          around.push_back(moved);
        }
      }
      *candidate = BestOf(signatures, around);
      spread *= 0.6;
    }
  }

  // The moment to the reading: every one between the dictionary's neighbours.
  static void RefineStep(const Signatures& signatures, const identify::Problem& problem, Candidate* candidate) {
    const int stride = StepStride(problem.runs[candidate->run]);
    const int last = problem.runs[candidate->run].reading_count() - 1;
    std::vector<Candidate> around;
    for (int k = std::max(1, candidate->first_reading - stride); k <= std::min(last, candidate->first_reading + stride);
         ++k) {
      around.push_back(*candidate);
      around.back().first_reading = k;
    }
    *candidate = BestOf(signatures, around);
  }

  static Candidate BestOf(const Signatures& signatures, const std::vector<Candidate>& candidates) {
    const std::vector<Projection> projections = signatures.Project(candidates);
    double largest = -1.0;
    Candidate best = candidates.front();
    for (size_t i = 0; i < candidates.size(); ++i) {
      Eigen::Vector3d amplitude;
      const double gain = Gain(projections[i], &amplitude);
      if (gain <= largest) continue;
      largest = gain;
      best = candidates[i];
      for (int b = 0; b < shapes::kMaxBasisCount; ++b) best.term.amplitude[b] = amplitude[b];
    }
    return best;
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

  // Drops effects that the refitted model no longer needs.
  absl::Status Backward(Fit* fit) {
    while (added_.size() > 1) {
      int weakest = -1;
      double least = options_.search.evidence;
      for (size_t i = 0; i + 1 < added_.size(); ++i) {
        if (added_[i].candidate.family == Family::kStep) continue;
        const double evidence = EvidenceOf(*fit, added_[i]);
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

  // Likelihood ratio of an effect that is in the model: how much chi-square its removal would cost (Wald).
  double EvidenceOf(const Fit& fit, const Added& added) const {
    const std::vector<identify::Parameter> parameters = identify::ListParameters(fit.point.model, true);
    double squares = 0.0;
    for (size_t i = 0; i < parameters.size(); ++i) {
      const ErrorTerm& term = fit.point.model.terms[parameters[i].term];
      if (!IsSame(term, added.candidate.term) || parameters[i].is_nonlinear) continue;
      const identify::Estimate& estimate = fit.result.estimates[i];
      if (estimate.identifiable && estimate.sigma > 0.0)
        squares += estimate.value * estimate.value / (estimate.sigma * estimate.sigma);
    }
    return squares;
  }

  static bool IsSame(const ErrorTerm& a, const ErrorTerm& b) {
    return a.joint == b.joint && a.component == b.component && a.shape.index() == b.shape.index() &&
           (shapes::NonlinearParameter(a.shape) != nullptr || a.shape == b.shape);
  }

  // Withdraws what does not help on sessions that were not used.
  absl::Status Validate(Fit* fit) {
    if (check_runs_.empty()) return absl::OkStatus();
    for (size_t i = added_.size(); i-- > 0;) {
      if (IsUnnamed(added_[i].candidate.family)) continue;
      std::vector<Added> without = added_;
      without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
      ASSIGN_OR_RETURN(Fit reduced, FitWith(without));
      ASSIGN_OR_RETURN(const double worse, CheckAgainst(fit->result.model, reduced.result.model));
      constexpr double kSpeaksAgainst = 9.0;  // chi-square units
      if (worse <= kSpeaksAgainst) continue;
      report_.withdrawn.push_back(NameOf(added_[i]));
      added_ = std::move(without);
      *fit = std::move(reduced);
      Note(Step::kWithdrawn, report_.withdrawn.back(), *fit);
    }
    return absl::OkStatus();
  }

  // Chi-square of the check sessions under `with` less that under `without`; both with the noise and the bad readings
  // that the better of the two leaves, so that neither is judged by a scatter of its own making.
  absl::StatusOr<double> CheckAgainst(const ErrorModel& with, const ErrorModel& without) {
    identify::Options options = identify_options_;
    ASSIGN_OR_RETURN(Fit one, identify::CheckRuns(machine_, check_runs_, with, options));
    ASSIGN_OR_RETURN(Fit other, identify::CheckRuns(machine_, check_runs_, without, options));
    const Fit& better =
        one.result.fit.rms_without_outliers_mm <= other.result.fit.rms_without_outliers_mm ? one : other;
    identify::Problem problem = better.problem;
    problem.noise = EstimateNoise(problem, better.residuals_mm);
    options.set_outliers_aside = false;
    double cost[2];
    for (int k = 0; k < 2; ++k) {
      identify::Problem judged = problem;
      judged.fixed_model = k == 0 ? with : without;
      ASSIGN_OR_RETURN(const Fit fit, identify::FitProblem(std::move(judged), {}, options));
      cost[k] =
          identify::WhitenedSquares(fit.problem, fit.residuals_mm) + identify::PriorSquares(fit.problem, fit.point);
    }
    return cost[0] - cost[1];
  }

  void Describe(const Fit& fit) {
    const Signatures signatures(fit.problem, fit.point, {});
    const std::vector<identify::Parameter> parameters = identify::ListParameters(fit.point.model, true);
    for (const Added& added : added_) {
      if (added.candidate.family == Family::kStep) {
        const MeasuringRun& run = runs_[added.candidate.run];
        const int k = added.candidate.first_reading;
        report_.unexplained.push_back({"t", run.time_s[std::max(0, k - 1)], run.time_s[k], run.session, 0.0});
        continue;
      }
      for (size_t t = 0; t < fit.point.model.terms.size(); ++t) {
        const ErrorTerm& term = fit.point.model.terms[t];
        if (!IsSame(term, added.candidate.term)) continue;
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
        effect.equivalent = added.equivalent;
        double variance = 0.0;
        effect.amplitude = shapes::BasisCount(term.shape) == 2 ? amplitude.norm() : term.amplitude[0];
        for (size_t i = 0; i < parameters.size(); ++i) {
          if (parameters[i].term != static_cast<int>(t) || parameters[i].is_nonlinear) continue;
          const double share = shapes::BasisCount(term.shape) == 2 && effect.amplitude > 0.0
                                   ? amplitude[parameters[i].basis] / effect.amplitude
                                   : 1.0;
          const double sigma = fit.result.estimates[i].sigma;
          if (std::isfinite(sigma)) variance += share * share * sigma * sigma;
        }
        effect.amplitude_sigma = std::sqrt(variance);
        report_.effects.push_back(std::move(effect));
      }
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
  const std::vector<MeasuringRun> runs_, check_runs_;
  const Options options_;
  identify::Options identify_options_;
  std::vector<Added> added_;
  Report report_;
};

}  // namespace

absl::StatusOr<Report> CloseLoop(const Machine& machine, std::vector<MeasuringRun> fit, std::vector<MeasuringRun> check,
                                 const Options& options) {
  return Loop(machine, std::move(fit), std::move(check), options).Run();
}

}  // namespace axiscal::loop
