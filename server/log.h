// The server's log: one line per event, as key=value or as JSON, for people and collectors alike.
#ifndef AXISCAL_SERVER_LOG_H_
#define AXISCAL_SERVER_LOG_H_

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/records/diagnosis.h"

namespace axiscal::server {

enum class LogFormat { kNone, kKeyValue, kJson };
using records::LogLevel;

// In order; keys are bare words.
using LogFields = std::vector<std::pair<std::string, std::string>>;

// Where lines go from now on: nowhere (until this is called; a server inside another program stays silent) or standard
// error.
void StartLog(LogFormat format);
// Lines of less are not written. kInfo until this is called. Safe from any thread.
void SetLogLevel(LogLevel level);
LogLevel GetLogLevel();
// Writes what is buffered.
void FlushLog();

// time=2026-01-31T12:00:00.123Z level=info event=call method=Jobs.CreateJob ...   Safe from any thread.
void Log(LogLevel level, const std::string& event, const LogFields& fields);

// One line without time and level, as `format` has it: for tests.
std::string FormatFields(LogFormat format, const std::string& event, const LogFields& fields);

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_LOG_H_
