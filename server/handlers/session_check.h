// Sessions that come over the wire are held to the rules of session files, and their readings must be near what the
// nominal machine would give (core/instruments/plausible.h), before they are stored. Reason SESSION_INVALID; places are
// those that the session would have as a file.
#ifndef AXISCAL_SERVER_HANDLERS_SESSION_CHECK_H_
#define AXISCAL_SERVER_HANDLERS_SESSION_CHECK_H_

#include <optional>
#include <vector>

#include "core/machine/machine.h"
#include "core/records/chunk.h"
#include "core/session/check_machine.h"
#include "core/session/column_rules.h"
#include "proto/convert/session.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

// NOT_FOUND MACHINE_NOT_FOUND, FAILED_PRECONDITION MACHINE_DELETED.
absl::StatusOr<machine::Machine> MachineOf(Core& core, const MachineId& id);

// Header and columns fit the instrument, the session names `machine`, and the machine has its axes. NOT_FOUND
// MACHINE_NOT_FOUND, FAILED_PRECONDITION MACHINE_DELETED.
absl::Status CheckSchema(Core& core, const MachineId& machine, const records::SessionSchema& schema);

// Readings in their order, across chunks.
class ReadingCheck {
 public:
  // For a stored session, from its chunk `first_seq` on (at most its next_seq).
  static absl::StatusOr<ReadingCheck> Create(Core& core, const records::SessionRecord& session, int64_t first_seq);

  // The next chunk.
  absl::Status Check(const records::Chunk& chunk);

 private:
  ReadingCheck(std::vector<session::HeaderEntry> header, std::vector<session::ColumnRule> rules,
               machine::Machine machine, session::MachineCheck machine_check)
      : part_{std::move(header), {}},
        rules_(std::move(rules)),
        machine_(std::move(machine)),
        machine_check_(std::move(machine_check)) {}

  absl::Status CheckColumn(const session::Column& column, size_t index);
  void SeeTime(const std::vector<session::Column>& columns);

  session::Session part_;  // the chunk that is looked at
  std::vector<session::ColumnRule> rules_;
  machine::Machine machine_;
  session::MachineCheck machine_check_;
  size_t first_reading_ = 0;  // of the next chunk
  std::optional<double> last_time_s_;
};

// Database::FinishSession for a session that has readings. INVALID_ARGUMENT SESSION_INVALID where a header speaks of
// readings that it has not (instruments::CheckWhole).
absl::StatusOr<records::SessionRecord> FinishChecked(Core& core, SessionId id, const records::SessionTotals& totals);

// What the store is asked to open. Measured when its header `started` says (ISO 8601; without a zone it is UTC).
storage::NewSession NewSessionOf(const MachineId& machine, const records::SessionSchema& schema,
                                 const storage::Caller& caller);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_SESSION_CHECK_H_
