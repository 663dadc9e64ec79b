// The measuring tests that the product can plan for a machine: one line of the registry each. A test is a function of
// the machine and of what was measured so far; it gives sessions without readings, which the simulator fills, the loop
// judges and an NC program runs.
#ifndef AXISCAL_CORE_PLAN_TEST_H_
#define AXISCAL_CORE_PLAN_TEST_H_

#include <optional>
#include <string>
#include <vector>

#include "core/plan/situation.h"
#include "core/session/session.h"

namespace axiscal::plan {

struct PlannedSession {
  session::Session session;  // header (its name is unique among the planned and the measured), axis columns
  std::string text;          // one line for the person who mounts it
};

struct Test {
  std::string name;                                       // "ballbar-circle"
  std::string summary;                                    // what it does, one line
  std::vector<PlannedSession> (*plan)(const Situation&);  // variants; empty where the machine cannot run it
};

const std::vector<Test>& Tests();
// Tests that a person may ask for beside those: the loop does not propose them.
const std::vector<Test>& FurtherTests();
// The test of that name among both, or nullptr.
const Test* FindTest(const std::string& name);
// Of both.
std::vector<std::string> TestNames();

// Where a planned session takes the axes beyond what the sessions so far used, for the person who runs it: "Z up
// to 521 mm (so far 490 mm)"; empty when it does not. machine.json may state travel limits: `is_reachable` is false
// beyond them.
struct Reach {
  bool is_reachable = true;
  double beyond_mm = 0.0;  // the farthest of the linear axes
  std::string text;
};
Reach ReachOf(const Situation& situation, const session::Session& session);

// The reachable session of that name, or the first one of the test of that name; behind either `-x4` asks for four
// passes (passes.h). Nothing where the machine runs none.
std::optional<PlannedSession> FindPlanned(const Situation& situation, const std::string& name);

}  // namespace axiscal::plan

#endif  // AXISCAL_CORE_PLAN_TEST_H_
