// Errors of an earlier identification that a later one holds at their values: the head first, then the table. They act
// on every reading and are not fitted; their uncertainty reaches what is fitted (reduction.h, CovarianceOf).
#ifndef AXISCAL_CORE_IDENTIFY_HELD_H_
#define AXISCAL_CORE_IDENTIFY_HELD_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/identify/result.h"
#include "core/machine/machine.h"
#include "core/reports/calibration.h"

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
// The same of a calibration's model and report as they are stored.
absl::StatusOr<HeldErrors> ReadHeldErrors(const std::string& model_json, const std::string& report_json,
                                          const machine::Machine& machine);

// `model` with what the report of its identification says of its uncertainties. INVALID_ARGUMENT as above.
absl::StatusOr<HeldErrors> HoldErrors(machine::ErrorModel model,
                                      const std::optional<reports::CalibrationReport>& report,
                                      const machine::Machine& machine);

// Of an errors.json or a calibration, as ReadHeldErrors reads them, the constant errors that `names` name; what else it
// holds is dropped. INVALID_ARGUMENT for text that is no JSON and, beginning with `option`, for a name that it does not
// hold.
absl::StatusOr<std::string> OnlyConstants(const std::string& option, const std::vector<std::string>& names,
                                          const std::string& text);

// The errors to fit beside held ones: `model` without those that are held. Where they were asked for by name, none of
// them may be held. INVALID_ARGUMENT naming the error, or where nothing is left to fit.
absl::StatusOr<machine::ErrorModel> BesideHeld(const machine::Machine& machine, const machine::ErrorModel& model,
                                               bool is_asked_for, const HeldErrors& held);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_HELD_H_
