// History.ListCare: what each machine of a page needs.
#ifndef AXISCAL_SERVER_HANDLERS_LIST_CARE_H_
#define AXISCAL_SERVER_HANDLERS_LIST_CARE_H_

#include "axiscal/v1/history_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ListCareResponse> ListCare(Core& core, const Call& call, const v1::ListCareRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_LIST_CARE_H_
