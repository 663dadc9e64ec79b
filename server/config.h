// The server's configuration: one table of settings for axiscald.toml, the environment and the command line
// (docs/configuration.md). A later one of the three overrides an earlier one.
#ifndef AXISCAL_SERVER_CONFIG_H_
#define AXISCAL_SERVER_CONFIG_H_

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/base/status.h"
#include "server/certificates.h"
#include "server/webhooks/mail_server.h"

namespace axiscal::server {

// What can be set, with the values of a server that nobody configured.
struct Config {
  std::string database;
  std::string listen = "127.0.0.1:7410";
  std::string http;  // empty: not by HTTP
  int64_t drain_seconds = 20;
  bool asks_identity = false;
  std::string tls_certificate, tls_key, tls_client_ca;
  int64_t workers = 2;
  int64_t max_uploads = 500;
  int64_t streams_per_principal = 100;
  int64_t calls_per_second = 1000;
  int64_t jobs_per_principal = 200, jobs_per_machine = 500;
  int64_t session_readings = 50'000'000;
  int64_t program_bytes = int64_t{1} << 30;
  int64_t window_bytes = 1 << 20;
  int64_t waiting_bytes = int64_t{512} << 20;
  int64_t silence_seconds = 300;
  int64_t idle_seconds = 300;
  std::string webhooks_allowed, webhooks_ca;
  std::string mail_server, mail_from, mail_user, mail_password_file, mail_ca;
  bool mail_without_tls = false;
  std::string backup_folder;
  int64_t keep_readings_days = 0;
  int64_t keep_audit_days = 0;
  int64_t metrics_machines = 0;
  bool log_json = false;
  std::string log_level = "info";
};

struct Setting {
  std::string key;   // table and name as the file has them: "server.listen"
  std::string flag;  // "--listen"
  std::string meaning;
  std::variant<std::string Config::*, int64_t Config::*, bool Config::*> field;
  // Of a number: the least and the largest one.
  int64_t least = 0, most = 0;
  // A file: a relative one in axiscald.toml is looked for beside axiscald.toml. A URL of PostgreSQL stays as it is.
  bool is_path = false;

  bool is_switch() const { return std::holds_alternative<bool Config::*>(field); }
};

// In the order of the documentation.
const std::vector<Setting>& Settings();
// "AXISCALD_LISTEN".
std::string EnvironmentName(const Setting& setting);
// What `config` has there, as text.
std::string ValueText(const Setting& setting, const Config& config);

// The values, and where those stand that are not the defaults: by key, "axiscald.toml:4", "AXISCALD_LISTEN",
// "--listen".
struct Configured {
  Config config;
  std::map<std::string, std::string> place;
};

TlsFiles TlsFilesOf(const Config& config);
// Nothing where mail.server is not set.
std::optional<webhooks::MailServer> MailOf(const Config& config);

// All of the following refuse with INVALID_ARGUMENT that names place, key, value and rule, and change nothing then.

// The text of an axiscald.toml; `path` is for messages and relative files.
absl::Status ReadToml(const std::string& text, const std::string& path, Configured& configured);
// `variables`: "NAME=VALUE". Those that begin with AXISCALD_ must be settings; AXISCALD_CONFIG is not looked at.
absl::Status ReadEnvironment(const std::vector<std::string>& variables, Configured& configured);
// One value as text, from the command line. A switch takes "true" and "false".
absl::Status SetText(const Setting& setting, const std::string& text, const std::string& place, Configured& configured);
// What must hold for all of it: there is a database, the files of TLS are whole and fit, and nobody else's machine can
// reach a server that asks nobody who he is.
absl::Status Check(const Configured& configured);

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_CONFIG_H_
