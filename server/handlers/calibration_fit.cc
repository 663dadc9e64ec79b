#include "server/handlers/calibration_fit.h"

#include <algorithm>
#include <cmath>

#include "core/identify/identify.h"
#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"
#include "server/jobs/job_sessions.h"

namespace axiscal::handlers {
namespace {

double Rms(const Eigen::MatrixXd& numbers) {
  return numbers.size() == 0 ? 0.0 : std::sqrt(numbers.squaredNorm() / static_cast<double>(numbers.size()));
}

// The set-ups fitted where the errors of `model` act at their values: what is left of the readings shows what the model
// does not explain, and no freedom of a new fit hides it.
absl::StatusOr<identify::Fit> FitSetUps(const machine::Machine& machine, std::vector<instruments::MeasuringRun> runs,
                                        const machine::ErrorModel& model, const std::function<bool()>& is_cancelled) {
  identify::Options options;
  options.model = machine::ErrorModel{};
  // Only residuals are asked for.
  options.scale_uncertainties = options.judge_correlation = options.profile_intervals = false;
  options.cancelled = is_cancelled;
  if (!model.terms.empty()) {
    ASSIGN_OR_RETURN(options.held_errors, identify::HoldErrors(model, std::nullopt, machine));
  }
  return identify::FitRuns(machine, std::move(runs), options);
}

}  // namespace

int64_t CalibrationFit::readings() const {
  int64_t numbers = 0;
  for (const Eigen::MatrixXd& residuals : after_mm) numbers += residuals.size();
  return numbers;
}

int64_t CalibrationFit::bytes() const {
  size_t bytes = 0;
  for (size_t i = 0; i < runs.size(); ++i) {
    const instruments::MeasuringRun& run = runs[i];
    size_t doubles = run.positions.size() + run.time_s.size() + run.temperature_celsius.size() +
                     run.encoder_positions.size() + run.stated_senses.size();
    for (const instruments::MeasuringRun::Channel& channel : run.temperatures) doubles += channel.celsius.size();
    for (const Eigen::MatrixXd* numbers : {&run.measured_mm, &run.stated_mm, &before_mm[i], &after_mm[i]})
      doubles += static_cast<size_t>(numbers->size());
    bytes += doubles * sizeof(double) + is_set_aside[i].size() / 8;
  }
  return static_cast<int64_t>(bytes);
}

absl::StatusOr<std::shared_ptr<const CalibrationFit>> FitCalibration(storage::Database& database, CalibrationId id,
                                                                     const std::function<bool()>& is_cancelled) {
  ASSIGN_OR_RETURN(const records::CalibrationRecord calibration, database.GetCalibration(id));
  const records::NewCalibration& content = calibration.content;
  ASSIGN_OR_RETURN(const records::MachineRecord described,
                   database.GetMachineRevision(content.machine, content.machine_revision));
  const auto fit = std::make_shared<CalibrationFit>();
  ASSIGN_OR_RETURN(fit->machine, machine::MachineFromJson(described.description_json));
  ASSIGN_OR_RETURN(fit->model, machine::ReadErrors(content.model_json, fit->machine));
  ASSIGN_OR_RETURN(jobs::MeasuredSessions measured,
                   jobs::LoadSessions(database, content.sessions, fit->machine, is_cancelled));
  ASSIGN_OR_RETURN(identify::Fit before, FitSetUps(fit->machine, measured.runs, {}, is_cancelled));
  ASSIGN_OR_RETURN(identify::Fit after, FitSetUps(fit->machine, measured.runs, fit->model, is_cancelled));
  fit->before_mm = std::move(before.residuals_mm);
  fit->after_mm = std::move(after.residuals_mm);
  for (std::vector<bool>& is_used : after.problem.is_used) {
    is_used.flip();
    fit->is_set_aside.push_back(std::move(is_used));
  }
  for (size_t i = 0; i < fit->before_mm.size(); ++i) {
    fit->rms_before_mm.push_back(Rms(fit->before_mm[i]));
    fit->rms_after_mm.push_back(Rms(fit->after_mm[i]));
  }
  fit->sessions = std::move(measured.records);
  fit->runs = std::move(measured.runs);
  for (instruments::MeasuringRun& run : fit->runs) {
    run.axis_states = {};
    run.stated = {};
    run.touches = {};
    run.history = nullptr;
  }
  return fit;
}

absl::StatusOr<std::shared_ptr<const CalibrationFit>> CalibrationFits::Of(storage::Database& database, CalibrationId id,
                                                                          const std::function<bool()>& is_cancelled) {
  {
    const base::MutexLock lock(mutex_);
    const auto found = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& kept) { return kept.first == id; });
    if (found != kept_.end()) {
      std::rotate(kept_.begin(), found, found + 1);
      return kept_.front().second;
    }
  }
  ASSIGN_OR_RETURN(std::shared_ptr<const CalibrationFit> fit, FitCalibration(database, id, is_cancelled));
  const base::MutexLock lock(mutex_);
  ++fitted_;
  // Another call may have fitted it meanwhile.
  if (std::none_of(kept_.begin(), kept_.end(), [&](const Kept& kept) { return kept.first == id; })) {
    kept_.emplace_front(id, fit);
    bytes_ += fit->bytes();
  }
  while (kept_.size() > 1 && bytes_ > most_bytes_) {
    bytes_ -= kept_.back().second->bytes();
    kept_.pop_back();
  }
  return fit;
}

int64_t CalibrationFits::bytes() const {
  const base::MutexLock lock(mutex_);
  return bytes_;
}

int64_t CalibrationFits::fitted() const {
  const base::MutexLock lock(mutex_);
  return fitted_;
}

}  // namespace axiscal::handlers
