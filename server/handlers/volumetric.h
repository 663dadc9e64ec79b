// The tool point's error before and after calibrations: Calibrations.GetVolumetricError, ListVolumetricErrors.
#ifndef AXISCAL_SERVER_HANDLERS_VOLUMETRIC_H_
#define AXISCAL_SERVER_HANDLERS_VOLUMETRIC_H_

#include "axiscal/v1/calibrations_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::GetVolumetricErrorResponse> GetVolumetricError(Core& core, const Call& call,
                                                                  const v1::GetVolumetricErrorRequest& request);
absl::StatusOr<v1::ListVolumetricErrorsResponse> ListVolumetricErrors(Core& core, const Call& call,
                                                                      const v1::ListVolumetricErrorsRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_VOLUMETRIC_H_
