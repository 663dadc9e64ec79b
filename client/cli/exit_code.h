// What the command line's exit code means; scripts rely on it. Never renumber.
#ifndef AXISCAL_CLIENT_CLI_EXIT_CODE_H_
#define AXISCAL_CLIENT_CLI_EXIT_CODE_H_

#include "core/base/status.h"

namespace axiscal::cli {

enum ExitCode {
  kOk = 0,
  kFailed = 1,    // something went wrong that should not: INTERNAL, DATA_LOSS, UNKNOWN
  kUsage = 2,     // the command line itself is wrong
  kBadInput = 3,  // a file or value that was given is wrong
  kNotFound = 4,  // no such machine, session, job, calibration, program or file
  kRefused = 5,  // a rule forbids it: a program that cannot be compensated safely, another machine under the same id, a
                 // stale etag
  kUnreachable = 6,  // no server, too busy, out of time or space: trying again later may help
  kCancelled = 7,    // the job was cancelled
};

ExitCode ExitCodeOf(const absl::Status& status);

// The table above for --help.
inline constexpr char kExitCodeHelp[] =
    "Exit codes: 0 done, 1 failed, 2 wrong command line, 3 bad input, 4 not found, 5 refused by a rule,\n"
    "            6 not reachable, busy or out of time, 7 cancelled.";

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_EXIT_CODE_H_
