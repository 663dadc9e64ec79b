// A measured session as the service knows it. Its readings travel and are kept beside, in chunks (chunk.h).
#ifndef AXISCAL_CORE_RECORDS_SESSION_H_
#define AXISCAL_CORE_RECORDS_SESSION_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/ids.h"
#include "core/session/session.h"

namespace axiscal::records {

// Never renumber.
enum class SessionState { kOpen = 1, kComplete = 2, kAborted = 3, kExpired = 4 };

struct ColumnSpec {
  std::string name;      // with its unit as in the file: X_mm, t_s, feature
  bool is_text = false;  // texts instead of numbers

  bool operator==(const ColumnSpec&) const = default;
};

// What a session is of, without its readings.
struct SessionSchema {
  std::vector<session::HeaderEntry> header;
  std::vector<ColumnSpec> columns;

  bool operator==(const SessionSchema&) const = default;
};

// Of a session with or without readings.
SessionSchema SchemaOf(const session::Session& session);

// What people say of a session.
struct SessionRemark {
  std::string note;
  std::vector<std::string> labels;  // in order, each once
  bool is_rejected = false;         // it does not count
  std::string reason;               // why, or why it counts again
  int64_t etag = 0;                 // grows with every change
  std::string changed_by;
  base::UtcTime changed_at;
};

struct SessionRecord {
  SessionId id;
  MachineId machine;
  std::string name;        // the user's own name of the session ("CR"); need not be unique
  std::string instrument;  // "ballbar", "centres", ...
  std::vector<session::HeaderEntry> header;
  std::vector<ColumnSpec> columns;
  std::optional<base::UtcTime> measured_at;  // when it was measured, if the file says so
  SessionState state = SessionState::kOpen;
  int64_t next_seq = 0;       // chunks 0 .. next_seq - 1 are durable
  int64_t reading_count = 0;  // readings in them
  std::string hash;           // session::SessionHash of its chunks, once complete; else empty
  std::string created_by;
  base::UtcTime created_at;
  base::UtcTime last_seen_at;  // of the last chunk
  std::optional<base::UtcTime> closed_at;
  std::optional<SessionRemark> remark = {};  // where somebody has said something

  bool is_rejected() const { return remark && remark->is_rejected; }
};

// Totals with which the uploader closes a session.
struct SessionTotals {
  int64_t chunk_count = 0;
  int64_t reading_count = 0;
  std::string hash;  // session::SessionHash
};

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_SESSION_H_
