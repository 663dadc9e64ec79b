// axiscald.toml and variables of any bytes: settings within their ranges, or an error with the line and nothing is
// changed.
#include "absl/strings/str_split.h"
#include "server/config.h"
#include "tests/fuzz/driver.h"

namespace axiscal::fuzz {
namespace {

void LookAt(const absl::Status& status, const server::Configured& configured) {
  if (!status.ok()) {
    MUST(absl::IsInvalidArgument(status) && configured.place.empty());
    const server::Config untouched;
    for (const server::Setting& setting : server::Settings())
      MUST(server::ValueText(setting, configured.config) == server::ValueText(setting, untouched));
    return;
  }
  for (const server::Setting& setting : server::Settings()) {
    const auto* const number = std::get_if<int64_t server::Config::*>(&setting.field);
    if (number == nullptr) continue;
    const int64_t value = configured.config.**number;
    MUST(value >= setting.least && value <= setting.most);
  }
}

}  // namespace

void Look(const std::string& bytes) {
  server::Configured by_file, by_variables;
  LookAt(server::ReadToml(bytes, "/etc/axiscal/axiscald.toml", by_file), by_file);
  const std::vector<std::string> lines = absl::StrSplit(bytes, '\n');
  LookAt(server::ReadEnvironment(lines, by_variables), by_variables);
}

}  // namespace axiscal::fuzz
