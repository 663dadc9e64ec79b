// History.QueryDrift: the identified errors of one machine over time.
#ifndef AXISCAL_SERVER_HANDLERS_QUERY_DRIFT_H_
#define AXISCAL_SERVER_HANDLERS_QUERY_DRIFT_H_

#include "axiscal/v1/history_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::QueryDriftResponse> QueryDrift(Core& core, const Call& call, const v1::QueryDriftRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_QUERY_DRIFT_H_
