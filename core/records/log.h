// A controller's log that is to become a session, and what became of it.
#ifndef AXISCAL_CORE_RECORDS_LOG_H_
#define AXISCAL_CORE_RECORDS_LOG_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/records/program.h"
#include "core/records/session.h"

namespace axiscal::records {

// Of one log, which is held in memory while it is reduced.
inline constexpr int64_t kMaxLogBytes = int64_t{64} << 20;
inline constexpr size_t kMaxTemplateBytes = size_t{1} << 20;
inline constexpr size_t kMaxPlanBytes = size_t{2} << 20;

// How its lines are read (docs/logs.md).
struct LogForm {
  std::string template_text;                     // or the name of a known format, such as "dprnt"
  std::string template_name;                     // what errors call it; empty: "template"
  std::string plan_text;                         // the planned session that was run; empty: none
  std::string plan_name;                         // what errors call it; empty: "plan"
  std::string session;                           // its name, in place of the template's or the plan's; empty: theirs
  std::optional<double> start_s = std::nullopt;  // t_s of the first reading where the log has no times

  bool operator==(const LogForm&) const = default;
};

struct StoredLog {
  SessionRecord session;
  bool was_there = false;                 // it had been stored before
  ProgramRecord log;                      // the log, byte for byte
  std::vector<std::string> notes;         // for people: what was missing and what was filled in
  int64_t first_line = 0, last_line = 0;  // of the log, those of the first and the last reading
  std::optional<int64_t> cut_line;        // the log stopped within it
};

// The same for the same machine, name, form and bytes (by their SHA-256): the request id of a log.
std::string LogId(const std::string& machine, const std::string& name, const LogForm& form, const std::string& sha256);

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_LOG_H_
