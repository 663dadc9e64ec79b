// How a controller's log becomes a session: the session's header lines, then rules (docs/logs.md).
//   # machine: mt                          header lines of the session, copied
//   ...
//   line: X{X_mm} Y{Y_mm} Z{Z_mm} B{B_deg} C{C_deg}
//   skip: Feature Model {*}
//   count: Number of Points {count}
//   feature: ball
//   approach: feature
#ifndef AXISCAL_CORE_LOGS_LOG_TEMPLATE_H_
#define AXISCAL_CORE_LOGS_LOG_TEMPLATE_H_

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/logs/line_pattern.h"
#include "core/session/session.h"

namespace axiscal::logs {

// value = scale * logged + offset, in the column's unit: work offsets, inches (25.4), diameters (0.5), metres (1000).
struct ColumnScale {
  double scale = 1.0, offset = 0.0;
};

// Formats that are known by name; their lines follow from the machine's axes. DPRNT also has "Number of Points N" and
// "Feature Model ...".
enum class KnownFormat { kNone, kDprnt, kLinuxCncProbe, kSinumerikWrite };

struct LogTemplate {
  std::string name;  // for messages
  std::vector<session::HeaderEntry> header;
  KnownFormat format = KnownFormat::kNone;
  std::optional<LinePattern> line;                // one reading
  std::vector<LinePattern> skip;                  // lines that say nothing
  std::optional<LinePattern> count;               // field {count}: how many readings follow
  std::optional<LinePattern> mark;                // field {feature}: what the following touches are of
  std::map<std::string, ColumnScale> scales;      // by the name of an axis, or of a column ("px_mm", "temp_C")
  char decimal = '.';                             // of all its numbers: '.' or ','
  std::string time;                               // form of {t_s} as absl::ParseTime() has it; empty: seconds
  std::string feature;                            // of every touch where neither line nor mark says
  bool approach_is_feature = false;               // along the feature's inward normal on the nominal machine
  std::optional<std::array<double, 3>> approach;  // or one direction for all, machine axes
  double seconds = 1.0;                           // from reading to reading, where the log has no times
};

// "dprnt", "linuxcnc-probe", "sinumerik-write".
const std::vector<std::string>& KnownFormats();

// The template in `text`, or the known format of that name (no header: a plan brings it). INVALID_ARGUMENT with line
// and rule: an unknown rule, a rule said twice, a pattern that cannot be, a header of no session.
absl::StatusOr<LogTemplate> ParseTemplate(const std::string& text, const std::string& name);
absl::StatusOr<LogTemplate> FindFormat(const std::string& name);
// Either, by what the text is.
absl::StatusOr<LogTemplate> ReadTemplate(const std::string& text, const std::string& name);

}  // namespace axiscal::logs

#endif  // AXISCAL_CORE_LOGS_LOG_TEMPLATE_H_
