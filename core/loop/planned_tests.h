// The sessions that could be measured next, bound to the machine and thinned: some of the readings, enough to judge the
// session by, with the weight of all.
#ifndef AXISCAL_CORE_LOOP_PLANNED_TESTS_H_
#define AXISCAL_CORE_LOOP_PLANNED_TESTS_H_

#include <string>
#include <vector>

#include "core/identify/problem.h"
#include "core/loop/test_rows.h"
#include "core/plan/test.h"

namespace axiscal::loop {

struct PlannedTest {
  std::string test;
  plan::PlannedSession planned;
  instruments::MeasuringRun run;  // its readings are zero
  TestRows rows;                  // of that run, thinned
  identify::Noise noise;          // of the run in full
  std::string beyond;
  bool has_used_instrument = false;  // the shop has it
  double seconds = 0.0;
  double end_s = 0.0;  // time of the last reading, or 0
};

// All tests of the registry that the machine can run now, near the range of its linear axes so far: each once, and in
// several passes. `fitted`: the errors that act.
std::vector<PlannedTest> PlanTests(const identify::Problem& measured, const machine::ErrorModel& fitted);

// The measured sessions and planned ones beside them, in full.
identify::Problem Together(const identify::Problem& measured, const std::vector<const PlannedTest*>& tests);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_PLANNED_TESTS_H_
