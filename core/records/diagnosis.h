// What a look at a running service finds (`axiscal doctor`), and how much it writes to its log.
#ifndef AXISCAL_CORE_RECORDS_DIAGNOSIS_H_
#define AXISCAL_CORE_RECORDS_DIAGNOSIS_H_

#include <optional>
#include <string>
#include <utility>

namespace axiscal::records {

// Never renumber.
enum class FindingState {
  kOk = 1,
  kWarning = 2,  // it works, and will not for long, or not as it should
  kFailed = 3,   // it does not work
  kUnknown = 4,  // could not be found out
};

// One thing that was looked at.
struct Finding {
  std::string what;  // "disk", "last backup"
  FindingState state = FindingState::kOk;
  std::string text;    // how it is
  std::string advice;  // what to do; empty where it is well
};

// Never renumber.
enum class LogLevel { kDebug = 1, kInfo = 2, kWarning = 3, kError = 4 };
inline constexpr std::pair<const char*, LogLevel> kLogLevels[] = {{"debug", LogLevel::kDebug},
                                                                  {"info", LogLevel::kInfo},
                                                                  {"warning", LogLevel::kWarning},
                                                                  {"error", LogLevel::kError}};
inline std::optional<LogLevel> LogLevelNamed(const std::string& name) {
  for (const auto& [known, level] : kLogLevels) {
    if (name == known) return level;
  }
  return std::nullopt;
}
inline std::string NameOf(LogLevel level) { return kLogLevels[static_cast<int>(level) - 1].first; }

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_DIAGNOSIS_H_
