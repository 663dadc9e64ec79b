#include "core/effects/linearised.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "core/identify/errors_of_run.h"
#include "core/identify/reduction.h"
#include "core/identify/rows.h"
#include "core/identify/whitening.h"
#include "core/instruments/resolution.h"

namespace axiscal::effects {
namespace {

using instruments::MeasuringRun;

// Set-up offsets of a run that are neither distortions nor slips.
Eigen::Index OwnCount(const MeasuringRun& run) { return instruments::OwnSetupCount(run); }

// Offsets of a group that are neither distortions nor slips, in order.
std::vector<Eigen::Index> OwnOf(const identify::Problem& problem, const identify::SetupGroup& group) {
  std::set<Eigen::Index> own;
  for (const int run : group.runs) {
    const std::vector<Eigen::Index>& offsets = problem.offsets_of_run[run];
    own.insert(offsets.begin(), offsets.begin() + OwnCount(problem.runs[run]));
  }
  return {own.begin(), own.end()};
}

// The last `count` offsets of a run, those of distortions with what sessions have in common.
Eigen::VectorXd Fitted(const MeasuringRun& run, const Eigen::VectorXd& setup, Eigen::Index count) {
  Eigen::VectorXd fitted = setup.tail(count);
  for (Eigen::Index k = 0; k < count; ++k) fitted[k] += run.setup[static_cast<size_t>(setup.size() - count + k)].centre;
  return fitted;
}

// Places the rows of one run.
class Sink {
 public:
  // `own`: OwnOf its group.
  Sink(const identify::Problem& problem, int run, const Eigen::VectorXd& setup, const std::vector<Eigen::Index>& own,
       int errors, std::vector<int> next, Eigen::ArrayXd* weight, Eigen::ArrayXd* correlation, Eigen::ArrayXd* echo,
       Linearised* out)
      : run_(run),
        own_(own),
        artefact_(problem.offsets_of_run[run].begin(),
                  problem.offsets_of_run[run].begin() + (OwnCount(problem.runs[run]) >= 3 ? 3 : 0)),
        found_(problem.offsets_of_run[run].begin() + OwnCount(problem.runs[run]), problem.offsets_of_run[run].end()),
        fitted_(Fitted(problem.runs[run], setup, static_cast<Eigen::Index>(found_.size()))),
        next_(std::move(next)),
        whiteners_(problem.runs[run].row_count, identify::SeriesWhitener(problem.noise[run], 0)),
        row_(identify::SetupCount(problem, run) + errors + 1),
        weight_(weight),
        correlation_(correlation),
        echo_(echo),
        out_(out) {}

  Eigen::RowVectorXd& NextRow() { return row_; }
  void Close(int reading, int row, const instruments::Evaluation& evaluation, const Eigen::RowVectorXd& stored) {
    const int at = next_[row]++;
    const identify::SeriesWhitener::Factors factors = whiteners_[row].Next(reading);
    out_->run[at] = run_;
    out_->reading[at] = reading;
    out_->channel[at] = row;
    (*weight_)[at] = factors.weight;
    (*correlation_)[at] = factors.correlation;
    (*echo_)[at] = factors.echo;
    out_->sensitivity.row(at).head(evaluation.by_error.cols()) = evaluation.by_error.row(row);
    if (!artefact_.empty()) out_->artefact.row(at) = stored(artefact_);  // a direction has no place
    objective::Rows& rows = out_->rows;
    rows.own.row(at).head(static_cast<Eigen::Index>(own_.size())) = stored(own_);
    const Eigen::Index p = rows.common.cols();
    rows.common.row(at) = stored.segment(stored.size() - 1 - p, p);
    rows.y[at] = stored(found_).dot(fitted_) - stored[stored.size() - 1];
  }

 private:
  const int run_;
  const std::vector<Eigen::Index>& own_;              // of the group
  const std::vector<Eigen::Index> artefact_, found_;  // of the run: its place; distortions and slips
  const Eigen::VectorXd fitted_;
  std::vector<int> next_;
  std::vector<identify::SeriesWhitener> whiteners_;
  Eigen::RowVectorXd row_;
  Eigen::ArrayXd *weight_, *correlation_, *echo_;
  Linearised* out_;
};

// Rounding of a smooth signal leaves a sawtooth, whose first harmonic has the amplitude resolution / pi.
double RoundingSquares(const identify::Problem& problem) {
  double squares = 0.0;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const double sawtooth = instruments::CoarseResolutionOf(problem.runs[i]) / (M_PI * problem.noise[i].sigma_mm);
    const auto used = std::count(problem.is_used[i].begin(), problem.is_used[i].end(), true);
    squares += 0.5 * sawtooth * sawtooth * static_cast<double>(used);
  }
  return squares;
}

// What a sound instrument would have read in each row that is used.
std::vector<instruments::SoundRow> SoundRows(const Linearised& linearised, const identify::Point& point) {
  const identify::Problem& problem = *linearised.problem;
  std::vector<instruments::SoundRow> out(linearised.run.size());
  std::vector<std::vector<int>> at(problem.runs.size());  // by reading * row_count + row; -1: not used
  for (size_t i = 0; i < problem.runs.size(); ++i)
    at[i].assign(static_cast<size_t>(problem.runs[i].reading_count()) * problem.runs[i].row_count, -1);
  for (int n = 0; n < linearised.count(); ++n) {
    const int run = linearised.run[n];
    at[run][static_cast<size_t>(linearised.reading[n]) * problem.runs[run].row_count + linearised.channel[n]] = n;
  }
  identify::ErrorsOfRun errors_of_run(problem, point);
  instruments::Evaluation evaluation;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const MeasuringRun& run = problem.runs[i];
    if (run.path_readings != nullptr || run.row_count > instruments::kMaxRows) continue;
    MeasuringRun sound = run;
    const Eigen::VectorXd fitted = identify::SetupOf(problem, point, i);
    const Eigen::Index own = OwnCount(run), distortions = instruments::DistortionAmplitudes(run);
    Eigen::VectorXd setup(fitted.size() - distortions);
    setup << fitted.head(own), fitted.tail(fitted.size() - own - distortions);
    sound.setup.erase(sound.setup.begin() + own, sound.setup.begin() + own + distortions);
    sound.distortions.clear();
    instruments::SoundRow rows[instruments::kMaxRows];
    for (int k = 0; k < run.reading_count(); ++k) {
      const int* const its = &at[i][static_cast<size_t>(k) * run.row_count];
      if (std::all_of(its, its + run.row_count, [](int n) { return n < 0; })) continue;
      const machine::JointErrors<double>& errors = errors_of_run.At(sound.StateOf(k));
      instruments::Evaluate(*problem.machine, sound, k, errors, setup.data(), &evaluation);
      instruments::FillSoundRows(*problem.machine, sound, k, errors, evaluation, true, rows);
      for (int r = 0; r < std::min(run.row_count, instruments::kMaxRows); ++r)
        if (its[r] >= 0) out[its[r]] = rows[r];
    }
  }
  return out;
}

}  // namespace

std::vector<std::vector<int>> ClusteringsOf(const Linearised& linearised) {
  constexpr int kChunk = 15;   // rows: longer than most noise remembers
  constexpr int kBlocks = 40;  // of time: enough that their sums have a spread
  const int n = linearised.count();
  std::vector<int> chunks(n), series(n), sessions(n), blocks(n);
  double first_s = INFINITY, last_s = -INFINITY;
  bool is_timed = true;
  for (const MeasuringRun& run : linearised.problem->runs) {
    is_timed &= run.has_time;
    for (const double time_s : run.time_s) {
      first_s = std::min(first_s, time_s);
      last_s = std::max(last_s, time_s);
    }
  }
  int chunk = -1, one_series = -1;
  for (const objective::Stretch& some : linearised.rows.stretches) {
    ++one_series;
    for (int at = some.begin; at < some.end; ++at) {
      if ((at - some.begin) % kChunk == 0) ++chunk;
      chunks[at] = chunk;
      series[at] = one_series;
      sessions[at] = linearised.run[at];
      const double time_s = linearised.problem->runs[linearised.run[at]].time_s[linearised.reading[at]];
      blocks[at] = last_s > first_s
                       ? std::min(kBlocks - 1, static_cast<int>(kBlocks * (time_s - first_s) / (last_s - first_s)))
                       : 0;
    }
  }
  std::vector<std::vector<int>> all = {std::move(chunks), std::move(series), std::move(sessions)};
  if (is_timed) all.push_back(std::move(blocks));
  return all;
}

bool Linearised::Tells(const shapes::Shape& shape) const {
  if (step.empty()) return true;
  if (std::holds_alternative<shapes::Acceleration>(shape)) return false;  // where an axis sets off it lasts one reading
  const auto* harmonic = std::get_if<shapes::Harmonic>(&shape);
  if (harmonic == nullptr) return true;
  constexpr double kRowsPerPeriod = 6.0;  // sums over a sixth of a period keep 95 % of an amplitude
  return harmonic->frequency * step[harmonic->axis] * kRowsPerPeriod < 2.0 * std::numbers::pi;
}

int SensitivityOf(const Linearised& linearised, const machine::ErrorTerm& term) {
  if (shapes::IsAlongApproach(term.shape)) return linearised.along_approach();
  return machine::kComponents * term.joint + static_cast<int>(term.component);
}

Linearised Linearise(const identify::Problem& problem, const identify::Point& point, int declared) {
  Linearised out;
  out.problem = &problem;
  objective::Rows& rows = out.rows;
  std::vector<identify::Parameter> parameters = identify::ListParameters(point.model, true);
  std::erase_if(parameters, [declared](const identify::Parameter& one) { return one.term >= declared; });
  const auto p = static_cast<Eigen::Index>(parameters.size());
  Eigen::Index widest = 3;
  std::vector<std::vector<Eigen::Index>> own_of_group;
  for (size_t g = 0; g < problem.groups.size(); ++g) {
    const identify::SetupGroup& group = problem.groups[g];
    const std::vector<Eigen::Index>& own = own_of_group.emplace_back(OwnOf(problem, group));
    widest = std::max(widest, static_cast<Eigen::Index>(own.size()));
    Eigen::VectorXd& precision = rows.own_precision.emplace_back(static_cast<Eigen::Index>(own.size()));
    for (Eigen::Index k = 0; k < precision.size(); ++k)
      precision[k] = identify::PriorPrecision(group.parameters[own[k]], identify::Priors::kAll);
    rows.own_value.emplace_back(point.setup[g](own));
  }
  int count = 0;
  std::vector<std::vector<int>> first(problem.runs.size());
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const MeasuringRun& run = problem.runs[i];
    for (int row = 0; row < run.row_count; ++row) {
      first[i].push_back(count);
      for (int k = 0; k < run.reading_count(); ++k)
        count += problem.is_used[i][static_cast<size_t>(k) * run.row_count + row];
      rows.stretches.push_back({first[i].back(), count, problem.group_of_run[i]});
    }
  }
  out.run.resize(count);
  out.reading.resize(count);
  out.channel.resize(count);
  out.sensitivity.setZero(count, machine::kComponents * problem.machine->joint_count() + 1);
  out.artefact.setZero(count, 3);
  rows.own.setZero(count, widest);
  rows.common.setZero(count, p);
  rows.y.setZero(count);
  Eigen::ArrayXd weight(count), correlation(count), echo(count);
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    Sink sink(problem, static_cast<int>(i), identify::SetupOf(problem, point, i), own_of_group[problem.group_of_run[i]],
              static_cast<int>(p), first[i], &weight, &correlation, &echo, &out);
    identify::VisitRows(problem, static_cast<int>(i), point, parameters, &sink);
  }
  out.sound = SoundRows(out, point);
  const int tool = machine::kComponents * problem.machine->tool_joint();
  for (int at = 0; at < count; ++at) {
    const shapes::State state = out.StateAt(at);
    if (state.approach.is_touch)
      out.sensitivity(at, out.along_approach()) =
          machine::AlongApproach(state.approach, &out.sensitivity(at, tool), out.sensitivity.outerStride());
    double basis[shapes::kMaxBasisCount];
    for (size_t t = declared; t < point.model.terms.size(); ++t) {
      const machine::ErrorTerm& term = point.model.terms[t];
      shapes::Basis(term.shape, state, basis);
      for (int b = 0; b < shapes::BasisCount(term.shape); ++b)
        rows.y[at] += term.amplitude[b] * basis[b] * out.sensitivity(at, SensitivityOf(out, term));
    }
  }
  rows.whitening = objective::Whitening(std::move(weight), std::move(correlation), std::move(echo));
  rows.whitening.Apply(0, rows.own);
  rows.whitening.Apply(0, rows.common);
  rows.whitening.Apply(0, rows.y);
  rows.common_precision.resize(p);
  for (Eigen::Index k = 0; k < p; ++k) {
    const double largest = identify::LargestOf(point.model, parameters[k]);
    rows.common_precision[k] = 1.0 / (largest * largest);
  }
  rows.clusterings = ClusteringsOf(out);
  rows.rounding_squares = RoundingSquares(problem);
  for (const int run : out.run) {
    // No instrument reads ten times better than it states (the warning `quiet` of a fit says so, too).
    constexpr double kQuietest = 0.1;
    rows.least_squares += std::pow(kQuietest * problem.runs[run].sigma_mm / problem.noise[run].sigma_mm, 2);
  }
  return out;
}

}  // namespace axiscal::effects
