#include "server/config.h"

#include <algorithm>

#include "absl/strings/numbers.h"
#include "core/base/clock.h"
#include "core/base/files.h"
#include "core/base/utf8.h"
#include "core/records/diagnosis.h"
#include "server/listener.h"
#include "server/server.h"
#include "server/webhooks/addresses.h"

namespace axiscal::server {
namespace {

constexpr int64_t kDaySeconds = 86'400;
constexpr int64_t kMaxSize = int64_t{1} << 40;  // more than a disk of the shop has
constexpr int64_t kMaxDays = 36'500;            // a hundred years
constexpr size_t kMaxAuthorityBytes = size_t{16} << 20;
constexpr char kPrefix[] = "AXISCALD_";

absl::Status Refuse(const std::string& place, const std::string& key, const std::string& value,
                    const std::string& rule) {
  return absl::InvalidArgumentError(absl::StrCat(place, ": ", key, " = ", value, ", ", rule));
}

// Reads `text` into the field of a setting.
struct Assign {
  const Setting& setting;
  const std::string& text;
  const std::string& place;
  Config& config;

  absl::Status operator()(std::string Config::*field) const {
    if (text.empty() || !base::IsUtf8(text) || text.find('\0') != std::string::npos)
      return Refuse(place, setting.key, "'" + text + "'", "must be a text that is not empty");
    config.*field = text;
    return absl::OkStatus();
  }
  absl::Status operator()(int64_t Config::*field) const {
    int64_t number = 0;
    if (!absl::SimpleAtoi(text, &number) || number < setting.least || number > setting.most)
      return Refuse(place, setting.key, text, absl::StrCat("must be ", setting.least, " to ", setting.most));
    config.*field = number;
    return absl::OkStatus();
  }
  absl::Status operator()(bool Config::*field) const {
    if (text != "true" && text != "false") return Refuse(place, setting.key, text, "must be true or false");
    config.*field = text == "true";
    return absl::OkStatus();
  }
};

}  // namespace

const std::vector<Setting>& Settings() {
  static const auto* const settings = new std::vector<Setting>{
      {"store.database", "--db",
       "Database file; made when it is not there, used by one process at a time. Or postgresql://USER@HOST/DATABASE, "
       "which several may have (docs/scale.md)",
       &Config::database, 0, 0, true},
      {"server.listen", "--listen", "HOST:PORT or unix:PATH; port 0 picks a free one", &Config::listen},
      {"server.http", "--http",
       "HOST:PORT or unix:PATH where the same is served by HTTP (docs/http.md); nowhere when not set", &Config::http},
      {"server.drain_seconds", "--drain-seconds", "How long calls and jobs may go on after SIGTERM",
       &Config::drain_seconds, 0, kDaySeconds},
      {"server.ask_identity", "--ask-identity", "Callers must show a certificate or a token; always so with TLS",
       &Config::asks_identity},
      {"tls.certificate", "--tls-certificate", "The server's certificate, PEM; read again when it changes",
       &Config::tls_certificate, 0, 0, true},
      {"tls.key", "--tls-key", "Its key, PEM, without a password", &Config::tls_key, 0, 0, true},
      {"tls.client_ca", "--tls-client-ca", "Authorities of the callers' certificates, PEM", &Config::tls_client_ca, 0,
       0, true},
      {"jobs.workers", "--workers", "Jobs at once; each uses one core", &Config::workers, 1, kMaxWorkers},
      {"limits.max_uploads", "--max-uploads", "Streams that bring something, at a time", &Config::max_uploads, 1,
       kMaxUploads},
      {"limits.streams_per_principal", "--streams-per-principal", "Streams of one principal, of each kind, at a time",
       &Config::streams_per_principal, 1, kMaxUploads},
      {"limits.calls_per_second", "--calls-per-second", "Calls of one principal a second", &Config::calls_per_second, 1,
       kMaxCallsPerSecond},
      {"limits.jobs_per_principal", "--jobs-per-principal", "Jobs of one principal that wait or run",
       &Config::jobs_per_principal, 1, kMaxJobs},
      {"limits.jobs_per_machine", "--jobs-per-machine", "Jobs of one machine that wait or run",
       &Config::jobs_per_machine, 1, kMaxJobs},
      {"limits.session_readings", "--session-readings", "Readings of one session", &Config::session_readings, 1,
       kMaxSize},
      {"limits.program_bytes", "--program-bytes", "Bytes of one program", &Config::program_bytes, 1, kMaxSize},
      {"limits.window_bytes", "--window-bytes", "Bytes a stream may run ahead of the server", &Config::window_bytes,
       kMinWindowBytes, kMaxWindowBytes},
      {"limits.waiting_bytes", "--waiting-bytes", "Bytes that callers have half sent, of all together",
       &Config::waiting_bytes, kMinWaitingBytes, kMaxSize},
      {"limits.silence_seconds", "--silence-seconds", "A caller silent for so long in a stream is cut off",
       &Config::silence_seconds, 1, kDaySeconds},
      {"limits.idle_seconds", "--idle-seconds", "A connection without a call for so long is closed",
       &Config::idle_seconds, 1, kDaySeconds},
      {"webhooks.allowed", "--webhooks-allowed",
       "Addresses of this machine and its cable that webhooks may call all the same: 127.0.0.1:8080, [::1]:80",
       &Config::webhooks_allowed},
      {"webhooks.ca", "--webhooks-ca",
       "Authorities of the receivers of webhooks, PEM; else those that the system trusts", &Config::webhooks_ca, 0, 0,
       true},
      {"mail.server", "--mail-server",
       "The plant's SMTP server, by which webhooks to mailto: addresses go: smtp://mail.plant:587 (STARTTLS), "
       "smtps://mail.plant",
       &Config::mail_server},
      {"mail.from", "--mail-from", "The address that mails are from", &Config::mail_from},
      {"mail.user", "--mail-user", "As whom to sign in to it; empty: nobody asks", &Config::mail_user},
      {"mail.password_file", "--mail-password-file", "Its password, read for each mail", &Config::mail_password_file, 0,
       0, true},
      {"mail.ca", "--mail-ca", "Authorities of its certificate, PEM; else those that the system trusts",
       &Config::mail_ca, 0, 0, true},
      {"mail.without_tls", "--mail-without-tls", "It has no TLS: mails go in the clear, and no password is sent",
       &Config::mail_without_tls},
      {"backup.folder", "--backup-folder", "Where backups stay that admins ask for", &Config::backup_folder, 0, 0,
       true},
      {"retention.readings_days", "--keep-readings-days",
       "Readings that no calibration stands on are kept for so many days of up time; 0: for ever",
       &Config::keep_readings_days, 0, kMaxDays},
      {"retention.audit_days", "--keep-audit-days",
       "Entries of the audit are kept for so many days of up time; 0: for ever", &Config::keep_audit_days, 0, kMaxDays},
      {"metrics.machines", "--metrics-machines",
       "So many machines, those with most open events, have series of their own in the metrics; 0: none",
       &Config::metrics_machines, 0, 50},
      {"log.json", "--log-json", "Log lines as JSON instead of key=value", &Config::log_json},
      {"log.level", "--log-level",
       "Lines of less are not written: debug, info, warning, error; changed while it runs by axiscal admin log-level",
       &Config::log_level},
  };
  return *settings;
}

std::string EnvironmentName(const Setting& setting) {
  std::string name = kPrefix;
  for (const char c : setting.flag.substr(2)) name += c == '-' ? '_' : static_cast<char>(std::toupper(c));
  return name;
}

std::string ValueText(const Setting& setting, const Config& config) {
  if (const auto* text = std::get_if<std::string Config::*>(&setting.field)) return config.**text;
  if (const auto* number = std::get_if<int64_t Config::*>(&setting.field)) return absl::StrCat(config.**number);
  return config.*std::get<bool Config::*>(setting.field) ? "true" : "false";
}

absl::Status SetText(const Setting& setting, const std::string& text, const std::string& place,
                     Configured& configured) {
  RETURN_IF_ERROR(std::visit(Assign{setting, text, place, configured.config}, setting.field));
  configured.place[setting.key] = place;
  return absl::OkStatus();
}

absl::Status ReadEnvironment(const std::vector<std::string>& variables, Configured& configured) {
  Configured read = configured;
  for (const std::string& variable : variables) {
    const size_t equals = variable.find('=');
    const std::string name = variable.substr(0, equals);
    if (name.rfind(kPrefix, 0) != 0 || equals == std::string::npos || name == "AXISCALD_CONFIG") continue;
    const auto setting = std::find_if(Settings().begin(), Settings().end(),
                                      [&](const Setting& one) { return EnvironmentName(one) == name; });
    if (setting == Settings().end())
      return absl::InvalidArgumentError("environment: " + name + " is no setting (docs/configuration.md)");
    RETURN_IF_ERROR(SetText(*setting, variable.substr(equals + 1), name, read));
  }
  configured = std::move(read);
  return absl::OkStatus();
}

TlsFiles TlsFilesOf(const Config& config) { return {config.tls_certificate, config.tls_key, config.tls_client_ca}; }

absl::Status Check(const Configured& configured) {
  const auto place = [&](const std::string& key) {
    const auto found = configured.place.find(key);
    return found == configured.place.end() ? std::string("default") : found->second;
  };
  const Config& config = configured.config;
  if (config.database.empty()) {
    return absl::InvalidArgumentError(
        "store.database is not set: name the database file in axiscald.toml, AXISCALD_DB or --db");
  }
  if (!records::LogLevelNamed(config.log_level)) {
    return absl::InvalidArgumentError(absl::StrCat(place("log.level"), ": log.level = '", config.log_level,
                                                   "', must be debug, info, warning or error"));
  }
  const TlsFiles tls = TlsFilesOf(config);
  if (tls.is_set() != !tls.key.empty()) {
    const std::string set = tls.is_set() ? "tls.certificate" : "tls.key";
    return absl::InvalidArgumentError(absl::StrCat(place(set), ": ", set,
                                                   " is set, tls.certificate and tls.key must "
                                                   "be set together"));
  }
  if (!tls.client_ca.empty() && !tls.is_set()) {
    return absl::InvalidArgumentError(place("tls.client_ca") +
                                      ": tls.client_ca is set, must come with tls.certificate and tls.key");
  }
  if (tls.is_set()) {
    const absl::Status fits = ReadTls(tls, base::SystemClock().UtcNow()).status();
    if (!fits.ok()) return base::Within(place("tls.certificate") + ": tls", fits);
  }
  for (const auto& [key, address] :
       {std::pair<std::string, std::string>("server.listen", config.listen), {"server.http", config.http}}) {
    if (address.empty()) continue;
    const std::string where = place(key) + ": " + key;
    const absl::StatusOr<bool> is_local_only = IsLocalOnly(address);
    if (!is_local_only.ok()) return base::Within(where, is_local_only.status());
    if (!*is_local_only && !tls.is_set()) return base::Within(where, Unprotected(address));
  }
  const auto within = [&](const std::string& key, const absl::Status& status) {
    return status.ok() ? status : base::Within(place(key) + ": " + key, status);
  };
  RETURN_IF_ERROR(within("webhooks.allowed", webhooks::AddressRule::Allowing(config.webhooks_allowed).status()));
  if (!config.webhooks_ca.empty())
    RETURN_IF_ERROR(within("webhooks.ca", base::ReadFile(config.webhooks_ca, kMaxAuthorityBytes).status()));
  if (const std::optional<webhooks::MailServer> mail = MailOf(config)) {
    RETURN_IF_ERROR(within("mail.server", webhooks::Check(*mail)));
    if (!config.mail_ca.empty())
      RETURN_IF_ERROR(within("mail.ca", base::ReadFile(config.mail_ca, kMaxAuthorityBytes).status()));
    if (!config.mail_password_file.empty())
      RETURN_IF_ERROR(within("mail.password_file", base::ReadFile(config.mail_password_file, 4096).status()));
  } else if (!config.mail_from.empty() || !config.mail_user.empty() || !config.mail_password_file.empty()) {
    return within("mail.from", absl::InvalidArgumentError("is set, must come with mail.server"));
  }
  return absl::OkStatus();
}

std::optional<webhooks::MailServer> MailOf(const Config& config) {
  if (config.mail_server.empty()) return std::nullopt;
  return webhooks::MailServer{config.mail_server,        config.mail_from, config.mail_user,
                              config.mail_password_file, config.mail_ca,   !config.mail_without_tls};
}

}  // namespace axiscal::server
