// Sessions and plans of any bytes: they are read whole or refused with a place, and what was read is written and read
// again as the same.
#include "core/session/read_session.h"
#include "core/session/write_session.h"
#include "tests/fuzz/driver.h"

namespace axiscal::fuzz {
namespace {

// Readings that are not there are NaN, which is equal to nothing.
bool IsSame(const session::Session& a, const session::Session& b) {
  const auto again = session::WriteSession(a), other = session::WriteSession(b);
  return again.ok() && other.ok() && *again == *other;
}

}  // namespace

void Look(const std::string& bytes) {
  const auto read = session::ReadSessionText(bytes, "a.csv");
  if (read.ok()) {
    const auto text = session::WriteSession(*read);
    MUST(text.ok());
    const auto again = session::ReadSessionText(*text, "again.csv");
    MUST(again.ok() && IsSame(*read, *again));
  } else {
    MUST(absl::IsInvalidArgument(read.status()) && read.status().message().rfind("a.csv: ", 0) == 0);
  }
  const auto plan = session::ReadPlanText(bytes, "a.csv");
  MUST(plan.ok() || absl::IsInvalidArgument(plan.status()));
  // What can be measured can be measured again.
  MUST(plan.ok() || !read.ok());
}

}  // namespace axiscal::fuzz
