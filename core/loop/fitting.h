// Full refits of a model as the loop needs them.
#ifndef AXISCAL_CORE_LOOP_FITTING_H_
#define AXISCAL_CORE_LOOP_FITTING_H_

#include "core/identify/identify.h"
#include "core/loop/extension.h"

namespace axiscal::loop {

// Fits the extended model; then judges the noise from what is left and fits again until the two agree. The errors of
// identify::FitRuns.
absl::StatusOr<identify::Fit> FitExtension(const machine::Machine& machine, const Extension& extension,
                                           const identify::Options& options);

// Another model on the same readings, with the noise and the bad readings of `fit`: to compare the two.
absl::StatusOr<identify::Fit> Refit(const identify::Fit& fit, const machine::ErrorModel& model,
                                    const identify::Options& options);

// Chi-square of a fit, its priors included.
double SquaresOf(const identify::Fit& fit);

// By how much a fit leaned on its set-ups to get there (identify::LeaningOnSetups), in units of chi-square.
double LeaningOf(const identify::Fit& fit);

// Likelihood ratio of a term that is in the model: how much chi-square its removal would cost (Wald), its length or
// time constant kept.
double EvidenceOf(const identify::Fit& fit, int term);

// How large a term is in the readings at moments, mm or rad: root mean square and largest; those along a path have no
// moment. NaN where an amplitude is.
struct InReadings {
  InReadings(const std::vector<instruments::MeasuringRun>& runs, const machine::ErrorTerm& term);
  double rms = 0.0, largest = 0.0;
};

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_FITTING_H_
