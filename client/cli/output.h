// What the command line prints: plain tables for people, one JSON document with --json for programs, progress bars on
// terminals only.
#ifndef AXISCAL_CLIENT_CLI_OUTPUT_H_
#define AXISCAL_CLIENT_CLI_OUTPUT_H_

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/json.h"
#include "core/base/clock.h"
#include "core/base/number_text.h"
#include "core/base/status.h"
#include "core/records/page.h"

namespace axiscal::cli {

// Rows of cells, the first row being the heading; columns are as wide as they need. Numbers stand to the right.
std::string Table(const std::vector<std::vector<std::string>>& rows);

// "2026-05-31 14:03:07" (UTC), or "-".
std::string TimeText(base::UtcTime time);
std::string TimeText(const std::optional<base::UtcTime>& time);
// ISO 8601 with microseconds: "2026-05-31T14:03:07.000000Z", null without.
Json TimeJson(const std::optional<base::UtcTime>& time);
// "2026-05-31" or "2026-05-31T14:03:07[Z]" (UTC). INVALID_ARGUMENT naming `option` otherwise.
absl::StatusOr<base::UtcTime> ParseTime(const std::string& option, const std::string& text);
// Of --from and --to; an empty one holds nothing off.
absl::StatusOr<records::TimeSpan> ParseSpan(const std::string& from, const std::string& to);

using base::NumberText;
// Null without.
Json NumberJson(const std::optional<double>& number);

// A bar on standard error that is drawn at most ten times a second, only when standard error is a terminal, and wiped
// by the destructor.
class ProgressBar {
 public:
  // `enabled` false: nothing is ever drawn.
  ProgressBar(std::string what, bool enabled);
  ~ProgressBar();
  void Show(double fraction, const std::string& detail);

 private:
  const std::string what_;
  const bool enabled_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_OUTPUT_H_
