// The member `covariance` of errors.json, for the readers of that file.
#ifndef AXISCAL_CORE_MACHINE_ERROR_COVARIANCE_JSON_H_
#define AXISCAL_CORE_MACHINE_ERROR_COVARIANCE_JSON_H_

#include <nlohmann/json_fwd.hpp>

#include "core/machine/error_covariance.h"

namespace axiscal::machine {

// Its form, and its names against the model's. Whether the correlations contradict each other is not looked at.
// INVALID_ARGUMENT naming entry and rule.
absl::StatusOr<WrittenCovariance> ReadWrittenCovariance(const nlohmann::ordered_json& member, const Machine& machine,
                                                        const ErrorModel& model);

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_ERROR_COVARIANCE_JSON_H_
