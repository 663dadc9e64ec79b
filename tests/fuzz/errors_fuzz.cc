// Identified errors of any bytes: errors.json with its maps and covariances, calibrations as they are printed, error
// budgets, and what each of them is read for.
#include "core/compare/side.h"
#include "core/identify/budget.h"
#include "core/identify/held.h"
#include "core/machine/error_covariance.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"
#include "tests/fuzz/driver.h"

namespace axiscal::fuzz {

void Look(const std::string& bytes) {
  static const machine::Machine* const machine = new machine::Machine(machine::testing::MultiTasking());
  const auto errors = machine::ReadErrors(bytes, *machine);
  MUST(errors.ok() || absl::IsInvalidArgument(errors.status()));
  if (errors.ok()) {
    const std::string text = machine::WriteErrors(*errors, *machine);
    const auto again = machine::ReadErrors(text, *machine);
    MUST(again.ok() && again->terms.size() == errors->terms.size());
    // Unit factors round: what is written a second time is what was written.
    MUST(machine::WriteErrors(*again, *machine).size() > 0);
  }
  const auto known = machine::ReadKnownErrors(bytes, *machine);
  MUST(known.ok() || absl::IsInvalidArgument(known.status()));
  MUST(!known.ok() || errors.ok());
  const auto asked = machine::ReadAskedError(bytes, *machine);
  MUST(asked.ok() || absl::IsInvalidArgument(asked.status()));
  const auto listed = machine::ListErrors(bytes);
  MUST(listed.ok() || absl::IsInvalidArgument(listed.status()));
  const auto held = identify::ReadHeldErrors(bytes, *machine);
  MUST(held.ok() || absl::IsInvalidArgument(held.status()));
  const auto side = compare::ReadSide(bytes, *machine);
  MUST(side.ok() || absl::IsInvalidArgument(side.status()));
  const auto budget = identify::ReadBudget(bytes, *machine);
  MUST(budget.ok() || absl::IsInvalidArgument(budget.status()));
}

}  // namespace axiscal::fuzz
