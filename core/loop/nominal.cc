#include "core/loop/nominal.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/base/language.h"
#include "core/base/units.h"
#include "core/identify/reduction.h"
#include "core/instruments/length/length_model.h"
#include "core/instruments/tracker/tracker_model.h"

namespace axiscal::loop {
namespace {

using instruments::MeasuringRun;
using machine::AxisKind;
using machine::Machine;

// What is stated, as it is or otherwise.
struct Nominal {
  Machine machine;
  std::vector<MeasuringRun> runs;
};

// One thing that may have been stated wrong.
struct Alternative {
  Cause cause;  // what the report says where it is so
  std::function<void(Nominal*)> change;
  double squares = INFINITY;  // of some readings less those of the machine without errors, mm^2
};

using Change = std::function<void(std::vector<double>* positions, size_t first)>;  // of one reading

void Apply(const Change& change, MeasuringRun* run) {
  for (int k = 0; k < run->reading_count(); ++k)
    change(&run->positions, static_cast<size_t>(k) * static_cast<size_t>(run->axis_count));
  instruments::DeriveMotion(run);
}

// Every n-th of some numbers, `width` of each reading.
void KeepEvery(int n, int width, std::vector<double>* numbers) {
  std::vector<double> kept;
  for (size_t at = 0; at < numbers->size(); at += static_cast<size_t>(n) * static_cast<size_t>(width))
    kept.insert(kept.end(), numbers->begin() + static_cast<std::ptrdiff_t>(at),
                numbers->begin() + static_cast<std::ptrdiff_t>(at) + width);
  *numbers = std::move(kept);
}

// Some thousand readings, evenly over the sessions: enough to tell squares from ten times as many.
std::vector<MeasuringRun> SampleOf(const std::vector<MeasuringRun>& runs) {
  constexpr int kReadings = 2000, kFewestOfASession = 50;
  int count = 0;
  for (const MeasuringRun& run : runs) count += run.reading_count();
  std::vector<MeasuringRun> sample;
  for (const MeasuringRun& run : runs) {
    const int n = std::min(count / kReadings, run.reading_count() / kFewestOfASession);
    MeasuringRun& some = sample.emplace_back(run);
    if (n < 2 || run.path_readings != nullptr || !run.touches.approach_in_spindle.empty() ||
        !run.targets.of_reading.empty())
      continue;
    KeepEvery(n, run.axis_count, &some.positions);
    KeepEvery(n, 1, &some.time_s);
    KeepEvery(n, 1, &some.temperature_celsius);
    for (MeasuringRun::Channel& channel : some.temperatures) KeepEvery(n, 1, &channel.celsius);
    if (!run.encoder_positions.empty()) KeepEvery(n, run.axis_count, &some.encoder_positions);
    if (!run.stated_senses.empty()) KeepEvery(n, run.axis_count, &some.stated_senses);
    some.bad_rows.clear();
    some.slips.clear();
    some.measured_mm.resize(run.row_count, static_cast<Eigen::Index>(some.time_s.size()));
    for (Eigen::Index k = 0; k < some.measured_mm.cols(); ++k) some.measured_mm.col(k) = run.measured_mm.col(k * n);
    some.stated.clear();  // sigmas, which nobody asks a sample for
    if (run.stated_mm.size() > 0) {
      some.stated_mm.resize(run.row_count, some.measured_mm.cols());
      for (Eigen::Index k = 0; k < some.stated_mm.cols(); ++k) some.stated_mm.col(k) = run.stated_mm.col(k * n);
    }
    instruments::DeriveMotion(&some);
  }
  return sample;
}

bool Moves(const std::vector<MeasuringRun>& runs, int axis) {
  return std::any_of(runs.begin(), runs.end(), [axis](const MeasuringRun& run) {
    for (int k = 1; k < run.reading_count(); ++k)
      if (run.PositionsOf(k)[axis] != run.PositionsOf(0)[axis]) return true;
    return false;
  });
}

// Chi-square by the stated sigmas, of what is not set aside, and of what set-ups are pulled from their places by: where
// nominal data are wrong they take up what they can.
double ScoreOf(const identify::Fit& fit) {
  double score = identify::PriorSquares(fit.problem, fit.point);
  for (size_t i = 0; i < fit.problem.runs.size(); ++i) {
    const MeasuringRun& run = fit.problem.runs[i];
    const Eigen::MatrixXd& residual_mm = fit.residuals_mm[i];
    for (Eigen::Index k = 0; k < residual_mm.size(); ++k)
      if (fit.problem.is_used[i][static_cast<size_t>(k)]) score += std::pow(residual_mm.data()[k] / run.sigma_mm, 2);
  }
  return score;
}

class Finder {
 public:
  Finder(const Machine& machine, const std::vector<MeasuringRun>& runs, const identify::Options& options)
      : machine_(machine), runs_(runs), options_(options), sample_{machine, SampleOf(runs)} {
    options_.judge_correlation = options_.profile_intervals = options_.raise_noise = false;
  }

  // `stated`: ScoreOf the declared fit.
  absl::StatusOr<std::optional<Cause>> Find(double stated) {
    stated_squares_ = NominalSquares(sample_).value_or(INFINITY);
    for (int axis = 0; axis < machine_.axis_count(); ++axis) {
      if (!Moves(runs_, axis)) continue;
      TryDirection(axis);
      TryColumns(axis);
    }
    // Of chi-square: no error of a machine, and no chance, takes 99 of 100 parts.
    constexpr double kShare = 0.01;
    std::optional<Cause> best;
    double least = kShare * stated;
    for (const Alternative& one : nearest_) {
      const Nominal other = With(one, {machine_, runs_});
      identify::Options options = options_;
      options.model = machine::DeclaredModel(other.machine);
      const absl::StatusOr<identify::Fit> fit = identify::FitRuns(other.machine, other.runs, options);
      if (absl::IsCancelled(fit.status())) return fit.status();
      if (!fit.ok() || !(ScoreOf(*fit) < least)) continue;
      least = ScoreOf(*fit);
      best = one.cause;
      best->evidence = stated - least;
    }
    return best;
  }

 private:
  // Of the readings less those of a machine without errors, mm^2.
  static std::optional<double> NominalSquares(const Nominal& nominal) {
    const absl::StatusOr<identify::Problem> problem = identify::MakeProblem(nominal.machine, nominal.runs);
    if (!problem.ok()) return std::nullopt;
    double squares = 0.0;
    for (const Eigen::MatrixXd& one : identify::ResidualsOf(*problem, identify::StartingPoint(*problem, {})))
      squares += one.squaredNorm();
    return std::isfinite(squares) ? std::optional<double>(squares) : std::nullopt;
  }

  static Nominal With(const Alternative& alternative, Nominal nominal) {
    alternative.change(&nominal);
    for (MeasuringRun& run : nominal.runs) {
      if (run.kind == instruments::Kind::kTracker)
        run.tracker_from_machine = tracker::StartingPose(nominal.machine, run);
      if (run.kind == instruments::Kind::kLength && !length::HasStatedZero(run))
        run.length.zero_mm = length::StartingZero(nominal.machine, run);
    }
    return nominal;
  }

  // Keeps the few that come nearest to the readings without any errors, and far nearer than what is stated: of a fault
  // that is worth being looked for all others are millimetres away.
  void Try(Alternative alternative) {
    constexpr size_t kKept = 3;
    constexpr double kNearer = 0.1;  // of the squares
    const std::optional<double> squares = NominalSquares(With(alternative, sample_));
    if (!squares || !(*squares < kNearer * stated_squares_)) return;
    alternative.squares = *squares;
    const auto at = std::find_if(nearest_.begin(), nearest_.end(),
                                 [&](const Alternative& other) { return *squares < other.squares; });
    nearest_.insert(at, std::move(alternative));
    if (nearest_.size() > kKept) nearest_.pop_back();
  }

  void TryDirection(int axis) {
    Alternative other;
    const Eigen::Vector3d direction = -machine_.axes[axis].direction;
    other.change = [axis, direction](Nominal* nominal) { nominal->machine.axes[axis].direction = direction; };
    const std::string& name = machine_.axes[axis].name;
    const bool is_rotary = machine_.axes[axis].kind == AxisKind::kRotary;
    const auto number = [](double value) { return value == 0.0 ? 0.0 : value; };  // no minus zero
    const std::string right = absl::StrFormat("\"direction\": [%.10g, %.10g, %.10g]", number(direction.x()),
                                              number(direction.y()), number(direction.z()));
    other.cause = {
        .kind = Cause::kNominal,
        .subject = absl::StrCat("machine.json: axis ", name, is_rotary ? " turns" : " moves", " the other way"),
        .correction = absl::StrCat("axis ", name, ": ", right, ", or turn the sign of column ", name),
        .subject_german = absl::StrCat("machine.json: Achse ", name, is_rotary ? " dreht" : " fährt", " anders herum"),
        .correction_german =
            absl::StrCat("Achse ", name, ": ", right, ", oder das Vorzeichen der Spalte ", name, " umkehren")};
    Try(std::move(other));
  }

  // `change` in all sessions, then in each alone; `what`: its cause, without saying where.
  void TryChange(const Cause& what, const Change& change) {
    const auto in = [&](const std::string& english, const std::string& german) {
      Cause cause = what;
      cause.kind = Cause::kNominal;
      cause.subject = english + what.subject;
      cause.subject_german = german + what.subject_german;
      return cause;
    };
    Try({in("all sessions: ", "alle Messungen: "), [change](Nominal* nominal) {
           for (MeasuringRun& run : nominal->runs) Apply(change, &run);
         }});
    for (size_t i = 0; runs_.size() > 1 && i < runs_.size(); ++i)
      Try({in(absl::StrCat("session '", runs_[i].session, "': "), absl::StrCat("Messung ", runs_[i].session, ": ")),
           [change, i](Nominal* nominal) { Apply(change, &nominal->runs[i]); }});
  }

  void TryColumns(int axis) {
    const std::string& name = machine_.axes[axis].name;
    const AxisKind kind = machine_.axes[axis].kind;
    const auto at = static_cast<size_t>(axis);
    for (int with = axis + 1; with < machine_.axis_count(); ++with) {
      if (machine_.axes[with].kind != kind) continue;
      const std::string& other = machine_.axes[with].name;
      TryChange({.subject = absl::StrCat("columns ", name, " and ", other, " have each other's numbers"),
                 .correction = "exchange the names of these columns",
                 .subject_german = absl::StrCat("die Spalten ", name, " und ", other, " sind vertauscht"),
                 .correction_german = "die Namen dieser Spalten tauschen"},
                [at, by = static_cast<size_t>(with)](std::vector<double>* positions, size_t first) {
                  std::swap((*positions)[first + at], (*positions)[first + by]);
                });
    }
    const auto scaled = [&](const char* unit, const char* german, double factor) {
      const std::string number = absl::StrFormat("%.10g", factor);
      TryChange({.subject = absl::StrCat("column ", name, " is in ", unit),
                 .correction = absl::StrCat("multiply column ", name, " by ", number),
                 .subject_german = absl::StrCat("die Spalte ", name, " ist in ", german),
                 .correction_german = absl::StrCat("die Spalte ", name, " mit ",
                                                   base::NumberIn(base::Language::kGerman, number), " malnehmen")},
                [at, factor](std::vector<double>* positions, size_t first) { (*positions)[first + at] *= factor; });
    };
    if (kind == AxisKind::kRotary) return scaled("radians", "Radiant", base::kDegPerRad);
    constexpr double kMmPerInch = 25.4, kMmPerUm = 1e-3, kMmPerM = 1e3;
    scaled("inches", "Zoll", kMmPerInch);
    scaled("micrometres", "Mikrometern", kMmPerUm);
    scaled("metres", "Metern", kMmPerM);
  }

  const Machine& machine_;
  const std::vector<MeasuringRun>& runs_;
  identify::Options options_;
  const Nominal sample_;              // as stated, by which alternatives are looked through
  double stated_squares_ = INFINITY;  // NominalSquares as stated
  std::vector<Alternative> nearest_;  // the nearest first
};

}  // namespace

absl::StatusOr<std::optional<Cause>> FindNominalFault(const Machine& machine, const std::vector<MeasuringRun>& runs,
                                                      const absl::StatusOr<identify::Fit>& declared,
                                                      const identify::Options& options) {
  if (absl::IsCancelled(declared.status())) return declared.status();
  // Without a fit whatever fits is better.
  return Finder(machine, runs, options).Find(declared.ok() ? ScoreOf(*declared) : INFINITY);
}

std::vector<Cause> NominalConstants(const Machine& machine, const identify::Fit& fit) {
  // A machine that is aligned and a tool that was measured are off by less.
  constexpr double kFarMm = 0.2;
  std::vector<Cause> causes;
  const std::vector<identify::Parameter> parameters = identify::ListParameters(fit.point.model, true);
  for (size_t i = 0; i < parameters.size(); ++i) {
    const machine::ErrorTerm& term = fit.point.model.terms[parameters[i].term];
    if (!std::holds_alternative<shapes::Constant>(term.shape) || machine::IsAngle(term.component)) continue;
    const identify::Estimate& estimate = fit.result.estimates[i];
    if (!estimate.identifiable || !(std::abs(estimate.value) > kFarMm + 3.0 * estimate.sigma)) continue;
    const auto along = Eigen::Vector3d::Unit(static_cast<int>(term.component));
    const double evidence = std::pow(estimate.value / estimate.sigma, 2);
    const char coordinate = "XYZ"[static_cast<int>(term.component)];
    const std::string by = absl::StrFormat("%.4f +- %.4f", estimate.value, estimate.sigma);
    const std::string by_german =
        base::NumberIn(base::Language::kGerman, absl::StrFormat("%.4f ± %.4f", estimate.value, estimate.sigma));
    if (term.joint == machine.tool_joint()) {
      if (std::abs(along.dot(machine.tool_direction)) < 0.9) continue;
      causes.push_back(
          {.kind = Cause::kNominal,
           .subject = "the sessions' headers: the tool point along the tool",
           .evidence = evidence,
           .correction = absl::StrFormat("add %s mm to coordinate %c of \"tool_tip_mm\", or measure the tool again; "
                                         "without that, %s corrects for it",
                                         by, coordinate, estimate.name),
           .subject_german = "die Köpfe der Messungen: der Werkzeugpunkt entlang des Werkzeugs",
           .correction_german =
               absl::StrFormat("%s mm zur Koordinate %c von \"tool_tip_mm\" addieren, oder das Werkzeug "
                               "neu messen; sonst korrigiert %s dafür",
                               by_german, coordinate, estimate.name)});
    } else if (term.joint < machine.axis_count() && machine.axes[term.joint].kind == AxisKind::kRotary) {
      const std::string& axis = machine.axes[term.joint].name;
      causes.push_back({.kind = Cause::kNominal,
                        .subject = absl::StrCat("machine.json: where axis ", axis, " stands"),
                        .evidence = evidence,
                        .correction = absl::StrFormat(
                            "axis %s: add %s mm to coordinate %c of \"point_mm\"; without that, %s corrects for it",
                            axis, by, coordinate, estimate.name),
                        .subject_german = absl::StrCat("machine.json: wo die Achse ", axis, " steht"),
                        .correction_german = absl::StrFormat(
                            "Achse %s: %s mm zur Koordinate %c von \"point_mm\" addieren; sonst korrigiert %s dafür",
                            axis, by_german, coordinate, estimate.name)});
    }
  }
  return causes;
}

}  // namespace axiscal::loop
