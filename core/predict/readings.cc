#include "core/predict/readings.h"

#include <cmath>
#include <limits>

#include "core/base/units.h"
#include "core/instruments/eccentricity/eccentricity_bind.h"
#include "core/instruments/evaluation.h"
#include "core/instruments/registry.h"
#include "core/predict/number_cells.h"
#include "core/session/instrument_format.h"

namespace axiscal::predict {
namespace {

using instruments::MeasuringRun;

// Reading columns of a plan hold nothing yet; what is predicted does not depend on them. True where any was added.
absl::StatusOr<bool> AddMissingReadings(const machine::Machine& machine, session::Session* session) {
  const size_t before = session->columns.size();
  const std::optional<std::string> name = session::FindHeader(*session, "instrument");
  if (name == "eccentricity") RETURN_IF_ERROR(eccentricity::AddReadingColumns(machine, session));
  const session::InstrumentFormat* const format = name ? session::FindInstrumentFormat(*name) : nullptr;
  for (size_t i = 0; format != nullptr && i < format->columns.size(); ++i) {
    const session::ReadingColumn& column = format->columns[i];
    if (column.is_name || session::FindColumn(*session, column.name) != nullptr) continue;
    session->columns.push_back({column.name, std::vector<double>(session->reading_count(), 0.0), {}});
  }
  return session->columns.size() > before;
}

// Where a reading of the run stands in the session's lines and columns.
struct Cell {
  Eigen::Index line = 0, column = 0;
};

class Predictor {
 public:
  Predictor(const machine::Machine& machine, const machine::KnownErrors& errors, const MeasuringRun& run)
      : machine_(machine),
        errors_(errors),
        run_(run),
        propagation_(errors.model, errors.covariance),
        setup_(run.setup.size(), 0.0) {}

  PredictedReadings Predict(size_t lines, const std::function<void(double)>& progress) {
    made_.columns = instruments::ReadingNames(run_);
    const auto columns = static_cast<Eigen::Index>(made_.columns.size());
    made_.predicted.setConstant(static_cast<Eigen::Index>(lines), columns, std::numeric_limits<double>::quiet_NaN());
    if (!errors_.covariance.is_empty()) made_.sigma = made_.predicted;
    constexpr int kReport = 256;
    for (int k = 0; k < run_.reading_count(); ++k) {
      One(k);
      if (progress && k % kReport == 0) progress(static_cast<double>(k) / run_.reading_count());
    }
    return std::move(made_);
  }

 private:
  void One(int k) {
    const auto errors_at = [this](const shapes::State& state) {
      return machine::ErrorsAt(machine_, errors_.model, state);
    };
    if (run_.path_readings == nullptr) {
      const shapes::State state = run_.StateOf(k);
      instruments::Evaluate(machine_, run_, k, errors_at(state), setup_.data(), &evaluation_);
      propagation_.ByNumber(state, evaluation_.by_error, &by_number_);
      unknown_ = propagation_.UnknownVariance(state, evaluation_.by_error);
      for (int row = 0; row < run_.row_count; ++row) Set(row, {k, row}, 1.0);
      return;
    }
    Eigen::MatrixXd along_path;
    instruments::EvaluateAlongPath(machine_, run_, k, errors_at, setup_.data(), &evaluation_,
                                   [&](const shapes::State& state, const instruments::Evaluation& one, double weight) {
                                     propagation_.ByNumber(state, one.by_error, &by_number_);
                                     if (along_path.size() == 0)
                                       along_path.setZero(by_number_.rows(), by_number_.cols());
                                     along_path += weight * by_number_;
                                   });
    by_number_ = along_path;
    unknown_.setZero(1);  // a path has no time, and no position where nothing was measured before
    const eccentricity::Reading& reading = run_.path_readings->readings[k];
    Set(0, {reading.row, reading.component}, base::kUmPerMm);
  }

  void Set(int row, const Cell& cell, double unit_per_mm) {
    made_.predicted(cell.line, cell.column) = evaluation_.predicted_mm[row] * unit_per_mm;
    if (made_.sigma.size() == 0) return;
    made_.sigma(cell.line, cell.column) =
        std::hypot(propagation_.Sigma(by_number_.row(row))[0], std::sqrt(unknown_[row])) * unit_per_mm;
  }

  const machine::Machine& machine_;
  const machine::KnownErrors& errors_;
  const MeasuringRun& run_;
  const Propagation propagation_;
  const std::vector<double> setup_;
  instruments::Evaluation evaluation_;
  Eigen::MatrixXd by_number_;
  Eigen::VectorXd unknown_;
  PredictedReadings made_;
};

}  // namespace

absl::StatusOr<PredictedReadings> PredictReadings(session::Session session, const machine::Machine& machine,
                                                  const machine::KnownErrors& errors,
                                                  const std::function<void(double fraction)>& progress) {
  const size_t lines = session.reading_count();
  ASSIGN_OR_RETURN(const bool is_plan, AddMissingReadings(machine, &session));
  ASSIGN_OR_RETURN(MeasuringRun run, instruments::BindSession(session, machine));
  if (is_plan) {
    run.tracker_from_machine = {};
    run.length.zero_mm = 0.0;
  }
  const bool has_path = run.path_readings != nullptr;
  std::vector<std::string> channels = instruments::TemperatureColumns(run);
  if (has_path) channels.push_back(shapes::kTemperatureChannel);
  RETURN_IF_ERROR(base::Within(absl::StrCat("session '", run.session, "'"),
                               RequireState(machine, errors.model, run.has_time || has_path, channels)));
  std::vector<MeasuringRun> alone = {std::move(run)};
  instruments::ShareTemperatures({&alone});
  return Predictor(machine, errors, alone.front()).Predict(lines, progress);
}

std::string ToCsv(const PredictedReadings& readings) {
  std::string names, sigmas, text;
  for (const std::string& column : readings.columns) {
    const size_t unit = column.rfind('_');
    absl::StrAppend(&names, names.empty() ? "" : ",", column);
    absl::StrAppend(&sigmas, ",", column.substr(0, unit), "_sigma", column.substr(unit));
  }
  text = names + sigmas + "\n";
  for (Eigen::Index line = 0; line < readings.predicted.rows(); ++line) {
    for (const bool is_sigma : {false, true}) {
      const Eigen::MatrixXd& values = is_sigma ? readings.sigma : readings.predicted;
      for (Eigen::Index i = 0; i < readings.predicted.cols(); ++i) {
        if (is_sigma || i > 0) text.push_back(',');
        const bool is_um = readings.columns[static_cast<size_t>(i)].ends_with("_um");
        if (values.size() > 0 && std::isfinite(values(line, i))) AppendCell(values(line, i), is_um ? 6 : 9, &text);
      }
    }
    text.push_back('\n');
  }
  return text;
}

}  // namespace axiscal::predict
