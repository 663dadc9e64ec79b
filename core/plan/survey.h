// What each known measuring test of a machine can see of its constant errors, before anything is measured: the rank,
// the combinations that it cannot separate, how long it takes; and which smallest set of tests determines what was
// asked (core/information). The same measurement equation, set-ups and rank threshold as identify.
#ifndef AXISCAL_CORE_PLAN_SURVEY_H_
#define AXISCAL_CORE_PLAN_SURVEY_H_

#include <string>
#include <vector>

#include "core/identify/result.h"
#include "core/information/choice.h"
#include "core/plan/test.h"

namespace axiscal::plan {

struct SurveyedTest {
  std::string test;  // name in the registry
  PlannedSession planned;
  std::string session;
  double seconds = 0.0;
  int readings = 0;
  int rank = 0;
  std::vector<std::string> not_separable;  // "EX0B - EX0C"
  std::vector<bool> is_determined;         // per error of the survey, by this test alone
  information::TestInformation tells;      // of the survey's errors
};

struct Survey {
  machine::ErrorModel model;               // the errors that count as unknown
  std::vector<identify::Estimate> errors;  // their names and units, no values
  std::vector<SurveyedTest> tests;         // those within the machine's travel
};

// The constant errors that count as unknown: `declared` (none: the machine's declared ones, or where it declares none
// every location error of its axes) and beside them those that are asked for. INVALID_ARGUMENT when a symbol is no
// constant error of this machine.
absl::StatusOr<machine::ErrorModel> ErrorsToJudge(const machine::Machine& machine,
                                                  const std::vector<std::string>& declared,
                                                  const std::vector<std::string>& asked = {});

// What `run` tells of the amplitudes of `model` (in the order of identify::ListParameters) about those that it holds
// (0: the nominal machine), whatever the readings are; its set-up is its own and eliminated. The weak priors of set-ups
// ("mounted by hand") inform and do not identify.
absl::StatusOr<information::TestInformation> InformationOf(const machine::Machine& machine,
                                                           const machine::ErrorModel& model,
                                                           instruments::MeasuringRun run);

// Every session that the registry plans in `situation`, judged against `model`; `setups`: what is known of set-ups
// (state_setups.h).
absl::StatusOr<Survey> SurveyTests(const Situation& situation, const machine::ErrorModel& model,
                                   const std::vector<std::string>& setups = {});

// Adds each test of the survey in several passes (passes.h): more readings in one mounting.
absl::Status AddPasses(const Situation& situation, Survey* survey);

// Tests of the registry that no session of the survey belongs to.
std::vector<const Test*> TestsWithoutSession(const Survey& survey);

// Indices into Survey::errors; symbols that are none of them are left out. INVALID_ARGUMENT for what is no symbol.
absl::StatusOr<std::vector<int>> IndicesOf(const Survey& survey, const std::vector<std::string>& symbols);

// Mounting an artefact and aligning it, beside the readings themselves.
inline constexpr double kMountingSeconds = 600.0;

struct Proposal {
  std::vector<int> tests;         // indices into Survey::tests
  std::vector<double> sigma;      // expected standard uncertainty per asked error, mm or rad; NaN: no known test tells
  double seconds = 0.0;           // with mounting
  std::vector<int> undetermined;  // asked errors that no set of the known tests determines, as indices into `asked`
  std::vector<double> best;       // per asked error: what all known tests together reach, mm or rad; NaN: nothing
};

// The set that takes the least time, mounting and all, and determines every error of `asked` (indices into
// Survey::errors) beside all others of the survey, to a third of what an error may be (identify/plausible_errors.h), or
// to the standard uncertainty that is `wanted` of it (mm or rad, one per asked error; none: as said). Of
// sets that take as many minutes the one with the least determinant of the covariance (information/choice.h). No two of
// it are the same motion of the same instrument. Sets of up to two tests are all compared, larger ones are as good as
// leaving out and exchange find. Where some errors cannot be determined by all tests together, the rest is; none where
// none can.
Proposal ProposeTests(const Survey& survey, const std::vector<int>& asked, const std::vector<double>& wanted = {});

}  // namespace axiscal::plan

#endif  // AXISCAL_CORE_PLAN_SURVEY_H_
