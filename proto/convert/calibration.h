// Calibrations and their estimates on the wire.
#ifndef AXISCAL_PROTO_CONVERT_CALIBRATION_H_
#define AXISCAL_PROTO_CONVERT_CALIBRATION_H_

#include "axiscal/v1/calibration.pb.h"
#include "core/base/status.h"
#include "core/records/calibration.h"

namespace axiscal::convert {

v1::CalibrationState ToProto(records::CalibrationState state);
absl::StatusOr<records::CalibrationState> FromProto(v1::CalibrationState state);
v1::EstimateUnit ToProto(records::EstimateUnit unit);
absl::StatusOr<records::EstimateUnit> FromProto(v1::EstimateUnit unit);

v1::Estimate ToProto(const records::Estimate& estimate);
// FIELD_INVALID: no symbol, no unit, NaN, a negative sigma, an identifiable error without value.
absl::StatusOr<records::Estimate> FromProto(const v1::Estimate& message);

// With what its report names as determined and as not separable, where the record has a report.
v1::Calibration ToProto(const records::CalibrationRecord& record);
absl::StatusOr<records::CalibrationRecord> FromProto(const v1::Calibration& message);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_CALIBRATION_H_
