// A calibration case (docs/formats.md): a folder with machine.json, fit/*.csv to identify from and check/*.csv that are
// never used to fit errors. truth.json, which simulated cases carry, is never read.
#ifndef AXISCAL_CORE_SESSION_CASE_H_
#define AXISCAL_CORE_SESSION_CASE_H_

#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/machine/machine.h"
#include "core/session/session.h"

namespace axiscal::session {

struct Case {
  machine::Machine machine;
  std::vector<Session> fit, check;                  // in the order of their file names
  std::vector<std::string> fit_files, check_files;  // paths, the same order
};

// Every session was checked against the machine. INVALID_ARGUMENT or NOT_FOUND naming the file; a case without check
// files is a case.
absl::StatusOr<Case> ReadCase(const std::string& folder);

// The *.csv of a folder in name order; empty when there is no such folder.
std::vector<std::string> SessionFiles(const std::string& folder);

// A session file checked against its machine.
absl::StatusOr<Session> ReadSessionFileOf(const std::string& path, const machine::Machine& machine);

}  // namespace axiscal::session

#endif  // AXISCAL_CORE_SESSION_CASE_H_
