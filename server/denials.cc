#include "server/denials.h"

#include <utility>
#include <vector>

#include "core/base/error_detail.h"
#include "server/access/gate.h"

namespace axiscal::server {

Denials::Count& Denials::CountOf(const Kind& kind) {
  if (const auto found = counts_.find(kind); found != counts_.end()) return found->second;
  const std::string& user = std::get<0>(kind);
  size_t& kinds = kinds_of_[user];
  if (counts_.size() < kMaxKinds && kinds < (user.empty() ? kMaxKinds / 2 : kMaxKindsOfOne)) {
    ++kinds;
    return counts_[kind];
  }
  if (kinds == 0) kinds_of_.erase(user);
  // Of one principal, then of all: the rest.
  const Kind rest_of_one(user, "", "", "", std::get<4>(kind), "");
  if (!user.empty() && (counts_.contains(rest_of_one) || counts_.size() < kMaxKinds)) return counts_[rest_of_one];
  return counts_[Kind("", "", "", "", std::get<4>(kind), "")];
}

void Denials::Add(const std::string& user, const std::string& peer, const std::string& method,
                  const absl::Status& status) {
  const std::optional<std::string> resource = access::DeniedResource(status);
  if (!absl::IsUnauthenticated(status) && !absl::IsPermissionDenied(status) && !resource) return;
  const bool is_hidden = absl::IsNotFound(status);
  const Kind kind(user, peer, method, resource.value_or(""), absl::StatusCodeToString(status.code()),
                  is_hidden ? "OUT_OF_SCOPE" : base::ErrorReason(status));
  const base::MutexLock lock(mutex_);
  ++CountOf(kind).waiting;
}

// Kinds that go on are counted anew, others make room.
void Denials::BeginHour() {
  hour_began_ = clock_.SteadyNow();
  kinds_of_.clear();
  std::erase_if(counts_, [](const auto& entry) { return entry.second.waiting == 0; });
  for (auto& [kind, count] : counts_) {
    count.written = 0;
    if (!std::get<2>(kind).empty()) ++kinds_of_[std::get<0>(kind)];
  }
}

absl::Status Denials::Write(storage::Database& database, bool all) {
  std::vector<std::pair<Kind, int64_t>> due;
  {
    const base::MutexLock lock(mutex_);
    const bool is_over = clock_.SteadyNow() - hour_began_ >= std::chrono::hours(1);
    for (const auto& [kind, count] : counts_) {
      if (count.waiting > 0 && (all || is_over || count.waiting >= count.written)) due.push_back({kind, count.waiting});
    }
    if (is_over) BeginHour();
  }
  for (const auto& [kind, calls] : due) {
    const auto& [user, peer, method, resource, outcome, reason] = kind;
    storage::AuditEntry entry;
    entry.at = clock_.UtcNow();
    entry.principal = user;
    entry.peer = peer;
    entry.action = method.empty() ? "denied" : "denied " + method;
    entry.resource = resource;
    entry.outcome = outcome;
    entry.detail = absl::StrCat(reason, reason.empty() ? "" : ", ", calls, calls == 1 ? " call" : " calls",
                                method.empty() ? " of more kinds" : "");
    RETURN_IF_ERROR(database.AppendAudit(entry));
    const base::MutexLock lock(mutex_);
    Count& count = counts_[kind];
    count.waiting -= calls;
    count.written += calls;
  }
  return absl::OkStatus();
}

}  // namespace axiscal::server
