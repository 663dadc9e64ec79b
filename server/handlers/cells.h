// Ingest.ReportCell, ListCells and ForgetCell: how cells beside machines stand.
#ifndef AXISCAL_SERVER_HANDLERS_CELLS_H_
#define AXISCAL_SERVER_HANDLERS_CELLS_H_

#include "axiscal/v1/ingest_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ReportCellResponse> ReportCell(Core& core, const Call& call, const v1::ReportCellRequest& request);
absl::StatusOr<v1::ListCellsResponse> ListCells(Core& core, const Call& call, const v1::ListCellsRequest& request);
absl::StatusOr<v1::ForgetCellResponse> ForgetCell(Core& core, const Call& call, const v1::ForgetCellRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_CELLS_H_
