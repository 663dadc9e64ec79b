#include "server/housekeeper.h"

#include <chrono>
#include <string>

#include "absl/strings/str_cat.h"
#include "core/base/clock.h"
#include "server/log.h"

namespace axiscal::server {
namespace {

// How often uploads that were left are looked for. A crash loses so much of the time that counts for them.
constexpr std::chrono::minutes kHousekeeping(10);

void LogExpired(const std::string& what, const absl::StatusOr<int>& count) {
  if (!count.ok()) {
    Log(LogLevel::kWarning, "expire", {{"text", std::string(count.status().message())}});
  } else if (*count > 0) {
    Log(LogLevel::kInfo, "expire", {{what, absl::StrCat(*count)}});
  }
}

}  // namespace

void Housekeeper::Start() {
  rounds_.Start(Rounds::Begin::kAtOnce, kHousekeeping, [this] { KeepHouse(); });
}

void Housekeeper::KeepHouse() {
  LogExpired("sessions", database_.ExpireSessions(options_.session_expiry));
  WarnOfCertificates();
  LogExpired("programs", database_.ExpirePrograms(options_.session_expiry));
  if (options_.keep_readings.count() > 0) LogExpired("readings", database_.ExpireReadings(options_.keep_readings));
  ExpireAudit();
}

// Some at a time, so that other writes go on between.
void Housekeeper::ExpireAudit() {
  if (options_.keep_audit.count() == 0) return;
  absl::StatusOr<int> count = 1;
  for (int total = 0; count.ok() && *count > 0; total += *count) {
    count = database_.ExpireAudit(options_.keep_audit);
    if (!count.ok() || *count == 0) LogExpired("audit", count.ok() ? total : count);
  }
}

void Housekeeper::WarnOfCertificates() {
  for (const std::string& sentence : end_warnings_.Due(certificates_(), base::SystemClock().UtcNow()))
    Log(LogLevel::kWarning, "certificate_ends", {{"text", sentence}});
}

}  // namespace axiscal::server
