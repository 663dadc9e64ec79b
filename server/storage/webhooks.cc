#include "server/storage/webhooks.h"

#include "absl/strings/str_cat.h"
#include "core/base/sha256.h"
#include "server/storage/access.h"
#include "server/storage/audit.h"
#include "server/storage/events.h"
#include "server/storage/machines.h"
#include "server/storage/page_token.h"
#include "server/storage/refusal.h"

namespace axiscal::storage {
namespace {

using records::Scope;

// Each is asked for by itself, and a person looks through them.
constexpr int64_t kMostWebhooks = 16;

constexpr char kSelectWebhook[] =
    "SELECT id, name, url, secret, scope, scope_name, is_enabled, note, after_change_id, tries, next_try_at_utc_us, "
    "last_error, last_sent_at_utc_us, dead_letters, etag, created_by, created_at_utc_us, changed_by, "
    "changed_at_utc_us FROM webhook INDEXED BY webhook_name ";

WebhookRecord ReadWebhook(const Statement& row) {
  WebhookRecord record;
  record.id = WebhookId(row.Int(0));
  record.content.name = row.Text(1);
  record.content.url = row.Text(2);
  record.secret = row.Text(3);
  record.content.scope = {row.As<Scope::Kind>(4), row.Text(5)};
  record.content.is_enabled = row.Bool(6);
  record.content.note = row.Text(7);
  record.after_change = row.Int(8);
  record.tries = static_cast<int>(row.Int(9));
  record.next_try_at = row.OptionalTime(10);
  record.last_error = row.Text(11);
  record.last_sent_at = row.OptionalTime(12);
  record.dead_letters = row.Int(13);
  record.etag = row.Int(14);
  record.created_by = row.Text(15);
  record.created_at = row.Time(16);
  record.changed_by = row.Text(17);
  record.changed_at = row.Time(18);
  return record;
}

absl::StatusOr<std::optional<WebhookRecord>> FindWebhook(Connection& connection, const std::string& name) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask(std::string(kSelectWebhook) + "WHERE name = ?1", name));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return std::nullopt;
  return ReadWebhook(row);
}

std::string WebhookPlace(const std::string& name) { return "webhooks/" + name; }

// For the audit, which keeps it for ever: without the secret, and of the URL what whoever reads it may know. Many
// services take the path itself for a secret; its hash tells whether it was another one.
std::string TextOf(const Webhook& webhook) {
  const size_t host = webhook.url.find("//");
  const size_t path = webhook.url.find_first_of("/?", host == std::string::npos ? 0 : host + 2);
  const std::string place = path == std::string::npos || path + 1 == webhook.url.size()
                                ? webhook.url
                                : absl::StrCat(webhook.url.substr(0, path), "/... (SHA-256 ",
                                               base::Sha256Hex(webhook.url).substr(0, 12), ")");
  return absl::StrCat(webhook.is_enabled ? "" : "disabled; ", place, " for ", records::TextOf(webhook.scope),
                      webhook.note.empty() ? "" : ": " + webhook.note);
}

absl::Status CheckScope(Connection& connection, const Scope& scope) {
  if (scope.kind == Scope::Kind::kAll) return absl::OkStatus();
  if (scope.kind == Scope::Kind::kMachine) return LiveMachineKey(connection, MachineId(scope.name)).status();
  ASSIGN_OR_RETURN(const std::vector<int64_t> machines, MachinesIn(connection, {scope}));
  if (machines.empty()) return NotFound("group", "GROUP", scope.name);
  return absl::OkStatus();
}

absl::Status InsertWebhook(Connection& connection, UtcTime now, const std::string& name, const std::string& secret,
                           const Caller& caller) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT count(*) FROM webhook"));
  RETURN_IF_ERROR(row.Step().status());
  if (row.Int(0) >= kMostWebhooks) {
    return base::Error(absl::StatusCode::kResourceExhausted,
                       absl::StrCat("there are ", kMostWebhooks, " webhooks, no more are kept: remove one"),
                       {"TOO_MANY_WEBHOOKS", {}});
  }
  // It is told of what happens from now on.
  ASSIGN_OR_RETURN(const int64_t last, LastEventChange(connection));
  return connection.Run(
      "INSERT INTO webhook (name, url, secret, scope, scope_name, is_enabled, note, after_change_id, tries, "
      "last_error, "
      "dead_letters, etag, created_by, created_at_utc_us, changed_by, changed_at_utc_us) VALUES (?1, '', ?2, 1, '', 0, "
      "'', ?3, 0, '', 0, 1, ?4, ?5, '', 0)",
      name, secret, last, caller.principal, now);
}

}  // namespace

absl::StatusOr<WebhookRecord> GetWebhook(Connection& connection, const std::string& name) {
  ASSIGN_OR_RETURN(std::optional<WebhookRecord> record, FindWebhook(connection, name));
  if (!record) return NotFound("webhook", "WEBHOOK", name);
  return *std::move(record);
}

absl::StatusOr<WebhookRecord> PutWebhook(Connection& connection, UtcTime now, const Webhook& webhook,
                                         const NewSecret& secret, int64_t expected_etag, const Caller& caller) {
  ASSIGN_OR_RETURN(const std::optional<WebhookRecord> present, FindWebhook(connection, webhook.name));
  RETURN_IF_ERROR(CheckEtag("webhook " + webhook.name, expected_etag, present ? present->etag : 0));
  const bool is_same = present && present->content == webhook;
  if (is_same && !secret.replaces) return *present;
  RETURN_IF_ERROR(CheckScope(connection, webhook.scope));
  if (!present) RETURN_IF_ERROR(InsertWebhook(connection, now, webhook.name, secret.text, caller));
  // What was tried at another address is no reason to wait.
  RETURN_IF_ERROR(connection.Run(
      "UPDATE webhook SET url = ?2, secret = CASE WHEN ?3 = 1 THEN ?4 ELSE secret END, scope = ?5, scope_name = ?6, "
      "is_enabled = ?7, note = "
      "?8, tries = 0, next_try_at_utc_us = NULL, last_error = '', etag = ?9, changed_by = ?10, changed_at_utc_us = ?11 "
      "WHERE name = ?1",
      webhook.name, webhook.url, secret.replaces, secret.text, static_cast<int>(webhook.scope.kind), webhook.scope.name,
      webhook.is_enabled, webhook.note, present ? present->etag + 1 : 1, caller.principal, now));
  RETURN_IF_ERROR(AuditChange(connection, now, caller, "webhook.put", WebhookPlace(webhook.name),
                              present ? TextOf(present->content) : "",
                              TextOf(webhook) + (present && secret.replaces ? "; new secret" : "")));
  return GetWebhook(connection, webhook.name);
}

absl::StatusOr<WebhookRecord> RemoveWebhook(Connection& connection, UtcTime now, const std::string& name,
                                            int64_t expected_etag, const Caller& caller) {
  ASSIGN_OR_RETURN(const WebhookRecord present, GetWebhook(connection, name));
  RETURN_IF_ERROR(CheckEtag("webhook " + name, expected_etag, present.etag));
  RETURN_IF_ERROR(connection.Run("DELETE FROM dead_letter WHERE webhook_id = ?1", present.id));
  RETURN_IF_ERROR(connection.Run("DELETE FROM webhook WHERE id = ?1", present.id));
  RETURN_IF_ERROR(
      AuditChange(connection, now, caller, "webhook.remove", WebhookPlace(name), TextOf(present.content), "removed"));
  return present;
}

absl::StatusOr<std::vector<WebhookRecord>> ListWebhooks(Connection& connection) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask(std::string(kSelectWebhook) + "ORDER BY name"));
  std::vector<WebhookRecord> webhooks;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return webhooks;
    webhooks.push_back(ReadWebhook(row));
  }
}

absl::StatusOr<bool> StepWebhook(Connection& connection, UtcTime now, const WebhookStep& step) {
  {
    ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT 1 FROM webhook WHERE id = ?1 AND etag = ?2 AND "
                                                   "after_change_id = ?3",
                                                   step.webhook, step.etag, step.from));
    ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return false;
  }
  RETURN_IF_ERROR(
      connection.Run("UPDATE webhook SET after_change_id = ?2, tries = ?3, next_try_at_utc_us = ?4, last_error = ?5, "
                     "last_sent_at_utc_us = CASE WHEN ?6 = 1 THEN ?7 ELSE last_sent_at_utc_us END WHERE id = ?1",
                     step.webhook, step.to, step.tries, step.next_try_at, step.error, step.is_sent, now));
  if (!step.dead) return true;
  RETURN_IF_ERROR(
      connection.Run("INSERT INTO dead_letter (webhook_id, change_id, tries, error, at_utc_us, is_wanted) VALUES (?1, "
                     "?2, ?3, ?4, ?5, 0)",
                     step.webhook, step.dead->change, step.dead->tries, step.dead->error, now));
  RETURN_IF_ERROR(connection.Run("UPDATE webhook SET dead_letters = dead_letters + 1 WHERE id = ?1", step.webhook));
  return true;
}

absl::StatusOr<Page<DeadLetter>> ListDeadLetters(Connection& connection, const std::string& name,
                                                 const PageRequest& request) {
  ASSIGN_OR_RETURN(const PageStart start, StartPageById(request, "dead_letters|" + name));
  ASSIGN_OR_RETURN(const WebhookRecord webhook, GetWebhook(connection, name));
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask("SELECT d.change_id, c.event_id, m.name, d.tries, d.error, d.at_utc_us, d.is_wanted "
                     "FROM dead_letter AS d CROSS JOIN event_change AS c ON c.id = d.change_id CROSS JOIN "
                     "event AS e ON e.id = c.event_id CROSS JOIN machine AS m ON m.id = e.machine_id WHERE "
                     "d.webhook_id = ?1 AND d.change_id < ?2 ORDER BY d.change_id DESC LIMIT ?3",
                     webhook.id, start.before_id, start.row_limit()));
  Page<DeadLetter> page;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    page.rows.push_back({row.Int(0), EventId(row.Int(1)), MachineId(row.Text(2)), static_cast<int>(row.Int(3)),
                         row.Text(4), row.Time(5), row.Bool(6)});
  }
  EndPage(
      start, [](const DeadLetter& letter) { return std::to_string(letter.change); },
      [](const DeadLetter& letter) { return letter.error.size(); }, page);
  return page;
}

absl::StatusOr<int64_t> ResendDeadLetters(Connection& connection, UtcTime now, const std::string& name,
                                          std::optional<int64_t> change, const Caller& caller) {
  ASSIGN_OR_RETURN(const WebhookRecord webhook, GetWebhook(connection, name));
  RETURN_IF_ERROR(
      connection.Run("UPDATE dead_letter SET is_wanted = 1 WHERE webhook_id = ?1 AND (?2 IS NULL OR change_id = ?2)",
                     webhook.id, change));
  const int64_t count = connection.changed_rows();
  if (change && count == 0) {
    return base::Error(absl::StatusCode::kNotFound,
                       absl::StrCat("change ", *change, " is no dead letter of webhook ", name),
                       {"DEAD_LETTER_NOT_FOUND", {{"change", std::to_string(*change)}}});
  }
  RETURN_IF_ERROR(AuditChange(connection, now, caller, "webhook.resend", WebhookPlace(name), "",
                              absl::StrCat(count, " dead letters", change ? absl::StrCat(": ", *change) : "")));
  return count;
}

absl::StatusOr<std::optional<EventChange>> WantedLetter(Connection& connection, WebhookId webhook) {
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT change_id FROM dead_letter INDEXED BY dead_letter_wanted WHERE "
                                  "webhook_id = ?1 AND is_wanted = 1 ORDER BY change_id LIMIT 1",
                                  webhook));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return std::nullopt;
  ASSIGN_OR_RETURN(EventChange change, GetEventChange(connection, row.Int(0)));
  return change;
}

absl::StatusOr<bool> EndWantedLetter(Connection& connection, UtcTime now, WebhookId webhook, int64_t change,
                                     const std::string& error) {
  if (!error.empty()) {
    RETURN_IF_ERROR(
        connection.Run("UPDATE dead_letter SET is_wanted = 0, tries = tries + 1, error = ?3, at_utc_us = "
                       "?4 WHERE webhook_id = ?1 AND change_id = ?2 AND is_wanted = 1",
                       webhook, change, error, now));
    return connection.changed_rows() > 0;
  }
  RETURN_IF_ERROR(connection.Run("DELETE FROM dead_letter WHERE webhook_id = ?1 AND change_id = ?2", webhook, change));
  if (connection.changed_rows() == 0) return false;
  RETURN_IF_ERROR(
      connection.Run("UPDATE webhook SET dead_letters = dead_letters - 1, last_sent_at_utc_us = ?2 WHERE id "
                     "= ?1",
                     webhook, now));
  return true;
}

}  // namespace axiscal::storage
