#include "core/session/case.h"

#include <algorithm>
#include <filesystem>

#include "core/machine/machine_json.h"
#include "core/session/check_machine.h"
#include "core/session/read_session.h"

namespace axiscal::session {

std::vector<std::string> SessionFiles(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code error;
  for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (at->path().extension() == ".csv") files.push_back(at->path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

absl::StatusOr<Session> ReadSessionFileOf(const std::string& path, const machine::Machine& machine) {
  ASSIGN_OR_RETURN(Session session, ReadSessionFile(path));
  RETURN_IF_ERROR(base::Within(path, CheckAgainstMachine(session, machine)));
  return session;
}

absl::StatusOr<Case> ReadCase(const std::string& folder) {
  const std::filesystem::path root(folder);
  Case result;
  ASSIGN_OR_RETURN(result.machine, machine::ReadMachineFile((root / "machine.json").string()));
  result.fit_files = SessionFiles((root / "fit").string());
  result.check_files = SessionFiles((root / "check").string());
  if (result.fit_files.empty()) {
    return absl::InvalidArgumentError((root / "fit").string() + ": no session files, expected at least one *.csv");
  }
  for (const std::string& path : result.fit_files) {
    ASSIGN_OR_RETURN(Session session, ReadSessionFileOf(path, result.machine));
    result.fit.push_back(std::move(session));
  }
  for (const std::string& path : result.check_files) {
    ASSIGN_OR_RETURN(Session session, ReadSessionFileOf(path, result.machine));
    result.check.push_back(std::move(session));
  }
  return result;
}

}  // namespace axiscal::session
