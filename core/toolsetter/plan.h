// What to measure in the tool setter, and what it will tell before anything is measured: the evaluation of the readings
// that the exact model would give at the stated repeatability.
#ifndef AXISCAL_CORE_TOOLSETTER_PLAN_H_
#define AXISCAL_CORE_TOOLSETTER_PLAN_H_

#include <string>
#include <vector>

#include "core/machine/machine.h"
#include "core/toolsetter/reference.h"
#include "core/toolsetter/wear.h"

namespace axiscal::toolsetter {

// The tests beside those of core/plan: they tell of tools, not of the machine's errors.
struct PlannableTest {
  std::string name;     // "tool-setter", "tool-curve": the sessions' instrument
  std::string summary;  // what it does, one line
  std::string file;     // what it is planned from, one line
};
const std::vector<PlannableTest>& PlannableTests();
// The test of that name, or nullptr.
const PlannableTest* FindPlannable(const std::string& name);

// The tool setter is fed onto by a linear axis along the tool: without one a machine runs none of the tests.
bool FeedsAlongTool(const machine::Machine& machine);

// `session.rods` with `readouts` (1 to 100) each. `turned`: the name of a rod that is measured in `holders` (2 to 360)
// evenly spaced positions of the spindle instead of one, "NAME@30" ...; empty: none. INVALID_ARGUMENT naming the
// number, or the rod that is not there.
absl::StatusOr<RodSession> PlanRods(RodSession session, const std::string& turned, int holders, int readouts);

// `starts` (inserts + 2 to 360) evenly spaced start angles of the unworn cutter. INVALID_ARGUMENT as HeightsOf and
// CheckInsertsApart.
absl::StatusOr<CurveSession> PlanStarts(CurveSession session, int starts);

// What the planned readings will tell: standard uncertainties by repeatability and what is stated beforehand. Of rods
// Z, yaw and pitch, by their information (InformationOf); of start angles length and wear, by the likelihood itself:
// what holds them are the jumps of the curve, of which no Jacobian knows (wear.cc). As FitReference and FitWear.
absl::StatusOr<Reference> ExpectedOf(const RodSession& planned);
absl::StatusOr<WearReport> ExpectedOf(const CurveSession& planned);

// Session files to be filled in: header, and a line per reading without its number. Of rods, `session` is the one that
// they were planned from; of a cutter, `cutter_json` its file, INVALID_ARGUMENT as ParseStrictJson.
std::string ToTable(const session::Session& session, const RodSession& planned);
absl::StatusOr<std::string> ToTable(const std::string& cutter_json, const std::string& machine,
                                    const std::string& session, const CurveSession& planned);

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_PLAN_H_
