#include "server/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <nlohmann/json.hpp>

namespace axiscal::server {
namespace {

std::atomic<LogFormat> g_format = LogFormat::kNone;
std::atomic<LogLevel> g_level = LogLevel::kInfo;

spdlog::level::level_enum SpdlogLevel(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::level::debug;
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarning:
      return spdlog::level::warn;
    case LogLevel::kError:
      return spdlog::level::err;
  }
  return spdlog::level::info;
}

bool NeedsQuotes(const std::string& text) {
  return text.empty() || text.find_first_of(" =\"\\") != std::string::npos ||
         std::any_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
}

std::string Json(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

std::string FormatFields(LogFormat format, const std::string& event, const LogFields& fields) {
  const bool is_json = format == LogFormat::kJson;
  std::string line = is_json ? "\"event\":" + Json(event) : "event=" + event;
  for (const auto& [key, value] : fields) {
    line +=
        is_json ? "," + Json(key) + ":" + Json(value) : " " + key + "=" + (NeedsQuotes(value) ? Json(value) : value);
  }
  return line;
}

void StartLog(LogFormat format) {
  g_format = format;
  if (format == LogFormat::kNone) return;
  auto logger = spdlog::stderr_logger_mt("axiscald");
  logger->set_pattern(format == LogFormat::kJson ? R"({"time":"%Y-%m-%dT%H:%M:%S.%eZ","level":"%l",%v})"
                                                 : "time=%Y-%m-%dT%H:%M:%S.%eZ level=%l %v",
                      spdlog::pattern_time_type::utc);
  // Which lines are written is decided here, not by the library.
  logger->set_level(spdlog::level::debug);
  logger->flush_on(spdlog::level::debug);
  spdlog::set_default_logger(std::move(logger));
}

void SetLogLevel(LogLevel level) { g_level = level; }
LogLevel GetLogLevel() { return g_level; }

void FlushLog() {
  if (g_format != LogFormat::kNone) spdlog::default_logger()->flush();
}

void Log(LogLevel level, const std::string& event, const LogFields& fields) {
  const LogFormat format = g_format;
  if (format == LogFormat::kNone || level < g_level) return;
  spdlog::default_logger()->log(SpdlogLevel(level), "{}", FormatFields(format, event, fields));
}

}  // namespace axiscal::server
