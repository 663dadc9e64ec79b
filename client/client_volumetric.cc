// The tool point's error before and after calibrations.
#include "client/client_impl.h"
#include "proto/convert/volumetric.h"

namespace axiscal::client {

absl::StatusOr<records::VolumetricError> Client::GetVolumetricError(CalibrationId id,
                                                                    const std::vector<records::AxisSpan>& box,
                                                                    std::optional<JobId> job) {
  v1::GetVolumetricErrorRequest request;
  request.set_calibration_id(id.number());
  for (const records::AxisSpan& span : box) *request.add_box() = convert::ToProto(span);
  if (job) request.set_job_id(job->number());
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::GetVolumetricErrorResponse>(*impl_->calibrations,
                                                               &v1::Calibrations::Stub::GetVolumetricError, request));
  return convert::FromProto(response.error());
}

absl::StatusOr<Page<records::VolumetricError>> Client::ListVolumetricErrors(const MachineId& machine,
                                                                            const std::vector<records::AxisSpan>& box,
                                                                            const PageRequest& page) {
  v1::ListVolumetricErrorsRequest request;
  request.set_machine_id(machine.text());
  for (const records::AxisSpan& span : box) *request.add_box() = convert::ToProto(span);
  request.set_page_size(page.size);
  request.set_page_token(page.token);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ListVolumetricErrorsResponse>(
                       *impl_->calibrations, &v1::Calibrations::Stub::ListVolumetricErrors, request));
  Page<records::VolumetricError> errors;
  for (const v1::VolumetricError& message : response.errors()) {
    ASSIGN_OR_RETURN(errors.rows.emplace_back(), convert::FromProto(message));
  }
  errors.next_token = response.next_page_token();
  return errors;
}

}  // namespace axiscal::client
