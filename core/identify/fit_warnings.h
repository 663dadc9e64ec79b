// What a reader of a fit's numbers must know.
#ifndef AXISCAL_CORE_IDENTIFY_FIT_WARNINGS_H_
#define AXISCAL_CORE_IDENTIFY_FIT_WARNINGS_H_

#include <vector>

#include "core/identify/problem.h"
#include "core/identify/reduction.h"
#include "core/identify/result.h"

namespace axiscal::identify {

// Of a result with estimates and model: readings that scatter about the fit beyond reports::kPoorFitChi2PerDof, or
// of which too many were set aside for chips; errors without an interval (`without_interval`, per estimate); and errors
// that no reading supports (`unsupported`, per estimate) but that the model holds at sizes that are not plausible,
// because something had to take up what the readings show.
std::vector<reports::WarningFacts> WarningsOf(const Result& result, const std::vector<Parameter>& parameters,
                                              const std::vector<bool>& without_interval,
                                              const std::vector<bool>& unsupported);

// Of each session with a reading column that is rounded to a coarse step (instruments/resolution.h).
std::vector<reports::WarningFacts> FindCoarseReadings(const Problem& problem);

// Certificates that were not valid when their session began, and those of sessions that do not say when that was.
std::vector<reports::WarningFacts> FindExpired(const Problem& problem);

// Where sessions overlap in time and the model has errors that depend on it.
std::vector<reports::WarningFacts> FindTwoClocks(const Problem& problem, const Result& result);

// Trackers that their reference targets show to have moved: where what stands in the middle of the readings seemed to
// go, at some look, by more than four standard uncertainties (chance: one in 16,000 for each of three directions).
std::vector<reports::WarningFacts> FindMoved(const Problem& problem, const Point& point, const Covariance& covariance);

// Errors and set-up offsets that are surely larger than a machine of this size can have, after its fit.
std::vector<reports::WarningFacts> FindBeyondSize(const Problem& problem, const Result& result);

// Sessions whose used readings scatter about the fit by far less than stated; all of them where that shows only in the
// sum.
std::vector<reports::WarningFacts> FindQuiet(const Problem& problem, const Result& result,
                                             const std::vector<Eigen::MatrixXd>& residuals_mm);

// The covariance of a fit takes what is held for independent of its readings. It is where the stages have no session in
// common: a set-up that both fit freely carries nothing from one to the other. Not so where the same readings gave
// both, or where errors rest on an offset that both know to a stated sigma: it is off by the same amount in both.
std::vector<reports::WarningFacts> SharedWithHeld(const Problem& problem, const Covariance& covariance,
                                                  const std::vector<MeasuredIn>& held_from);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_FIT_WARNINGS_H_
