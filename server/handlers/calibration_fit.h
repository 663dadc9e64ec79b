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
  machine::Machine machine;                      // as it was described then
  machine::ErrorModel model;                     // the calibration's errors
  std::vector<records::SessionRecord> sessions;  // in the calibration's order
  std::vector<instruments::MeasuringRun> runs;   // theirs, without motions, touches and stated facts
  // Per session, row_count x readings, predicted - measured, mm; set-ups fitted in both.
  std::vector<Eigen::MatrixXd> before_mm, after_mm;
  // Root mean square of a session's numbers in them, mm.
  std::vector<double> rms_before_mm, rms_after_mm;
  // Per session, reading * row_count + row: set aside by the fit with the errors.
  std::vector<std::vector<bool>> is_set_aside;

  int64_t readings() const;  // numbers
  int64_t bytes() const;     // of all that grows with the readings: some 80 for a number of a five-axis machine
};

// Fits the set-ups, once with no errors of the machine and once where the calibration's act at their values. As
// Database::GetCalibration; INVALID_ARGUMENT where the errors or a session do not fit the machine as it was described
// then; CANCELLED.
absl::StatusOr<std::shared_ptr<const CalibrationFit>> FitCalibration(storage::Database& database, CalibrationId id,
                                                                     const std::function<bool()>& is_cancelled);

// The last few of them: what they are made of never changes, and whoever asks for pages asks for the same again. The
// last one stays whatever its size, so that the pages of a large one are read off one fit too; it takes a fraction of
// what fitting it took. Others beside it only as long as all together take no more than `most_bytes`. Safe from any
// thread.
class CalibrationFits {
 public:
  explicit CalibrationFits(int64_t most_bytes = int64_t{256} << 20) : most_bytes_(most_bytes) {}

  // Kept, or as FitCalibration.
  absl::StatusOr<std::shared_ptr<const CalibrationFit>> Of(storage::Database& database, CalibrationId id,
                                                           const std::function<bool()>& is_cancelled);
  int64_t bytes() const;   // of those that are kept
  int64_t fitted() const;  // how many were fitted so far, because they were not kept

 private:
  using Kept = std::pair<CalibrationId, std::shared_ptr<const CalibrationFit>>;
  const int64_t most_bytes_;
  mutable base::Mutex mutex_;
  std::deque<Kept> kept_ AXISCAL_GUARDED_BY(mutex_);  // the latest first
  int64_t bytes_ AXISCAL_GUARDED_BY(mutex_) = 0;
  int64_t fitted_ AXISCAL_GUARDED_BY(mutex_) = 0;
};

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_CALIBRATION_FIT_H_
