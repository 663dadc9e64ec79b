// Where compute-here commands get a machine and its errors from: two files, or the service.
#ifndef AXISCAL_CLIENT_CLI_ERROR_MODEL_SOURCE_H_
#define AXISCAL_CLIENT_CLI_ERROR_MODEL_SOURCE_H_

#include <string>
#include <vector>

#include "client/cli/context.h"
#include "core/machine/error_covariance.h"

namespace axiscal::cli {

struct MachineWithErrors {
  machine::Machine machine;
  machine::ErrorModel errors;
};
// The same with how well the errors are known.
struct MachineWithKnownErrors {
  machine::Machine machine;
  machine::KnownErrors errors;
};

// machine.json and errors.json. NOT_FOUND, or INVALID_ARGUMENT with the file in front.
absl::StatusOr<MachineWithErrors> ReadModelFiles(const std::string& machine_path, const std::string& errors_path);
absl::StatusOr<MachineWithKnownErrors> ReadKnownFiles(const std::string& machine_path, const std::string& errors_path);

// A stored machine as it was described when one of its calibrations, the approved one for 0, was identified.
struct MachineWithCalibration {
  machine::Machine machine;
  records::CalibrationRecord calibration;
};
absl::StatusOr<MachineWithCalibration> FetchCalibration(Context& context, const std::string& machine,
                                                        int64_t calibration);

// A stored machine under one of its calibrations, the approved one for 0.
absl::StatusOr<MachineWithErrors> FetchModel(Context& context, const std::string& machine, int64_t calibration);
absl::StatusOr<MachineWithKnownErrors> FetchKnown(Context& context, const std::string& machine, int64_t calibration);

// What --declare says, each error by itself: `EX0C,{"symbol": "EBB", "shape": "harmonic", "order": 45},EA0C`. Commas
// inside braces separate nothing.
std::vector<std::string> SplitErrors(const std::vector<std::string>& words);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_ERROR_MODEL_SOURCE_H_
