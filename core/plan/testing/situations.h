// Machines and what was measured on them so far, for tests that go through all plans.
#ifndef AXISCAL_CORE_PLAN_TESTING_SITUATIONS_H_
#define AXISCAL_CORE_PLAN_TESTING_SITUATIONS_H_

#include <vector>

#include "core/base/demand.h"
#include "core/instruments/run.h"
#include "core/machine/testing/machines.h"
#include "core/plan/situation.h"
#include "core/plan/test.h"
#include "core/synthetic/simulate.h"

namespace axiscal::plan::testing {

inline std::vector<machine::Machine> Machines() {
  return {machine::testing::MultiTasking(), machine::testing::TiltingTable(), machine::testing::SwivelHead()};
}

// Six joints, upright at home with the tool of NeverMeasured in its hand; it declares errors that lengths from places
// beside it tell.
inline machine::Machine Arm() {
  using machine::testing::kY;
  using machine::testing::kZ;
  using machine::testing::Rotary;
  return machine::testing::Make(
      "arm",
      {Rotary("J1", kZ, {0, 0, -1510}), Rotary("J2", -kY, {0, 0, -1110}), Rotary("J3", -kY, {0, 0, -660}),
       Rotary("J4", -kY, {100, 0, -310}), Rotary("J5", kZ, {100, 120, -310}), Rotary("J6", -kY, {100, 120, -230})},
      {}, {"EX0J2", "EA0J2", "EX0J3", "EA0J3", "EC0J3", "EX0J4", "EA0J4", "EC0J4"});
}

inline Situation NeverMeasured(const machine::Machine& machine) {
  Mounted mounted;
  mounted.tips_mm = {{0, 0, -350}};
  mounted.balls_mm = {{40, 0, 60}};
  return SituationOfMachine(machine, mounted);
}

// A machine that was measured before, with temperatures, for the tests that repeat sessions.
inline Situation Measured(const machine::Machine& machine, std::vector<instruments::MeasuringRun>* runs) {
  Situation never = NeverMeasured(machine);
  never.has_temperature = true;
  for (const char* const name : {"rtest-grid", "ballbar-circle", "ballbar-turn"}) {
    const std::vector<PlannedSession> planned = FindTest(name)->plan(never);
    if (planned.empty()) continue;
    session::Session half = planned[0].session;  // one way, which can be run backwards
    for (session::Column& column : half.columns) column.values.resize(column.values.size() / 2);
    const auto session = synthetic::Simulate(machine, {}, half, {});
    DEMAND(session.ok());
    runs->push_back(instruments::BindSession(*session, machine).value());
  }
  return SituationOf(machine, *runs);
}

}  // namespace axiscal::plan::testing

#endif  // AXISCAL_CORE_PLAN_TESTING_SITUATIONS_H_
