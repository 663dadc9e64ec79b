// What tests of routines share: readings that are new each time, and waiting for a run.
#ifndef AXISCAL_TESTS_END_TO_END_TESTING_ROUTINE_FIXTURE_H_
#define AXISCAL_TESTS_END_TO_END_TESTING_ROUTINE_FIXTURE_H_

#include <chrono>
#include <random>
#include <string>
#include <thread>

#include "tests/end_to_end/testing/fixture.h"

namespace axiscal::testing {

// BallbarSession() with the scatter that its header states, another one for each seed: equal readings would be the
// same session. EX0C is more by `ex0c_um`.
inline session::Session ScatteredSession(const std::string& name, unsigned seed, double ex0c_um = 0.0) {
  session::Session session = BallbarSession("mt", name, 360);
  std::mt19937 random(seed);
  std::normal_distribution<double> noise_mm(0.0, 0.3e-3);
  for (size_t i = 0; i < session.columns.back().values.size(); ++i) {
    const double angle = 2 * M_PI * static_cast<double>(i) / 360;
    session.columns.back().values[i] += noise_mm(random) - ex0c_um * 1e-3 * std::cos(angle);
  }
  return session;
}

// The newest run of all when there are `count` and it has ended.
inline records::RoutineRun WaitForRun(client::Client& client, size_t count) {
  while (true) {
    const auto runs = client.ListRoutineRuns();
    EXPECT_TRUE(runs.ok()) << runs.status();
    if (!runs.ok()) return {};
    if (runs->rows.size() >= count && !records::IsOpen(runs->rows[0].state)) return runs->rows[0];
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

}  // namespace axiscal::testing

#endif  // AXISCAL_TESTS_END_TO_END_TESTING_ROUTINE_FIXTURE_H_
