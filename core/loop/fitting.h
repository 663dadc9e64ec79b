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

// Fits an extension that was changed: true with its fit in `fit`, or false and the extension set back to `before` where
// the fit does not converge. CANCELLED.
absl::StatusOr<bool> FitChanged(const machine::Machine& machine, const identify::Options& options,
                                const Extension& before, Extension* extension, identify::Fit* fit);

// Another model on the same readings, with the noise and the bad readings of `fit`: to compare the two.
absl::StatusOr<identify::Fit> Refit(const identify::Fit& fit, const machine::ErrorModel& model,
                                    const identify::Options& options);

// The same model on the same readings with other slips: `runs` for those of `fit`.
absl::StatusOr<identify::Fit> RefitRuns(const identify::Fit& fit, std::vector<instruments::MeasuringRun> runs,
                                        const identify::Options& options);

// The same model without the readings [first, last) of one run.
absl::StatusOr<identify::Fit> RefitWithout(const identify::Fit& fit, int run, int first, int last,
                                           const identify::Options& options);

// Chi-square of a fit, its priors included.
double SquaresOf(const identify::Fit& fit);

// Chi-square for comparing fits of the same readings with different noise and different readings set aside: minus twice
// the logarithm of the likelihood, with the priors.
double ComparableSquaresOf(const identify::Fit& fit);

// Likelihood ratio of a term that is in the model: how much chi-square its removal would cost (Wald).
double EvidenceOf(const identify::Fit& fit, int term);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_FITTING_H_
