// What each known measuring test of a machine can see of its constant errors, before anything is measured: the rank,
// the combinations that it cannot separate, how long it takes; and which smallest set of tests determines what was
// asked. The same measurement equation, set-ups and rank threshold as identify.
#ifndef AXISCAL_CORE_TESTPLAN_SURVEY_H_
#define AXISCAL_CORE_TESTPLAN_SURVEY_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/identify/reduction.h"
#include "core/identify/result.h"
#include "core/plan/test.h"

namespace axiscal::testplan {

struct SurveyedTest {
  std::string test;  // name in the registry
  plan::PlannedSession planned;
  std::string session;
  double seconds = 0.0;
  int readings = 0;
  int rank = 0;
  std::vector<std::string> not_separable;  // "EX0B - EX0C"
  std::vector<bool> is_determined;         // per error of the survey, by this test alone
  // Of the errors once the session's own set-up is eliminated; tests add up.
  identify::Reduced identifying;  // without the weak priors of set-ups
  identify::Reduced informing;    // with them: what uncertainties are computed from
};

struct Survey {
  machine::ErrorModel model;               // the errors that count as unknown
  std::vector<identify::Estimate> errors;  // their names and units, no values
  std::vector<SurveyedTest> tests;         // those within the machine's travel
};

// The constant errors of `symbols` (none: the machine's declared ones, or where it declares none every location error
// of its axes). INVALID_ARGUMENT when a symbol is no constant error of this machine.
absl::StatusOr<machine::ErrorModel> ErrorsToJudge(const machine::Machine& machine,
                                                  const std::vector<std::string>& symbols);

// Every session that the registry plans in `situation`, judged against `model`.
absl::StatusOr<Survey> SurveyTests(const plan::Situation& situation, const machine::ErrorModel& model);

// Mounting an artefact and aligning it, beside the readings themselves.
inline constexpr double kMountingSeconds = 600.0;

struct Proposal {
  std::vector<int> tests;         // indices into Survey::tests
  std::vector<double> sigma;      // expected standard uncertainty per asked error, mm or rad
  double seconds = 0.0;           // with mounting
  std::vector<int> undetermined;  // asked errors that no set of the known tests determines, as indices into `asked`
};

// The smallest set that determines every error of `asked` (indices into Survey::errors) beside all others of the
// survey; of equal size the one with the least determinant of their covariance (D-optimal). Where some cannot be
// determined by all tests together, the rest is; none where none can. Sets of up to two are compared all; larger ones grow from the best and
// are improved by exchange.
Proposal ProposeTests(const Survey& survey, const std::vector<int>& asked);

}  // namespace axiscal::testplan

#endif  // AXISCAL_CORE_TESTPLAN_SURVEY_H_
