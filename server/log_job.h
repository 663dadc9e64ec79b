// How a job began, ended or was lost, into the log.
#ifndef AXISCAL_SERVER_LOG_JOB_H_
#define AXISCAL_SERVER_LOG_JOB_H_

#include "server/jobs/job_runner.h"

namespace axiscal::server {

void LogJob(const jobs::JobEvent& event);

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_LOG_JOB_H_
