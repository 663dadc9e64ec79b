#include "server/handlers/webhooks.h"

#include "absl/strings/str_cat.h"
#include "core/base/clock.h"
#include "core/base/error_detail.h"
#include "proto/convert/field.h"
#include "proto/convert/webhook.h"
#include "server/webhooks/letter.h"
#include "server/webhooks/sender.h"

namespace axiscal::handlers {
namespace {

absl::Status RequireWebhook(const std::string& name) { return convert::RequireText("name", name, 1, 64); }

}  // namespace

absl::StatusOr<v1::PutWebhookResponse> PutWebhook(Core& core, const Call& call, const v1::PutWebhookRequest& request) {
  RETURN_IF_ERROR(convert::RequireMessage("webhook", request.has_webhook()));
  RETURN_IF_ERROR(convert::RequireNotNegative("etag", request.etag()));
  const absl::StatusOr<records::Webhook> webhook = convert::FromProto(request.webhook());
  if (!webhook.ok()) return convert::InField("webhook", webhook.status());
  RETURN_IF_ERROR(
      webhooks::CheckUrl(webhook->url, core.webhook_sender != nullptr ? &core.webhook_sender->addresses() : nullptr));
  if (webhooks::IsMail(webhook->url) && core.webhook_sender != nullptr && !core.webhook_sender->has_mail())
    return convert::FieldError("webhook.url", "no mail server is configured: mail.server in axiscald.toml");
  const storage::NewSecret secret = {webhooks::NewSecret(), request.new_secret()};
  ASSIGN_OR_RETURN(const records::WebhookRecord record,
                   core.database.PutWebhook(*webhook, secret, request.etag(), call.By()));
  if (core.webhook_sender != nullptr) core.webhook_sender->LookSoon();
  v1::PutWebhookResponse response;
  *response.mutable_webhook() = convert::ToProto(record);
  // Mails are not signed.
  if (record.secret == secret.text && !webhooks::IsMail(record.content.url)) response.set_secret(record.secret);
  return response;
}

absl::StatusOr<v1::RemoveWebhookResponse> RemoveWebhook(Core& core, const Call& call,
                                                        const v1::RemoveWebhookRequest& request) {
  RETURN_IF_ERROR(RequireWebhook(request.name()));
  RETURN_IF_ERROR(convert::RequireNotNegative("etag", request.etag()));
  ASSIGN_OR_RETURN(const records::WebhookRecord record,
                   core.database.RemoveWebhook(request.name(), request.etag(), call.By()));
  v1::RemoveWebhookResponse response;
  *response.mutable_webhook() = convert::ToProto(record);
  return response;
}

absl::StatusOr<v1::ListWebhooksResponse> ListWebhooks(Core& core, const Call&, const v1::ListWebhooksRequest&) {
  ASSIGN_OR_RETURN(const std::vector<records::WebhookRecord> webhooks, core.database.ListWebhooks());
  v1::ListWebhooksResponse response;
  for (const records::WebhookRecord& record : webhooks) *response.add_webhooks() = convert::ToProto(record);
  return response;
}

absl::StatusOr<v1::TestWebhookResponse> TestWebhook(Core& core, const Call& call,
                                                    const v1::TestWebhookRequest& request) {
  RETURN_IF_ERROR(RequireWebhook(request.name()));
  ASSIGN_OR_RETURN(const records::WebhookRecord record, core.database.GetWebhook(request.name()));
  if (core.webhook_sender == nullptr) {
    return base::Error(absl::StatusCode::kFailedPrecondition,
                       "this service sends no webhooks: axiscald does, while it has the database",
                       {"WEBHOOKS_NOT_SENT", {}});
  }
  ASSIGN_OR_RETURN(const records::WebhookTrial trial, core.webhook_sender->Try(record, call.is_cancelled));
  storage::AuditEntry entry;
  entry.at = base::SystemClock().UtcNow();
  entry.principal = call.user;
  entry.peer = call.peer;
  entry.action = "webhook.test";
  entry.resource = "webhooks/" + record.content.name;
  entry.outcome = "OK";
  entry.detail = trial.error.empty() ? absl::StrCat(trial.is_mail ? "SMTP " : "HTTP ", trial.status) : trial.error;
  RETURN_IF_ERROR(core.database.AppendAudit(entry));
  v1::TestWebhookResponse response;
  response.set_http_status(trial.status);
  response.set_error(trial.error);
  response.set_took_ms(trial.took_ms);
  response.set_is_mail(trial.is_mail);
  return response;
}

absl::StatusOr<v1::ListDeadLettersResponse> ListDeadLetters(Core& core, const Call&,
                                                            const v1::ListDeadLettersRequest& request) {
  RETURN_IF_ERROR(RequireWebhook(request.name()));
  ASSIGN_OR_RETURN(const records::PageRequest page, PageFrom(request.page_size(), request.page_token()));
  ASSIGN_OR_RETURN(const records::Page<records::DeadLetter> letters,
                   core.database.ListDeadLetters(request.name(), page));
  v1::ListDeadLettersResponse response;
  for (const records::DeadLetter& letter : letters.rows) *response.add_letters() = convert::ToProto(letter);
  response.set_next_page_token(letters.next_token);
  return response;
}

absl::StatusOr<v1::ResendDeadLettersResponse> ResendDeadLetters(Core& core, const Call& call,
                                                                const v1::ResendDeadLettersRequest& request) {
  RETURN_IF_ERROR(RequireWebhook(request.name()));
  std::optional<int64_t> change;
  if (request.has_change_id()) {
    RETURN_IF_ERROR(convert::RequirePositive("change_id", request.change_id()));
    change = request.change_id();
  }
  ASSIGN_OR_RETURN(const int64_t count, core.database.ResendDeadLetters(request.name(), change, call.By()));
  if (core.webhook_sender != nullptr) core.webhook_sender->LookSoon();
  v1::ResendDeadLettersResponse response;
  response.set_count(count);
  return response;
}

}  // namespace axiscal::handlers
