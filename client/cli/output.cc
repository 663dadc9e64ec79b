#include "client/cli/output.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

namespace axiscal::cli {
namespace {

bool IsNumberCell(const std::string& cell) {
  return !cell.empty() && (std::isdigit(static_cast<unsigned char>(cell.back())) || cell == "-") &&
         cell.find_first_not_of("+-.0123456789e") == std::string::npos;
}

// Columns on the screen: bytes that do not continue a UTF-8 character.
size_t Width(const std::string& text) {
  return std::count_if(text.begin(), text.end(), [](unsigned char c) { return (c & 0xC0) != 0x80; });
}

std::tm BrokenDown(base::UtcTime time) {
  const std::time_t seconds = std::chrono::floor<std::chrono::seconds>(time.time_since_epoch()).count();
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  return parts;
}

std::string Format(base::UtcTime time, const char* format) {
  const std::tm parts = BrokenDown(time);
  char text[64];
  return std::string(text, std::strftime(text, sizeof(text), format, &parts));
}

}  // namespace

std::string Table(const std::vector<std::vector<std::string>>& rows) {
  std::vector<size_t> widths;
  std::vector<bool> is_number;
  for (size_t r = 0; r < rows.size(); ++r) {
    for (size_t c = 0; c < rows[r].size(); ++c) {
      if (c >= widths.size()) {
        widths.push_back(0);
        is_number.push_back(rows.size() > 1);
      }
      widths[c] = std::max(widths[c], Width(rows[r][c]));
      if (r > 0 && !rows[r][c].empty() && !IsNumberCell(rows[r][c])) is_number[c] = false;
    }
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (size_t c = 0; c < row.size(); ++c) {
      const std::string blanks(widths[c] - Width(row[c]), ' ');
      line += (c == 0 ? "" : "  ") + (is_number[c] ? blanks + row[c] : row[c] + blanks);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string TimeText(base::UtcTime time) { return Format(time, "%Y-%m-%d %H:%M:%S"); }

std::string TimeText(const std::optional<base::UtcTime>& time) { return time ? TimeText(*time) : "-"; }

Json TimeJson(const std::optional<base::UtcTime>& time) {
  if (!time) return nullptr;
  const int64_t us = ((base::ToUtcUs(*time) % 1000000) + 1000000) % 1000000;
  return Format(*time, "%Y-%m-%dT%H:%M:%S") + absl::StrFormat(".%06dZ", us);
}

absl::StatusOr<base::UtcTime> ParseTime(const std::string& option, const std::string& text) {
  std::tm parts{};
  const char* end = strptime(text.c_str(), "%Y-%m-%d", &parts);
  if (end != nullptr && (*end == 'T' || *end == ' ')) end = strptime(end + 1, "%H:%M:%S", &parts);
  if (end != nullptr && *end == 'Z') ++end;
  if (end == nullptr || *end != '\0') {
    return absl::InvalidArgumentError(
        absl::StrCat(option, ": '", text, "', expected a UTC time: 2026-05-31 or 2026-05-31T14:03:07"));
  }
  const int day = parts.tm_mday;
  const base::UtcTime time{std::chrono::seconds(timegm(&parts))};
  if (parts.tm_mday != day)  // 31 February was made a day in March
    return absl::InvalidArgumentError(absl::StrCat(option, ": '", text, "', that month has no such day"));
  return time;
}

absl::StatusOr<records::TimeSpan> ParseSpan(const std::string& from, const std::string& to) {
  records::TimeSpan span;
  if (!from.empty()) {
    ASSIGN_OR_RETURN(span.from, ParseTime("--from", from));
  }
  if (!to.empty()) {
    ASSIGN_OR_RETURN(span.to, ParseTime("--to", to));
  }
  if (span.from && span.to && *span.from >= *span.to)
    return absl::InvalidArgumentError(absl::StrCat("--from: '", from, "', must be before --to '", to, "'"));
  return span;
}

Json NumberJson(const std::optional<double>& number) {
  if (!number || !std::isfinite(*number)) return nullptr;
  return *number;
}

ProgressBar::ProgressBar(std::string what, bool enabled)
    : what_(std::move(what)), enabled_(enabled && isatty(STDERR_FILENO) != 0) {}

ProgressBar::~ProgressBar() {
  if (drawn_) std::fprintf(stderr, "\r\033[K");
}

void ProgressBar::Show(double fraction, const std::string& detail) {
  if (!enabled_) return;
  const auto now = std::chrono::steady_clock::now();
  if (drawn_ && now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  drawn_ = true;
  constexpr int kWidth = 30;
  const int full = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * kWidth);
  std::fprintf(stderr, "\r\033[K%s [%s%s] %3.0f %% %s", what_.c_str(), std::string(full, '#').c_str(),
               std::string(kWidth - full, ' ').c_str(), 100 * fraction, detail.c_str());
  std::fflush(stderr);
}

}  // namespace axiscal::cli
