#include "server/handlers/query_drift.h"

#include "proto/convert/history.h"

namespace axiscal::handlers {

absl::StatusOr<v1::QueryDriftResponse> QueryDrift(Core& core, const Call& call, const v1::QueryDriftRequest& request) {
  ASSIGN_OR_RETURN(const records::DriftQuery query, convert::FromProto(request));
  ASSIGN_OR_RETURN(const std::vector<records::DriftSeries> all, core.database.QueryDrift(query));
  v1::QueryDriftResponse response;
  for (const records::DriftSeries& series : all) *response.add_series() = convert::ToProto(series);
  return response;
}

}  // namespace axiscal::handlers
