// Creating a job and following it to its end.
#ifndef AXISCAL_CLIENT_CLI_JOB_WAIT_H_
#define AXISCAL_CLIENT_CLI_JOB_WAIT_H_

#include "client/cli/context.h"
#include "client/client.h"

namespace axiscal::cli {

// Watches the job with a progress bar. The job as it succeeded; else its own error (code, message, "job 12: ..."),
// CANCELLED when it was cancelled. Where its server went away for good meanwhile, the error says how to go on.
absl::StatusOr<records::JobRecord> FollowJob(const Context& context, client::Client& client, JobId id);

// What a job that ended says: OK when it succeeded.
absl::Status OutcomeOf(const records::JobRecord& record);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_JOB_WAIT_H_
