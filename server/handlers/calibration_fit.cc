#include "server/handlers/calibration_fit.h"

#include <algorithm>

#include "core/identify/identify.h"
#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"
#include "server/jobs/job_sessions.h"

namespace axiscal::handlers {
namespace {

constexpr size_t kKept = 4;
// Numbers of one that is kept: with what belongs to them about 100 MB.
constexpr int64_t kMaxKeptReadings = 1'000'000;

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

absl::StatusOr<std::shared_ptr<const CalibrationFit>> FitCalibration(storage::Database& database, CalibrationId id,
                                                                     const std::function<bool()>& is_cancelled) {
  ASSIGN_OR_RETURN(const records::CalibrationRecord calibration, database.GetCalibration(id));
  const records::NewCalibration& content = calibration.content;
  ASSIGN_OR_RETURN(const records::MachineRecord described,
                   database.GetMachineRevision(content.machine, content.machine_revision));
  const auto fit = std::make_shared<CalibrationFit>();
  ASSIGN_OR_RETURN(fit->machine, machine::MachineFromJson(described.description_json));
  ASSIGN_OR_RETURN(const machine::ErrorModel model, machine::ReadErrors(content.model_json, fit->machine));
  ASSIGN_OR_RETURN(jobs::MeasuredSessions measured,
                   jobs::LoadSessions(database, content.sessions, fit->machine, is_cancelled));
  ASSIGN_OR_RETURN(identify::Fit before, FitSetUps(fit->machine, measured.runs, {}, is_cancelled));
  ASSIGN_OR_RETURN(identify::Fit after, FitSetUps(fit->machine, measured.runs, model, is_cancelled));
  fit->before_mm = std::move(before.residuals_mm);
  fit->after_mm = std::move(after.residuals_mm);
  for (std::vector<bool>& is_used : after.problem.is_used) {
    is_used.flip();
    fit->is_set_aside.push_back(std::move(is_used));
  }
  fit->sessions = std::move(measured.records);
  fit->runs = std::move(measured.runs);
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
  if (fit->readings() <= kMaxKeptReadings) {
    const base::MutexLock lock(mutex_);
    kept_.emplace_front(id, fit);
    if (kept_.size() > kKept) kept_.pop_back();
  }
  return fit;
}

}  // namespace axiscal::handlers
