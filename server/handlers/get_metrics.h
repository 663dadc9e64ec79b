// What a monitoring system asks for (server/metrics).
#ifndef AXISCAL_SERVER_HANDLERS_GET_METRICS_H_
#define AXISCAL_SERVER_HANDLERS_GET_METRICS_H_

#include <string>
#include <vector>

#include "axiscal/v1/admin_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

// A store that does not answer is a gauge, no error.
absl::StatusOr<v1::GetMetricsResponse> GetMetrics(Core& core, const Call& call, const v1::GetMetricsRequest& request);

// The methods of the API as they are counted.
std::vector<metrics::Method> CountedMethods();

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_GET_METRICS_H_
