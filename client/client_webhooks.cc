#include "client/client_impl.h"

namespace axiscal::client {

absl::StatusOr<NewWebhook> Client::PutWebhook(const records::Webhook& webhook, bool new_secret, int64_t etag) {
  v1::PutWebhookRequest request;
  *request.mutable_webhook() = convert::ToProto(webhook);
  request.set_new_secret(new_secret);
  request.set_etag(etag);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::PutWebhookResponse>(*impl_->webhooks, &v1::Webhooks::Stub::PutWebhook, request));
  ASSIGN_OR_RETURN(records::WebhookRecord record, convert::RecordFromProto(response.webhook()));
  return NewWebhook{std::move(record), response.secret()};
}

absl::StatusOr<records::WebhookRecord> Client::RemoveWebhook(const std::string& name, int64_t etag) {
  v1::RemoveWebhookRequest request;
  request.set_name(name);
  request.set_etag(etag);
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::RemoveWebhookResponse>(
                                            *impl_->webhooks, &v1::Webhooks::Stub::RemoveWebhook, request));
  return convert::RecordFromProto(response.webhook());
}

absl::StatusOr<std::vector<records::WebhookRecord>> Client::ListWebhooks() {
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ListWebhooksResponse>(*impl_->webhooks, &v1::Webhooks::Stub::ListWebhooks,
                                                         v1::ListWebhooksRequest()));
  std::vector<records::WebhookRecord> webhooks;
  for (const v1::Webhook& message : response.webhooks()) {
    ASSIGN_OR_RETURN(records::WebhookRecord record, convert::RecordFromProto(message));
    webhooks.push_back(std::move(record));
  }
  return webhooks;
}

absl::StatusOr<records::WebhookTrial> Client::TestWebhook(const std::string& name) {
  v1::TestWebhookRequest request;
  request.set_name(name);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::TestWebhookResponse>(*impl_->webhooks, &v1::Webhooks::Stub::TestWebhook, request));
  return records::WebhookTrial{.status = response.http_status(),
                               .error = response.error(),
                               .is_mail = response.is_mail(),
                               .took_ms = response.took_ms()};
}

absl::StatusOr<Page<records::DeadLetter>> Client::ListDeadLetters(const std::string& name, const PageRequest& page) {
  v1::ListDeadLettersRequest request;
  request.set_name(name);
  request.set_page_size(page.size);
  request.set_page_token(page.token);
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::ListDeadLettersResponse>(
                                            *impl_->webhooks, &v1::Webhooks::Stub::ListDeadLetters, request));
  return ReadPage<records::DeadLetter>(response.letters(), response.next_page_token());
}

absl::StatusOr<int64_t> Client::ResendDeadLetters(const std::string& name, std::optional<int64_t> change) {
  v1::ResendDeadLettersRequest request;
  request.set_name(name);
  if (change) request.set_change_id(*change);
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::ResendDeadLettersResponse>(
                                            *impl_->webhooks, &v1::Webhooks::Stub::ResendDeadLetters, request));
  return response.count();
}

}  // namespace axiscal::client
