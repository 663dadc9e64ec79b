// The readings that a session's instrument would give on a machine with known errors.
#ifndef AXISCAL_CORE_PREDICT_READINGS_H_
#define AXISCAL_CORE_PREDICT_READINGS_H_

#include <functional>
#include <string>

#include "core/predict/tool_point.h"
#include "core/session/session.h"

namespace axiscal::predict {

// Readings of one session, a line per line of data.
struct PredictedReadings {
  std::vector<std::string> columns;  // "dL_mm", "ex_um" ...; of touches "gap_mm"
  // lines x columns, in the columns' units; NaN where the session has no such reading. `sigma` is empty without a
  // covariance; it is that of the errors alone, without the noise of a reading.
  Eigen::MatrixXd predicted, sigma;
};

// The set-up is as its header states it: every set-up offset is zero (a tracker's frame is where its readings lie best
// on the nominal tool points; the machine's frame for a plan, which has none). A plan's readings may be missing.
// INVALID_ARGUMENT as instruments::BindSession, and as RequireState().
absl::StatusOr<PredictedReadings> PredictReadings(session::Session session, const machine::Machine& machine,
                                                  const machine::KnownErrors& errors,
                                                  const std::function<void(double fraction)>& progress = {});

// A line of column names (the columns, then NAME_sigma_UNIT of each), then a line per line of data; empty cells where
// there is nothing.
std::string ToCsv(const PredictedReadings& readings);

}  // namespace axiscal::predict

#endif  // AXISCAL_CORE_PREDICT_READINGS_H_
