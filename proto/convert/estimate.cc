// States, units, estimates and named combinations of calibrations.
#include "proto/convert/calibration.h"
#include "proto/convert/field.h"

namespace axiscal::convert {
v1::CalibrationState ToProto(records::CalibrationState state) {
  switch (state) {
    case records::CalibrationState::kCandidate:
      return v1::CALIBRATION_STATE_CANDIDATE;
    case records::CalibrationState::kApproved:
      return v1::CALIBRATION_STATE_APPROVED;
    case records::CalibrationState::kRetired:
      return v1::CALIBRATION_STATE_RETIRED;
  }
  return v1::CALIBRATION_STATE_UNSPECIFIED;
}

absl::StatusOr<records::CalibrationState> FromProto(v1::CalibrationState state) {
  switch (state) {
    case v1::CALIBRATION_STATE_CANDIDATE:
      return records::CalibrationState::kCandidate;
    case v1::CALIBRATION_STATE_APPROVED:
      return records::CalibrationState::kApproved;
    case v1::CALIBRATION_STATE_RETIRED:
      return records::CalibrationState::kRetired;
    default:
      return FieldError("state", absl::StrCat(static_cast<int>(state), ", must be CANDIDATE, APPROVED or RETIRED"));
  }
}

v1::EstimateUnit ToProto(records::EstimateUnit unit) {
  return unit == records::EstimateUnit::kUm ? v1::ESTIMATE_UNIT_UM : v1::ESTIMATE_UNIT_URAD;
}

absl::StatusOr<records::EstimateUnit> FromProto(v1::EstimateUnit unit) {
  if (unit == v1::ESTIMATE_UNIT_UM) return records::EstimateUnit::kUm;
  if (unit == v1::ESTIMATE_UNIT_URAD) return records::EstimateUnit::kUrad;
  return FieldError("unit", absl::StrCat(static_cast<int>(unit), ", must be UM or URAD"));
}

v1::Estimate ToProto(const records::Estimate& estimate) {
  v1::Estimate message;
  message.set_symbol(estimate.symbol);
  message.set_unit(ToProto(estimate.unit));
  message.set_identifiable(estimate.identifiable);
  if (estimate.value) message.set_value(*estimate.value);
  if (estimate.sigma) message.set_sigma(*estimate.sigma);
  return message;
}

absl::StatusOr<records::Estimate> FromProto(const v1::Estimate& message) {
  RETURN_IF_ERROR(RequireText("symbol", message.symbol(), 1, 100));
  records::Estimate estimate;
  estimate.symbol = message.symbol();
  ASSIGN_OR_RETURN(estimate.unit, FromProto(message.unit()));
  estimate.identifiable = message.identifiable();
  if (message.identifiable()) RETURN_IF_ERROR(RequireMessage("value", message.has_value()));
  if (message.has_value()) {
    RETURN_IF_ERROR(RequireFinite("value", message.value()));
    estimate.value = message.value();
  }
  if (message.has_sigma()) {
    RETURN_IF_ERROR(RequireFinite("sigma", message.sigma()));
    if (message.sigma() < 0) return FieldError("sigma", absl::StrCat(message.sigma(), ", must be >= 0"));
    estimate.sigma = message.sigma();
  }
  return estimate;
}

}  // namespace axiscal::convert
