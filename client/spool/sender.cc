#include "client/spool/sender.h"

#include "core/base/clock.h"
#include "core/base/error_detail.h"
#include "core/session/read_session.h"

namespace axiscal::spool {
namespace {

constexpr int kMaxFailures = 5;

Note ReasonOf(const absl::Status& status) {
  Note note = {{"code", absl::StatusCodeToString(status.code())},
               {"text", std::string(status.message())},
               {"at_utc_us", std::to_string(base::ToUtcUs(base::SystemClock().UtcNow()))}};
  if (const std::optional<base::ErrorDetail> detail = base::GetErrorDetail(status)) {
    note["reason"] = detail->reason;
    for (const auto& [key, value] : detail->facts) note.emplace(key, value);
  }
  return note;
}

// Whose file it is; empty where neither the entry nor its header says so.
std::string MachineOf(const Spool& spool, const Entry& entry) {
  if (entry.item.is_log || !entry.item.machine.empty()) return entry.item.machine;
  const absl::StatusOr<std::string> bytes = spool.Content(Place::kWaiting, entry.number);
  if (!bytes.ok()) return "";
  const absl::StatusOr<session::Session> session = session::ReadSessionText(*bytes, entry.item.name);
  return session.ok() ? session::FindHeader(*session, "machine").value_or("") : "";
}

}  // namespace

Fate FateOf(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return Fate::kSent;
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kNotFound:
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kOutOfRange:
      return Fate::kRefused;
    case absl::StatusCode::kResourceExhausted:
      return base::ErrorReason(status).ends_with("_TOO_LARGE") ? Fate::kRefused : Fate::kLater;
    case absl::StatusCode::kPermissionDenied:
      return Fate::kNotHere;
    case absl::StatusCode::kUnauthenticated:
    case absl::StatusCode::kUnimplemented:  // a server that is older than this
      return Fate::kNotAllowed;
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kDeadlineExceeded:
    case absl::StatusCode::kCancelled:
    case absl::StatusCode::kAborted:
      return Fate::kLater;
    default:
      return Fate::kOurBug;
  }
}

absl::Status Sender::Send(const Entry& entry, const std::string& bytes, Attempt& attempt) {
  if (entry.item.is_log) {
    ASSIGN_OR_RETURN(records::StoredLog stored,
                     client_.PutLog(MachineId(entry.item.machine), entry.item.name, bytes, entry.item.form));
    attempt.session = std::move(stored.session);
    attempt.was_there = stored.was_there;
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(const session::Session session, session::ReadSessionText(bytes, entry.item.name));
  const std::string machine = session::FindHeader(session, "machine").value_or("");
  if (!entry.item.machine.empty() && machine != entry.item.machine) {
    return absl::InvalidArgumentError(
        absl::StrCat(entry.item.name, ": machine: '", machine, "', expected '", entry.item.machine, "'"));
  }
  ASSIGN_OR_RETURN(client::UploadResult stored, client_.Upload(MachineId(machine), session));
  attempt.session = std::move(stored.session);
  attempt.was_there = stored.was_there;
  return absl::OkStatus();
}

// The first that waits and whose machine is not held.
absl::StatusOr<std::optional<int64_t>> Sender::FirstThatMay() {
  ASSIGN_OR_RETURN(const std::vector<int64_t> waiting, spool_.Numbers(Place::kWaiting));
  for (const int64_t number : waiting) {
    if (held_.empty()) return number;
    if (passed_over_.count(number) > 0) continue;
    const absl::StatusOr<Entry> entry = spool_.Get(Place::kWaiting, number);
    // One that cannot be read is for SendNext() to tell.
    if (!entry.ok() || held_.count(MachineOf(spool_, *entry)) == 0) return number;
    passed_over_.insert(number);
  }
  return std::nullopt;
}

void Sender::TryAllAgain() {
  held_.clear();
  passed_over_.clear();
}

absl::StatusOr<std::optional<Attempt>> Sender::SendNext() {
  ASSIGN_OR_RETURN(const std::optional<int64_t> first, FirstThatMay());
  if (!first) return std::nullopt;
  Attempt attempt;
  attempt.number = *first;
  const absl::StatusOr<Entry> entry = spool_.Get(Place::kWaiting, attempt.number);
  const absl::StatusOr<std::string> bytes =
      entry.ok() ? spool_.Content(Place::kWaiting, attempt.number) : absl::StatusOr<std::string>(entry.status());
  if (entry.ok()) attempt.name = entry->item.name;
  attempt.status = bytes.ok() ? Send(*entry, *bytes, attempt) : bytes.status();
  attempt.fate = bytes.ok() ? FateOf(attempt.status) : Fate::kRefused;
  failures_ = attempt.fate == Fate::kOurBug && failing_ == attempt.number ? failures_ + 1 : 1;
  failing_ = attempt.fate == Fate::kOurBug ? attempt.number : 0;
  if (attempt.fate == Fate::kOurBug && failures_ >= kMaxFailures) attempt.fate = Fate::kRefused;
  if (attempt.fate == Fate::kNotHere) held_.insert(MachineOf(spool_, *entry));
  if (attempt.fate == Fate::kSent) {
    RETURN_IF_ERROR(
        spool_.MarkSent(attempt.number, {{"session_id", std::to_string(attempt.session.id.number())},
                                         {"was_there", attempt.was_there ? "true" : "false"},
                                         {"at_utc_us", std::to_string(base::ToUtcUs(base::SystemClock().UtcNow()))}}));
  } else if (attempt.fate == Fate::kRefused) {
    RETURN_IF_ERROR(spool_.Refuse(attempt.number, ReasonOf(attempt.status)));
  }
  return attempt;
}

}  // namespace axiscal::spool
