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

// A combination that the data determine although they cannot tell its members: "EX0B + EX0C".
struct Combination {
  std::string name;
  std::optional<double> value, sigma;  // in `unit`
  std::string unit;                    // "um", "urad"
};

// What a report of identify::ToJson names under "determined"; none when the text is no such report.
std::vector<Combination> CombinationsOf(const std::string& report_json);
// Directions that change no reading ("EX0B - EX0C"): what it names under "not_separable".
std::vector<std::string> NotSeparableOf(const std::string& report_json);

// With combinations where the record has its report.
v1::Calibration ToProto(const records::CalibrationRecord& record);
absl::StatusOr<records::CalibrationRecord> FromProto(const v1::Calibration& message);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_CALIBRATION_H_
