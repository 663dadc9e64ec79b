// Templates and controllers' logs of any bytes, the two in one input with a line "====" between them: what is reduced
// is a session that can be written.
#include <sstream>

#include "core/logs/reduce.h"
#include "core/machine/testing/machines.h"
#include "core/session/write_session.h"
#include "tests/fuzz/driver.h"

namespace axiscal::fuzz {
namespace {

void ReduceWith(const logs::LogTemplate& log_template, const std::string& log, const logs::ReduceOptions& options) {
  std::istringstream in(log);
  const auto reduced = logs::Reduce(in, "log.txt", log_template, options);
  MUST(reduced.ok() || absl::IsInvalidArgument(reduced.status()));
  if (!reduced.ok()) return;
  MUST(session::WriteSession(reduced->session).ok());
  MUST(reduced->lines.size() == reduced->session.reading_count());
}

}  // namespace

void Look(const std::string& bytes) {
  static const machine::Machine* const machine = new machine::Machine(machine::testing::MultiTasking());
  constexpr char kBetween[] = "\n====\n";
  const size_t at = bytes.find(kBetween);
  const std::string log = at == std::string::npos ? bytes : bytes.substr(at + sizeof(kBetween) - 1);
  const auto parsed = logs::ParseTemplate(at == std::string::npos ? bytes : bytes.substr(0, at + 1), "t.template");
  MUST(parsed.ok() || absl::IsInvalidArgument(parsed.status()));
  logs::ReduceOptions options;
  if (parsed.ok()) ReduceWith(*parsed, log, options);
  options.machine = machine;
  if (parsed.ok()) ReduceWith(*parsed, log, options);
  for (const std::string& name : logs::KnownFormats()) {
    const auto known = logs::FindFormat(name);
    MUST(known.ok());
    ReduceWith(*known, log, options);
  }
}

}  // namespace axiscal::fuzz
