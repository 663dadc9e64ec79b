// A planned session as plain G-code for the machine to run. Positions are axis positions (no work offset, no tool
// length): each line of the session is one block that ends at its position, so that what the program visits is the
// session's table.
#ifndef AXISCAL_CORE_PLAN_PROGRAM_H_
#define AXISCAL_CORE_PLAN_PROGRAM_H_

#include <string>
#include <vector>

#include "core/machine/machine.h"
#include "core/plan/probing_program.h"
#include "core/plan/setter_program.h"
#include "core/session/session.h"

namespace axiscal::plan {

// The dialects that are written.
const std::vector<std::string>& ProgramDialects();

struct ProgramOptions {
  std::string dialect = "fanuc";
  double feed_mm_min = 500.0;  // to the first position, and between poses that are measured at rest
  double dwell_s = 2.0;        // at rest before a reading is taken
  ProbingOptions probing;      // of sessions of `centres` and `touch`
  SetterOptions setter;        // of sessions of `tool-setter` and `tool-curve`
};

// Where a column `X_sense` states a side that the move from the row before does not come from, the axis goes beyond the
// position and back (overrun.h) before it is read.
// Ball-bar sessions run without a stop at the session's own times (inverse-time feed G93; Klartext, which has none, at
// the feed); R-tests stop at each pose; `centres` and `touch` sessions become touches (probing_program.h; not in
// Klartext), `tool-setter` and `tool-curve` feeds onto the beam (setter_program.h; neither). INVALID_ARGUMENT on an
// unknown dialect, a number out of range, or a session whose axis columns are not the machine's; FAILED_PRECONDITION
// where the dialect has no word for an axis (J1) or no skip function, or where an overrun lies beyond the travel.
absl::StatusOr<std::string> ToProgram(const machine::Machine& machine, const session::Session& session,
                                      const ProgramOptions& options = {});

// The axis table: the session's file without its readings (session::ReadPlanFile), to be filled by whoever measures it
// or by axiscal reduce. LF line ends.
std::string ToTable(const session::Session& session);

}  // namespace axiscal::plan

#endif  // AXISCAL_CORE_PLAN_PROGRAM_H_
