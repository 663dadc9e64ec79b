#include "core/instruments/eccentricity/eccentricity_bind.h"

#include <cmath>
#include <map>

#include "core/base/units.h"
#include "core/instruments/eccentricity/eccentricity_path.h"
#include "core/session/column_rules.h"

namespace axiscal::eccentricity {
namespace {

using instruments::MeasuringRun;
using session::Session;

constexpr char kPrefix[] = "path ";
const char* const kColumns[3] = {"ex_um", "ey_um", "ez_um"};

absl::StatusOr<std::map<std::string, Path>> PathsOf(const machine::Machine& machine, const Session& session) {
  std::map<std::string, Path> paths;
  for (const session::HeaderEntry& entry : session.header) {
    if (entry.key.rfind(kPrefix, 0) != 0) continue;
    const std::string name = entry.key.substr(sizeof(kPrefix) - 1);
    ASSIGN_OR_RETURN(Path path, ParsePath(machine, name, entry.value));
    if (!paths.emplace(name, std::move(path)).second)
      return absl::InvalidArgumentError("header 'path " + name + "' stands twice, expected once");
  }
  return paths;
}

// The ball bar's run along a path: there (sense 1), back (-1), or without backlash (0).
absl::StatusOr<MeasuringRun> TraceOf(const machine::Machine& machine, const Path& path, int sense,
                                     const MeasuringRun& run) {
  MeasuringRun trace;
  trace.session = run.session;
  trace.kind = instruments::Kind::kBallbar;
  trace.tip_mm = run.tip_mm;
  trace.ball_mm = run.ball_mm;
  trace.bar_length_mm = run.bar_length_mm;
  trace.setup = run.setup;
  trace.axis_count = machine.axis_count();
  ASSIGN_OR_RETURN(const std::vector<double> there,
                   CommandsOf(machine, path, run.tip_mm, run.ball_mm, run.bar_length_mm));
  const size_t axes = machine.axis_count(), count = there.size() / axes;
  for (size_t k = 0; k < count; ++k) {
    const size_t from = sense < 0 ? count - 1 - k : k;
    trace.positions.insert(trace.positions.end(), there.begin() + from * axes, there.begin() + (from + 1) * axes);
  }
  trace.time_s.assign(count, 0.0);
  trace.temperature_celsius.assign(count, shapes::kReferenceTemperatureCelsius);
  trace.measured_mm = Eigen::MatrixXd::Zero(1, count);
  instruments::DeriveMotion(&trace);
  for (shapes::AxisState& state : trace.axis_states.Own()) {
    if (sense == 0) state.sense = 0.0;
  }
  return trace;
}

class Binder {
 public:
  Binder(const machine::Machine& machine, const Session& session, const std::vector<size_t>* log_lines,
         MeasuringRun* run)
      : machine_(machine), session_(session), log_lines_(log_lines), run_(run) {}

  absl::Status Bind() {
    ASSIGN_OR_RETURN(paths_, PathsOf(machine_, session_));
    const session::Column* const runs = session::FindColumn(session_, "run");
    const session::Column* const senses = session::FindColumn(session_, "sense");
    if (runs == nullptr || senses == nullptr) return absl::InvalidArgumentError("column 'run' or 'sense' is missing");
    std::vector<double> measured_mm;
    for (size_t row = 0; row < session_.reading_count(); ++row) {
      const auto path = paths_.find(runs->texts[row]);
      if (path == paths_.end()) {
        return absl::InvalidArgumentError(absl::StrCat(Line(row), ": run '", runs->texts[row],
                                                       "' has no path, expected a header '# path ", runs->texts[row],
                                                       ": AXIS FROM TO fixed|turning UX UY UZ'"));
      }
      const double sense = senses->values[row];
      if (sense != -1.0 && sense != 0.0 && sense != 1.0)
        return absl::InvalidArgumentError(absl::StrCat(Line(row), ": sense = ", sense, ", expected 1, -1 or 0"));
      RETURN_IF_ERROR(BindRow(row, path->second, static_cast<int>(sense), &measured_mm));
    }
    run_->path_readings = std::make_shared<const Eccentricities>(std::move(out_));
    run_->measured_mm = Eigen::Map<Eigen::RowVectorXd>(measured_mm.data(), measured_mm.size());
    const size_t readings = measured_mm.size();
    run_->positions.assign(readings * machine_.axis_count(), 0.0);
    run_->time_s.assign(readings, 0.0);
    run_->temperature_celsius.assign(readings, shapes::kReferenceTemperatureCelsius);
    return absl::OkStatus();
  }

 private:
  std::string Line(size_t row) const {
    return absl::StrCat("line ", session::ReadingLine(session_.header.size(), run_->readings_before + row, log_lines_));
  }

  absl::Status BindRow(size_t row, const Path& path, int sense, std::vector<double>* measured_mm) {
    bool any = false;
    for (int c = 0; c < 3; ++c) {
      const session::Column* const column = session::FindColumn(session_, kColumns[c]);
      if (column == nullptr) return absl::InvalidArgumentError(absl::StrCat("column '", kColumns[c], "' is missing"));
      if (std::isnan(column->values[row])) continue;
      if (!Shows(machine_, path, c)) {
        return absl::InvalidArgumentError(absl::StrCat(Line(row), " (", kColumns[c], "): ", column->values[row],
                                                       ", but ", machine_.axes[path.axis].name, " turns about ",
                                                       std::string(1, "xyz"[c]), ", expected an empty cell"));
      }
      any = true;
      ASSIGN_OR_RETURN(const int trace, Trace(path, sense));
      Eigen::VectorXd weight = weights_.at(path.name).row(c).transpose();
      if (sense < 0) weight.reverseInPlace();
      out_.readings.push_back({trace, std::move(weight), static_cast<int>(row), c});
      measured_mm->push_back(column->values[row] * base::kMmPerUm);
    }
    if (any) return absl::OkStatus();
    return absl::InvalidArgumentError(Line(row) + ": no eccentricity, expected at least one of ex_um, ey_um, ez_um");
  }

  absl::StatusOr<int> Trace(const Path& path, int sense) {
    const auto key = std::make_pair(path.name, sense);
    const auto known = trace_of_.find(key);
    if (known != trace_of_.end()) return known->second;
    ASSIGN_OR_RETURN(MeasuringRun trace, TraceOf(machine_, path, sense, *run_));
    weights_.emplace(path.name, CentreWeights(machine_, path, AnglesOf(path)));
    out_.traces.push_back(std::move(trace));
    return trace_of_[key] = static_cast<int>(out_.traces.size()) - 1;
  }

  const machine::Machine& machine_;
  const Session& session_;
  const std::vector<size_t>* const log_lines_;
  MeasuringRun* run_;
  std::map<std::string, Path> paths_;
  std::map<std::pair<std::string, int>, int> trace_of_;
  std::map<std::string, Eigen::Matrix3Xd> weights_;
  Eccentricities out_;
};

}  // namespace

bool HasPaths(const Session& session) {
  return std::any_of(session.header.begin(), session.header.end(),
                     [](const session::HeaderEntry& entry) { return entry.key.rfind(kPrefix, 0) == 0; });
}

absl::Status BindEccentricities(const machine::Machine& machine, const Session& session,
                                const std::vector<size_t>* log_lines, MeasuringRun* run) {
  return base::Within("session '" + run->session + "'", Binder(machine, session, log_lines, run).Bind());
}

absl::Status AddReadingColumns(const machine::Machine& machine, Session* session) {
  ASSIGN_OR_RETURN(const auto paths, PathsOf(machine, *session));
  const session::Column* const runs = session::FindColumn(*session, "run");
  if (runs == nullptr) return absl::InvalidArgumentError("column 'run' is missing");
  const std::vector<std::string> names = runs->texts;
  for (int c = 0; c < 3; ++c) {
    if (session::FindColumn(*session, kColumns[c]) != nullptr) continue;
    session::Column column = {kColumns[c], {}, {}};
    for (const std::string& name : names) {
      const auto path = paths.find(name);
      column.values.push_back(path != paths.end() && Shows(machine, path->second, c) ? 0.0 : NAN);
    }
    session->columns.push_back(std::move(column));
  }
  return absl::OkStatus();
}

}  // namespace axiscal::eccentricity
