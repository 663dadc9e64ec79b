// Every test that the product can plan, measured on simulated machines and identified as a user would: plan, simulate,
// log, reduce, identify. The tests are those of the planners' own lists, so that a new one is held to this as well.
#ifndef AXISCAL_TESTS_RATES_PLANNED_CASE_H_
#define AXISCAL_TESTS_RATES_PLANNED_CASE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/identify/identify.h"
#include "core/machine/error_model.h"
#include "core/session/session.h"

namespace axiscal::rates {

// What is identified in one go: all sessions of a test on a machine, or one of them.
struct PlannedCase {
  machine::Machine machine;
  std::string test, instrument;            // of the planners' lists; of its first session
  std::vector<session::Session> sessions;  // without readings
};

// Of three structures of machines and an arm, never measured before, without a stated travel and with one, and measured
// before. Empty where no machine here runs the test: the caller's list of names (plan::TestNames) says which that is.
std::vector<PlannedCase> PlannedCases(const std::string& test);

struct PlannedFit {
  machine::ErrorModel truth;
  identify::Fit fit;
};

// Errors, set-ups and noise drawn from `seed`; what the sessions read goes through a log (core/logs/testing). Truth:
// each declared constant (30 um, 70 urad, one standard deviation) and, `with_motions`, of every axis what line,
// direction and positioning tests ask for: scale, backlash, bows and turns (40 um/m, 4 um, 5 um and 30 urad at 250 mm),
// unless there are fewer than forty readings. The model that is fitted holds the same terms.
absl::StatusOr<PlannedFit> IdentifyPlanned(const PlannedCase& planned, uint64_t seed, bool with_motions);

}  // namespace axiscal::rates

#endif  // AXISCAL_TESTS_RATES_PLANNED_CASE_H_
