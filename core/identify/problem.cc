#include "core/identify/problem.h"

#include <algorithm>
#include <map>
#include <set>

#include "core/base/demand.h"
#include "core/base/status.h"
#include "core/base/units.h"
#include "core/identify/rows.h"
#include "core/identify/whitening.h"
#include "core/instruments/length/length_model.h"
#include "core/instruments/resolution.h"

namespace axiscal::identify {
namespace {

using instruments::MeasuringRun;

// Rows are gathered in a small buffer so that the rank update runs at full speed.
class GramBuilder {
 public:
  explicit GramBuilder(int width) : gram_(Eigen::MatrixXd::Zero(width, width)), buffer_(kRows, width) {}

  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  Rows::RowXpr NextRow() {
    if (used_ == kRows) Flush();
    return buffer_.row(used_++);
  }

  Eigen::MatrixXd Finish() {
    Flush();
    gram_.triangularView<Eigen::StrictlyUpper>() = gram_.transpose();
    return std::move(gram_);
  }

 private:
  static constexpr int kRows = 128;

  void Flush() {
    gram_.selfadjointView<Eigen::Lower>().rankUpdate(buffer_.topRows(used_).transpose());
    used_ = 0;
  }

  Eigen::MatrixXd gram_;
  Rows buffer_;
  int used_ = 0;
};

// Whitened rows of one run, added to the Gram matrix of its group.
class GramSink {
 public:
  GramSink(const Problem& problem, int run, Eigen::Index width, GramBuilder* gram, int* row_count)
      : whiteners_(problem.runs[run].row_count, SeriesWhitener(problem.noise[run], width)),
        gram_(gram),
        row_count_(row_count) {}

  GramBuilder::Rows::RowXpr NextRow() { return gram_->NextRow(); }
  template <typename Row>
  void Close(int reading, int row_index, const instruments::Evaluation&, Row& row) {
    whiteners_[row_index].Apply(reading, row);
    ++*row_count_;
  }

 private:
  std::vector<SeriesWhitener> whiteners_;
  GramBuilder* gram_;
  int* row_count_;
};

}  // namespace

void SetKnownAside(const MeasuringRun& run, std::vector<bool>* is_used) {
  for (const touch::Rejection& rejection : run.touches.rejected) (*is_used)[rejection.reading] = false;
  for (const size_t row : run.bad_rows) (*is_used)[row] = false;
}

void StartAs(const MeasuringRun& first, MeasuringRun* run) {
  run->tracker_from_machine = first.tracker_from_machine;
  run->length.zero_mm = first.length.zero_mm;
}

absl::Status CheckSameSetup(const MeasuringRun& first, const MeasuringRun& other) {
  const auto refuse = [&](const std::string& what) {
    return absl::InvalidArgumentError(absl::StrCat("sessions '", first.session, "' and '", other.session,
                                                   "' share the setup '", other.setup_name, "' but not ", what));
  };
  if (first.kind != other.kind) return refuse("the instrument");
  if (first.free_datum != other.free_datum) return refuse("the datum, expected the same '# datum: free ...' in both");
  const auto differs = [&](const std::string& key, const std::string& a, const std::string& b) {
    return refuse(absl::StrCat(key, ": ", a, " and ", b, ", expected the same in both"));
  };
  const auto text = [](const Eigen::Vector3d& point) {
    return absl::StrFormat("%.10g %.10g %.10g", point.x(), point.y(), point.z());
  };
  if (first.ball_mm != other.ball_mm)
    return differs(first.kind == instruments::Kind::kLength ? "anchor_mm" : "table_ball_mm", text(first.ball_mm),
                   text(other.ball_mm));
  if (first.scale_of != other.scale_of) return differs("serial", first.scale_of, other.scale_of);
  if (first.length.is_beam != other.length.is_beam || first.length.beam != other.length.beam ||
      first.length.is_on_bed != other.length.is_on_bed)
    return refuse("anchor or beam, expected the same anchor_mm or beam and anchor_on in both");
  if (first.direction.about != other.direction.about || first.direction.is_on_bed != other.direction.is_on_bed)
    return refuse("the direction, expected the same about and reference in both");
  if (first.bar_length_mm != other.bar_length_mm)
    return differs("bar_length_mm", absl::StrCat(first.bar_length_mm), absl::StrCat(other.bar_length_mm));
  const bool are_same_targets = std::equal(
      first.targets.on_tool.begin(), first.targets.on_tool.end(), other.targets.on_tool.begin(),
      other.targets.on_tool.end(),
      [](const tracker::Target& a, const tracker::Target& b) { return a.name == b.name && a.point_mm == b.point_mm; });
  if (!are_same_targets) return refuse("the targets, expected the same lines '# target NAME' in both");
  // Offsets of what the spindle carries belong to one tool.
  const bool has_tool_offset = std::any_of(first.setup.begin(), first.setup.end(), [](const auto& parameter) {
    return parameter.name.starts_with("run_out") || parameter.name.starts_with("target");
  });
  if (has_tool_offset && first.tip_mm != other.tip_mm)
    return differs("tool_tip_mm", text(first.tip_mm), text(other.tip_mm));
  if (first.touches.centre_mm != other.touches.centre_mm ||
      first.touches.stylus_radius_mm != other.touches.stylus_radius_mm)
    return refuse("features and stylus, expected the same '# sphere', '# plane' and stylus_radius_mm in both");
  if (first.setup.size() != other.setup.size()) {
    const auto &more = first.setup.size() > other.setup.size() ? first.setup : other.setup,
               &less = first.setup.size() > other.setup.size() ? other.setup : first.setup;
    const auto lacking = std::find_if(more.begin(), more.end(), [&](const instruments::SetupParameter& one) {
      return std::none_of(less.begin(), less.end(), [&](const auto& another) { return another.name == one.name; });
    });
    return refuse(absl::StrCat("the set-up offset ", lacking == more.end() ? more.back().name : lacking->name,
                               ", expected the same header lines and columns in both"));
  }
  for (size_t k = 0; k < first.setup.size(); ++k) {
    const instruments::SetupParameter &a = first.setup[k], &b = other.setup[k];
    if (a.held.has_value() != b.held.has_value())
      return refuse(absl::StrCat("a certificate of ", a.name, ", expected '# certificate ", a.name, ": ...' in both"));
    if (a.prior_sigma == b.prior_sigma && a.is_weak == b.is_weak) continue;
    const double unit = a.is_angle ? base::kUradPerRad : base::kUmPerMm;
    return differs(absl::StrCat(a.name, a.is_angle ? "_sigma_urad" : "_sigma_um"), absl::StrCat(a.prior_sigma * unit),
                   absl::StrCat(b.prior_sigma * unit));
  }
  return absl::OkStatus();
}

size_t ScaleAt(const MeasuringRun& run) {
  const auto scale = std::find_if(run.setup.begin(), run.setup.end(), [](const instruments::SetupParameter& parameter) {
    return parameter.name == length::kScaleName;
  });
  DEMAND(scale != run.setup.end());
  return static_cast<size_t>(scale - run.setup.begin());
}

absl::Status CheckSameScale(const MeasuringRun& first, const MeasuringRun& other) {
  const double a = first.setup[ScaleAt(first)].prior_sigma, b = other.setup[ScaleAt(other)].prior_sigma;
  if (a == b) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "sessions '", first.session, "' and '", other.session, "' are of one instrument, serial '", other.scale_of,
      "', whose scale_sigma_um is ", a * base::kUmPerMm, " and ", b * base::kUmPerMm, ", expected the same in both"));
}

absl::Status CheckRecorded(const machine::Machine& machine, const std::vector<MeasuringRun>& runs,
                           const machine::ErrorModel& model) {
  const MeasuringRun* with = nullptr;
  const MeasuringRun* without = nullptr;
  for (const MeasuringRun& run : runs) {
    if (run.path_readings != nullptr) continue;  // no moment belongs to a reading of a whole path
    (run.has_time ? with : without) = &run;
  }
  if (with != nullptr && without != nullptr)
    return absl::InvalidArgumentError(absl::StrCat("session '", without->session, "' has no column t_s and session '",
                                                   with->session, "' has one: expected it in all of them, or in none"));
  for (const MeasuringRun& run : runs) {
    if (run.path_readings != nullptr) continue;
    const std::vector<std::string> channels = instruments::TemperatureColumns(run);
    for (const machine::ErrorTerm& term : model.terms) {
      RETURN_IF_ERROR(base::Within(absl::StrCat("session '", run.session, "'"),
                                   machine::RequireState(machine, term, run.has_time, channels)));
    }
  }
  return absl::OkStatus();
}

Eigen::VectorXd SetupOf(const Problem& problem, const Point& point, size_t run) {
  return point.setup[static_cast<size_t>(problem.group_of_run[run])](problem.offsets_of_run[run]);
}

size_t FirstOfSetup(const Problem& problem, size_t run) {
  const std::vector<int>& runs = problem.groups[static_cast<size_t>(problem.group_of_run[run])].runs;
  for (const int other : runs) {
    if (problem.offsets_of_run[static_cast<size_t>(other)] == problem.offsets_of_run[run])
      return static_cast<size_t>(other);
  }
  return run;
}

size_t CountSetups(const Problem& problem) {
  size_t count = 0;
  for (size_t i = 0; i < problem.runs.size(); ++i) count += FirstOfSetup(problem, i) == i;
  return count;
}

namespace {

// Adds the offsets of a set-up that is not in the group yet; `first`: a run of the group, if any. Returns where they
// stand in it.
absl::StatusOr<std::vector<Eigen::Index>> AddSetup(const MeasuringRun& run, const MeasuringRun* first,
                                                   const std::vector<Eigen::Index>& of_first, SetupGroup* group) {
  std::vector<Eigen::Index> offsets;
  for (const instruments::SetupParameter& parameter : run.setup) {
    if (first == nullptr || parameter.name != length::kScaleName) {
      offsets.push_back(static_cast<Eigen::Index>(group->parameters.size()));
      group->parameters.push_back(parameter);
      continue;
    }
    RETURN_IF_ERROR(CheckSameScale(*first, run));
    offsets.push_back(of_first[ScaleAt(*first)]);
  }
  return offsets;
}

}  // namespace

absl::StatusOr<Problem> MakeProblem(const machine::Machine& machine, std::vector<MeasuringRun> runs) {
  RETURN_IF_ERROR(CheckRecorded(machine, runs));
  instruments::ShareTemperatures({&runs});
  Problem problem;
  problem.machine = &machine;
  std::map<std::string, size_t> first_of_setup;
  std::map<std::string, int> group_of_serial;
  std::set<std::string> sessions;
  for (size_t i = 0; i < runs.size(); ++i) {
    const MeasuringRun& run = runs[i];
    if (!sessions.insert(run.session).second) {
      return absl::InvalidArgumentError(absl::StrCat("session '", run.session, "' is there twice"));
    }
    size_t first = i;
    if (run.slips.empty()) first = first_of_setup.emplace(run.setup_name, i).first->second;  // a slip is of one alone
    int at = static_cast<int>(problem.groups.size());
    if (first != i) {
      RETURN_IF_ERROR(CheckSameSetup(runs[first], run));
      StartAs(runs[first], &runs[i]);
      at = problem.group_of_run[first];
      problem.offsets_of_run.push_back(problem.offsets_of_run[first]);
    } else {
      if (!run.scale_of.empty()) at = group_of_serial.emplace(run.scale_of, at).first->second;
      if (at == static_cast<int>(problem.groups.size())) problem.groups.emplace_back();
      SetupGroup& group = problem.groups[at];
      const bool is_first = group.runs.empty();
      const auto before = is_first ? 0 : static_cast<size_t>(group.runs[0]);
      ASSIGN_OR_RETURN(std::vector<Eigen::Index> offsets,
                       AddSetup(run, is_first ? nullptr : &runs[before],
                                is_first ? std::vector<Eigen::Index>() : problem.offsets_of_run[before], &group));
      problem.offsets_of_run.push_back(std::move(offsets));
    }
    problem.groups[at].runs.push_back(static_cast<int>(i));
    problem.group_of_run.push_back(at);
    problem.noise.push_back({instruments::SigmaWithRounding(run)});
    problem.is_used.emplace_back(static_cast<size_t>(run.reading_count()) * run.row_count, true);
    SetKnownAside(run, &problem.is_used.back());
  }
  problem.runs = std::move(runs);
  return problem;
}

Point StartingPoint(const Problem& problem, const machine::ErrorModel& model) {
  Point point;
  point.model = model;
  for (const SetupGroup& group : problem.groups) {
    Eigen::VectorXd& setup = point.setup.emplace_back(Eigen::VectorXd::Zero(group.parameters.size()));
    for (Eigen::Index k = 0; k < setup.size(); ++k)
      setup[k] = group.parameters[static_cast<size_t>(k)].held.value_or(0.0);
  }
  return point;
}

std::vector<Parameter> ListParameters(const machine::ErrorModel& model, bool with_nonlinear) {
  std::vector<Parameter> parameters;
  for (int i = 0; i < static_cast<int>(model.terms.size()); ++i) {
    for (int k = 0; k < shapes::BasisCount(model.terms[i].shape); ++k) parameters.push_back({i, k, false});
    if (with_nonlinear && shapes::NonlinearParameter(model.terms[i].shape)) parameters.push_back({i, 0, true});
  }
  return parameters;
}

double ValueOf(const machine::ErrorModel& model, const Parameter& parameter) {
  const machine::ErrorTerm& term = model.terms[parameter.term];
  return parameter.is_nonlinear ? *shapes::NonlinearParameter(term.shape) : term.amplitude[parameter.basis];
}

double PriorPrecision(const machine::ErrorModel& model, const Parameter& parameter) {
  const machine::ErrorTerm& term = model.terms[parameter.term];
  if (parameter.is_nonlinear || !(term.prior_sigma > 0.0)) return 0.0;
  const double sigma = term.prior_sigma * shapes::PriorRoot(term.shape, parameter.basis);
  return 1.0 / (sigma * sigma);
}

void SetValue(const Parameter& parameter, double value, machine::ErrorModel* model) {
  machine::ErrorTerm& term = model->terms[parameter.term];
  (parameter.is_nonlinear ? *shapes::NonlinearParameter(term.shape) : term.amplitude[parameter.basis]) = value;
}

NormalEquations Assemble(const Problem& problem, const Point& point, const std::vector<Parameter>& parameters) {
  NormalEquations normal;
  normal.parameters = parameters;
  for (const SetupGroup& group : problem.groups) {
    GroupNormal block;
    block.setup_count = static_cast<int>(group.parameters.size());
    const int width = block.setup_count + static_cast<int>(parameters.size()) + 1;
    GramBuilder gram(width);
    for (const int run : group.runs) {
      GramSink sink(problem, run, width, &gram, &normal.row_count);
      VisitRows(problem, run, point, parameters, &sink);
    }
    block.gram = gram.Finish();
    normal.groups.push_back(std::move(block));
  }
  return normal;
}

std::vector<Eigen::MatrixXd> ResidualsOf(const Problem& problem, const Point& point) {
  const machine::Machine& machine = *problem.machine;
  std::vector<Eigen::MatrixXd> residuals_mm;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const MeasuringRun& run = problem.runs[i];
    const Eigen::VectorXd setup = SetupOf(problem, point, i);
    Eigen::MatrixXd residual_mm(run.row_count, run.reading_count());
    ErrorsOfRun errors_of_run(problem, point);
    for (int k = 0; k < run.reading_count(); ++k) {
      instruments::PredictWith(
          machine, run, k,
          [&](const shapes::State& state) -> const machine::JointTransforms& {
            return errors_of_run.TransformsAt(state);
          },
          setup.data(), residual_mm.col(k).data());
    }
    residuals_mm.push_back(residual_mm - run.measured_mm);
  }
  return residuals_mm;
}

// `visit(reading, row, whitened)` for every used row, series after series.
template <typename Visit>
static void VisitWhitened(const Problem& problem, size_t run, const Eigen::MatrixXd& residuals_mm, Visit visit) {
  const int rows = problem.runs[run].row_count;
  for (int r = 0; r < rows; ++r) {
    SeriesWhitener whitener(problem.noise[run], 1);
    Eigen::Matrix<double, 1, 1> value;
    for (int k = 0; k < residuals_mm.cols(); ++k) {
      if (!problem.is_used[run][static_cast<size_t>(k) * rows + r]) continue;
      const RowWeight* const weight = problem.WeightOf(run, k);
      value[0] = weight != nullptr ? weight->row(r).dot(residuals_mm.col(k)) : residuals_mm(r, k);
      whitener.Apply(k, value);
      visit(k, r, value[0]);
    }
  }
}

Eigen::MatrixXd WhitenedOf(const Problem& problem, size_t run, const Eigen::MatrixXd& residuals_mm) {
  Eigen::MatrixXd whitened = Eigen::MatrixXd::Zero(residuals_mm.rows(), residuals_mm.cols());
  VisitWhitened(problem, run, residuals_mm, [&](int k, int r, double value) { whitened(r, k) = value; });
  return whitened;
}

double WhitenedSquaresOf(const Problem& problem, size_t run, const Eigen::MatrixXd& residuals_mm) {
  double squares = 0.0;
  VisitWhitened(problem, run, residuals_mm, [&](int, int, double value) { squares += value * value; });
  return squares;
}

double WhitenedSquares(const Problem& problem, const std::vector<Eigen::MatrixXd>& residuals_mm) {
  double squares = 0.0;
  for (size_t i = 0; i < problem.runs.size(); ++i) squares += WhitenedSquaresOf(problem, i, residuals_mm[i]);
  return squares;
}

}  // namespace axiscal::identify
