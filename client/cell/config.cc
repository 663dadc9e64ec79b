#include "client/cell/config.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>

#include "core/base/files.h"
#include "core/base/toml.h"
#include "core/base/utf8.h"
#include "core/logs/log_template.h"
#include "core/records/log.h"
#include "core/session/read_session.h"

namespace axiscal::cell {
namespace {

namespace fs = std::filesystem;
using base::TomlValue;

absl::Status Refuse(const TomlValue& value, const std::string& rule) {
  return absl::InvalidArgumentError(absl::StrCat(value.place, ": ", value.key, " ", rule));
}

// What is read into: a text, a path, a switch, or a number with its least and largest value and what becomes of it.
using Taker = std::function<absl::Status(const TomlValue&)>;

Taker Text(std::string* to) {
  return [to](const TomlValue& value) -> absl::Status {
    const auto* const text = std::get_if<std::string>(&value.value);
    if (text == nullptr || text->empty()) return Refuse(value, "must be a text in quotes that is not empty");
    *to = *text;
    return absl::OkStatus();
  };
}

Taker Path(std::string* to, const fs::path& beside) {
  return [to, beside](const TomlValue& value) -> absl::Status {
    RETURN_IF_ERROR(Text(to)(value));
    *to = (beside / *to).string();
    return absl::OkStatus();
  };
}

Taker Switch(bool* to) {
  return [to](const TomlValue& value) -> absl::Status {
    const bool* const on = std::get_if<bool>(&value.value);
    if (on == nullptr) return Refuse(value, "must be true or false, without quotes");
    *to = *on;
    return absl::OkStatus();
  };
}

Taker Number(int64_t least, int64_t most, std::function<void(int64_t)> take) {
  return [=](const TomlValue& value) -> absl::Status {
    const int64_t* const number = std::get_if<int64_t>(&value.value);
    if (number == nullptr || *number < least || *number > most)
      return Refuse(value, absl::StrCat("must be a whole number of ", least, " to ", most, ", without quotes"));
    take(*number);
    return absl::OkStatus();
  };
}

Taker Seconds(int64_t least, std::chrono::milliseconds* to) {
  return Number(least, 86'400, [to](int64_t seconds) { *to = std::chrono::seconds(seconds); });
}

using Takers = std::map<std::string, Taker>;

Takers TakersOf(Config& config, const fs::path& beside) {
  client::Identity& identity = config.client.identity;
  return {{"server.address", Text(&config.server)},
          {"server.ca", Path(&identity.ca, beside)},
          {"server.certificate", Path(&identity.certificate, beside)},
          {"server.key", Path(&identity.key, beside)},
          {"server.token_file", Path(&identity.token_file, beside)},
          {"spool.folder", Path(&config.spool.folder, beside)},
          {"spool.max_megabytes", Number(1, 1 << 20, [&](int64_t mb) { config.spool.max_bytes = mb << 20; })},
          {"spool.max_file_megabytes", Number(1, 64, [&](int64_t mb) { config.spool.max_file_bytes = mb << 20; })},
          {"cell.name", Text(&config.name)},
          {"cell.silent_minutes", Number(1, 43'200, [&](int64_t n) { config.silent_after = std::chrono::minutes(n); })},
          {"cell.status_file", Path(&config.status_file, beside)},
          {"cell.look_seconds", Seconds(1, &config.look_every)},
          {"cell.settle_seconds", Seconds(1, &config.settle)},
          {"cell.max_wait_seconds", Seconds(1, &config.last_wait)}};
}

Takers TakersOf(Watch& watch, const fs::path& beside) {
  return {{"folder", Path(&watch.folder, beside)}, {"files", Text(&watch.files)},
          {"machine", Text(&watch.machine)},       {"template", Text(&watch.log_template)},
          {"plan", Path(&watch.plan, beside)},     {"end_line", Text(&watch.end_line)},
          {"remove_sent", Switch(&watch.removes)}};
}

absl::Status Take(const Takers& takers, const std::string& key, const TomlValue& value) {
  const auto found = takers.find(key);
  if (found != takers.end()) return found->second(value);
  std::string known;
  for (const auto& [name, taker] : takers) absl::StrAppend(&known, known.empty() ? "" : ", ", name);
  return Refuse(value, "is no key; known are " + known);
}

constexpr size_t kMaxNameBytes = 64;

std::string HostName() {
  char name[kMaxNameBytes + 1] = {};
  return gethostname(name, kMaxNameBytes) == 0 && name[0] != '\0' ? name : "cell";
}

bool IsKnownFormat(const std::string& name) {
  const std::vector<std::string>& known = logs::KnownFormats();
  return std::find(known.begin(), known.end(), name) != known.end();
}

absl::Status Check(const Watch& watch) {
  const auto refuse = [&](const std::string& text) {
    return absl::InvalidArgumentError(absl::StrCat(watch.place, ": watch: ", text));
  };
  if (watch.folder.empty()) return refuse("folder is missing");
  if (watch.log_template.empty() && !watch.plan.empty()) return refuse("plan needs template");
  if (!watch.log_template.empty() && watch.machine.empty())
    return refuse("template needs machine: whose logs are these?");
  // A wrong template would refuse every log, one by one.
  return base::Within(watch.place, ItemOf(watch, "x").status());
}

absl::Status Check(const Config& config, const std::string& path) {
  const auto refuse = [&](const std::string& text) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": ", text));
  };
  if (config.server.empty()) return refuse("server.address is missing");
  if (config.spool.folder.empty()) return refuse("spool.folder is missing");
  if (config.watches.empty()) return refuse("[[watch]] is missing: which folders are looked through?");
  if (config.spool.max_file_bytes > config.spool.max_bytes)
    return refuse("spool.max_file_megabytes is more than spool.max_megabytes");
  if (config.name.size() > kMaxNameBytes || !base::IsUtf8(config.name))
    return refuse(absl::StrCat("cell.name must have at most ", kMaxNameBytes, " bytes of UTF-8"));
  RETURN_IF_ERROR(base::Within(path, client::Validate(config.client)));
  for (const Watch& watch : config.watches) RETURN_IF_ERROR(Check(watch));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Config> ReadConfig(const std::string& text, const std::string& path) {
  ASSIGN_OR_RETURN(const std::vector<TomlValue> values, base::ReadTomlValues(text, path));
  Config config;
  config.spool.max_file_bytes = int64_t{8} << 20;
  const fs::path beside = fs::path(path).parent_path();
  const Takers takers = TakersOf(config, beside);
  for (const TomlValue& value : values) {
    const bool is_table = std::holds_alternative<base::TomlTable>(value.value);
    const bool is_top = value.key.find('.') == std::string::npos;
    if (is_table && (value.key == "server" || value.key == "spool" || value.key == "cell")) continue;
    if (value.key == "watch") {
      if (!std::holds_alternative<base::TomlTables>(value.value)) return Refuse(value, "must be [[watch]]");
    } else if (value.key.rfind("watch[", 0) == 0) {
      if (is_top) {
        config.watches.emplace_back().place = value.place;
        continue;
      }
      Watch& watch = config.watches.back();
      RETURN_IF_ERROR(Take(TakersOf(watch, beside), value.key.substr(value.key.find('.') + 1), value));
      const bool is_file = watch.log_template.find('/') != std::string::npos || !IsKnownFormat(watch.log_template);
      if (value.key.ends_with(".template") && is_file) watch.log_template = (beside / watch.log_template).string();
    } else {
      RETURN_IF_ERROR(Take(takers, value.key, value));
    }
  }
  if (config.name.empty()) config.name = HostName();
  // The log of the server takes printable ASCII.
  config.client.user = std::all_of(config.name.begin(), config.name.end(), [](char c) { return c >= 0x20 && c < 0x7f; })
                           ? config.name
                           : "cell";
  // The queue is the spool: a call that fails is tried again from there.
  config.client.connect_deadline = std::chrono::milliseconds(0);
  config.client.give_up_after = std::chrono::seconds(10);
  RETURN_IF_ERROR(Check(config, path));
  if (config.status_file.empty()) config.status_file = config.spool.folder + "/status.json";
  return config;
}

std::string NameOf(const std::string& path) {
  const std::string bytes = fs::path(path).filename().string();
  std::string name;
  for (size_t at = 0; at < bytes.size();) {
    const auto byte = static_cast<unsigned char>(bytes[at]);
    const bool is_control = byte < 0x20 || byte == 0x7f;
    const size_t count = is_control ? 0 : base::Utf8Bytes(bytes, at);
    absl::StrAppend(
        &name, count > 0 ? bytes.substr(at, count) : absl::StrFormat("%%%02X", byte));
    at += std::max<size_t>(count, 1);
  }
  return name;
}

absl::StatusOr<spool::Item> ItemOf(const Watch& watch, const std::string& file) {
  spool::Item item;
  item.machine = watch.machine;
  item.name = NameOf(file);
  item.source = file;
  item.removes_source = watch.removes;
  item.is_log = !watch.log_template.empty();
  if (!item.is_log) return item;
  if (IsKnownFormat(watch.log_template)) {
    item.form.template_text = watch.log_template;
  } else {
    ASSIGN_OR_RETURN(item.form.template_text, base::ReadFile(watch.log_template, records::kMaxTemplateBytes));
    item.form.template_name = fs::path(watch.log_template).filename().string();
    RETURN_IF_ERROR(logs::ReadTemplate(item.form.template_text, watch.log_template).status());
  }
  if (watch.plan.empty()) return item;
  ASSIGN_OR_RETURN(item.form.plan_text, base::ReadFile(watch.plan, records::kMaxPlanBytes));
  item.form.plan_name = fs::path(watch.plan).filename().string();
  RETURN_IF_ERROR(session::ReadPlanText(item.form.plan_text, watch.plan).status());
  return item;
}

}  // namespace axiscal::cell
