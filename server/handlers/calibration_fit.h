// The sessions of a stored calibration as they read without and with its errors.
#ifndef AXISCAL_SERVER_HANDLERS_CALIBRATION_FIT_H_
#define AXISCAL_SERVER_HANDLERS_CALIBRATION_FIT_H_

#include <Eigen/Core>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/mutex.h"
#include "core/instruments/run.h"
#include "core/machine/machine.h"
#include "core/records/session.h"
#include "server/storage/database.h"

namespace axiscal::handlers {

struct CalibrationFit {
  machine::Machine machine;                        // as it was described then
  std::vector<records::SessionRecord> sessions;    // in the calibration's order
  std::vector<instruments::MeasuringRun> runs;     // theirs
  // Per session, row_count x readings, predicted - measured, mm; set-ups fitted in both.
  std::vector<Eigen::MatrixXd> before_mm, after_mm;
  // Per session, reading * row_count + row: set aside by the fit with the errors.
  std::vector<std::vector<bool>> is_set_aside;

  int64_t readings() const;  // numbers
};

// Fits the set-ups, once with no errors of the machine and once where the calibration's act at their values. As
// Database::GetCalibration; INVALID_ARGUMENT where the errors or a session do not fit the machine as it was described
// then; CANCELLED.
absl::StatusOr<std::shared_ptr<const CalibrationFit>> FitCalibration(storage::Database& database, CalibrationId id,
                                                                     const std::function<bool()>& is_cancelled);

// The last few of them: what they are made of never changes, and whoever asks for pages asks for the same again. Safe
// from any thread.
class CalibrationFits {
 public:
  // Kept, or as FitCalibration.
  absl::StatusOr<std::shared_ptr<const CalibrationFit>> Of(storage::Database& database, CalibrationId id,
                                                           const std::function<bool()>& is_cancelled);

 private:
  using Kept = std::pair<CalibrationId, std::shared_ptr<const CalibrationFit>>;
  base::Mutex mutex_;
  std::deque<Kept> kept_ AXISCAL_GUARDED_BY(mutex_);  // the latest first
};

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_CALIBRATION_FIT_H_
