// Rows of `webhook` and `dead_letter`. What each function returns: database.h.
#ifndef AXISCAL_SERVER_STORAGE_WEBHOOKS_H_
#define AXISCAL_SERVER_STORAGE_WEBHOOKS_H_

#include <optional>
#include <string>
#include <vector>

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

absl::StatusOr<WebhookRecord> PutWebhook(Connection& connection, UtcTime now, const Webhook& webhook,
                                         const NewSecret& secret, int64_t expected_etag, const Caller& caller);
absl::StatusOr<WebhookRecord> RemoveWebhook(Connection& connection, UtcTime now, const std::string& name,
                                            int64_t expected_etag, const Caller& caller);
absl::StatusOr<WebhookRecord> GetWebhook(Connection& connection, const std::string& name);
absl::StatusOr<std::vector<WebhookRecord>> ListWebhooks(Connection& connection);
absl::StatusOr<bool> StepWebhook(Connection& connection, UtcTime now, const WebhookStep& step);

absl::StatusOr<Page<DeadLetter>> ListDeadLetters(Connection& connection, const std::string& name,
                                                 const PageRequest& request);
absl::StatusOr<int64_t> ResendDeadLetters(Connection& connection, UtcTime now, const std::string& name,
                                          std::optional<int64_t> change, const Caller& caller);
absl::StatusOr<std::optional<EventChange>> WantedLetter(Connection& connection, WebhookId webhook);
absl::StatusOr<bool> EndWantedLetter(Connection& connection, UtcTime now, WebhookId webhook, int64_t change,
                                     const std::string& error);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_WEBHOOKS_H_
