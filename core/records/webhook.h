// Addresses that are told of events by HTTP or e-mail, and what could not be brought there (docs/events.md).
#ifndef AXISCAL_CORE_RECORDS_WEBHOOK_H_
#define AXISCAL_CORE_RECORDS_WEBHOOK_H_

#include <cstdint>
#include <optional>
#include <string>

#include "core/base/clock.h"
#include "core/base/ids.h"
#include "core/records/access.h"

namespace axiscal::records {

struct Webhook {
  std::string name;        // IsAccessName(); each once
  std::string url;         // http, https or mailto
  Scope scope;             // the machines whose events are sent
  bool is_enabled = true;  // false: it is kept, what happens meanwhile is sent once it is enabled again
  std::string note;        // for people

  bool operator==(const Webhook&) const = default;
};

struct WebhookRecord {
  WebhookId id;
  Webhook content;
  std::string secret;        // "whsec_..."; known to the service and to whoever made it, never shown again
  int64_t etag = 0;          // grows with every change by a person
  int64_t after_change = 0;  // changes of events up to this one were sent, or are dead letters
  int tries = 0;             // of the next change, so far
  std::optional<base::UtcTime> next_try_at;  // not before; absent: at once
  std::string last_error;                    // of the newest try; empty: it was taken
  std::optional<base::UtcTime> last_sent_at;
  int64_t dead_letters = 0;
  std::string created_by, changed_by;
  base::UtcTime created_at, changed_at;
};

// A change of an event that could not be brought to an address.
struct DeadLetter {
  int64_t change = 0;
  EventId event;
  MachineId machine;
  int tries = 0;
  std::string error;       // of the last try
  base::UtcTime at;        // when it was tried last
  bool is_wanted = false;  // a person wants it sent again, which is not done yet
};

// What came of one try to bring something to an address.
struct WebhookTrial {
  int status = 0;     // of HTTP, or the reply code of SMTP; 0: no answer came
  std::string error;  // empty: it was taken (2xx)
  bool is_mail = false;
  int64_t took_ms = 0;
};

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_WEBHOOK_H_
