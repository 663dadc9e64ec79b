// A fit's result as the candidate calibration that the store keeps.
#ifndef AXISCAL_SERVER_JOBS_NEW_CALIBRATION_H_
#define AXISCAL_SERVER_JOBS_NEW_CALIBRATION_H_

#include "core/identify/result.h"
#include "server/jobs/job_sessions.h"

namespace axiscal::jobs {

// All but options_json and report_json, which say how it was asked and what came out. `fit` are the sessions that
// `result` was fitted to, `before` how they fit without what it found.
records::NewCalibration MakeCalibration(const MachineInput& input, const MeasuredSessions& fit,
                                        const identify::FitStatistics& before, const identify::Result& result,
                                        const records::JobRecord& job);

}  // namespace axiscal::jobs

#endif  // AXISCAL_SERVER_JOBS_NEW_CALIBRATION_H_
