// How large an error of a machine may plausibly be: the yardstick for what a fit leaves uncertain.
#ifndef AXISCAL_CORE_IDENTIFY_PLAUSIBLE_ERRORS_H_
#define AXISCAL_CORE_IDENTIFY_PLAUSIBLE_ERRORS_H_

#include <Eigen/Core>
#include <vector>

#include "core/identify/problem.h"
#include "core/machine/error_json.h"

namespace axiscal::identify {

// Any machine may have an error of this size, in the units of files (um, urad, um/m ...). An assumption, the same for
// all errors: no document at hand has a distribution of them. It is chosen wide: the largest location errors that the
// sources of docs/validation.md print are 53 um and 25 arcsec (122 urad; Yao 2022, Table 4.5), of a machine in use, and
// what a crash or a wrong assembly leaves is a few times as much. What is twice as large is found all the same; only
// uncertainties that rest on this size (unseen.h) are then too small by as much.
inline constexpr double kPlausible = 300.0;

// An error whose standard uncertainty is more than this share of a plausible size has not been measured: a plausible
// size is three standard deviations of what is known of an error that nothing has measured.
inline constexpr double kMeasuredWithin = 1.0 / 3.0;

// kPlausible per parameter, in core units (mm or rad per the shape's reference).
inline Eigen::VectorXd PlausibleSizes(const machine::ErrorModel& model, const std::vector<Parameter>& parameters) {
  Eigen::VectorXd sizes(static_cast<Eigen::Index>(parameters.size()));
  for (size_t i = 0; i < parameters.size(); ++i) {
    const machine::ErrorTerm& term = model.terms[parameters[i].term];
    sizes[static_cast<Eigen::Index>(i)] = kPlausible * machine::AmplitudeFactor(term);
  }
  return sizes;
}

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_PLAUSIBLE_ERRORS_H_
