// Addresses that are told of events: Webhooks.PutWebhook, RemoveWebhook, ListWebhooks, TestWebhook, ListDeadLetters,
// ResendDeadLetters (docs/events.md).
#ifndef AXISCAL_SERVER_HANDLERS_WEBHOOKS_H_
#define AXISCAL_SERVER_HANDLERS_WEBHOOKS_H_

#include "axiscal/v1/webhooks_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::PutWebhookResponse> PutWebhook(Core& core, const Call& call, const v1::PutWebhookRequest& request);
absl::StatusOr<v1::RemoveWebhookResponse> RemoveWebhook(Core& core, const Call& call,
                                                        const v1::RemoveWebhookRequest& request);
absl::StatusOr<v1::ListWebhooksResponse> ListWebhooks(Core& core, const Call& call,
                                                      const v1::ListWebhooksRequest& request);
absl::StatusOr<v1::TestWebhookResponse> TestWebhook(Core& core, const Call& call,
                                                    const v1::TestWebhookRequest& request);
absl::StatusOr<v1::ListDeadLettersResponse> ListDeadLetters(Core& core, const Call& call,
                                                            const v1::ListDeadLettersRequest& request);
absl::StatusOr<v1::ResendDeadLettersResponse> ResendDeadLetters(Core& core, const Call& call,
                                                                const v1::ResendDeadLettersRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_WEBHOOKS_H_
