// Errors of an earlier identification that a later one holds at their values: the head first, then the table. They act
// on every reading and are not fitted; their uncertainty reaches what is fitted (reduction.h, CovarianceOf).
#ifndef AXISCAL_CORE_IDENTIFY_HELD_H_
#define AXISCAL_CORE_IDENTIFY_HELD_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/identify/result.h"
#include "core/machine/machine.h"

namespace axiscal::identify {

struct HeldErrors {
  machine::ErrorModel model;
  std::vector<Estimate> errors;  // ListParameters(model, true) with their values; `sigma` NaN where none is known
  // Of them, mm and rad. Zero rows where no uncertainty is known: what is fitted then holds for exactly these values.
  Eigen::MatrixXd covariance;
  std::vector<MeasuredIn> from;  // of every stage before; empty where it is not known
};

// From an errors.json, which states no uncertainties, or from a calibration as `axiscal identify --json` and
// `calibration show --json` print it ("model" and "report"). INVALID_ARGUMENT naming the entry; also for a calibration
// of another machine, one without errors, and one whose sessions could not tell an error that its model
// holds: that would take a number for what nobody measured.
absl::StatusOr<HeldErrors> ReadHeldErrors(const std::string& text, const machine::Machine& machine);

// The errors to fit beside held ones: `model` without those that are held. Where they were asked for by name, none of
// them may be held. INVALID_ARGUMENT naming the error, or where nothing is left to fit.
absl::StatusOr<machine::ErrorModel> BesideHeld(const machine::Machine& machine, const machine::ErrorModel& model,
                                               bool is_asked_for, const HeldErrors& held);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_HELD_H_
