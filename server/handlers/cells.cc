#include "server/handlers/cells.h"

#include "proto/convert/cell.h"
#include "proto/convert/field.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ReportCellResponse> ReportCell(Core& core, const Call& call, const v1::ReportCellRequest& request) {
  const absl::StatusOr<records::CellReport> report = convert::FromProto(request.report());
  if (!report.ok()) return convert::InField("report", report.status());
  ASSIGN_OR_RETURN(const records::CellRecord cell, core.database.ReportCell(*report, call.By()));
  // The watcher looks at it every minute; what wants a person, and what is well again, is told at once.
  core.look_soon(report->machine);
  v1::ReportCellResponse response;
  *response.mutable_cell() = convert::ToProto(cell);
  return response;
}

absl::StatusOr<v1::ListCellsResponse> ListCells(Core& core, const Call& call, const v1::ListCellsRequest& request) {
  std::optional<MachineId> machine;
  if (!request.machine_id().empty()) machine = MachineId(request.machine_id());
  ASSIGN_OR_RETURN(const records::PageRequest page, PageFrom(request.page_size(), request.page_token()));
  ASSIGN_OR_RETURN(const auto cells, core.database.ListCells(machine, page, call.visible));
  v1::ListCellsResponse response;
  for (const records::CellRecord& cell : cells.rows) *response.add_cells() = convert::ToProto(cell);
  response.set_next_page_token(cells.next_token);
  return response;
}

absl::StatusOr<v1::ForgetCellResponse> ForgetCell(Core& core, const Call& call, const v1::ForgetCellRequest& request) {
  RETURN_IF_ERROR(convert::RequireText("machine_id", request.machine_id(), 1, 255));
  RETURN_IF_ERROR(convert::RequireText("name", request.name(), 1, 64));
  const MachineId machine(request.machine_id());
  RETURN_IF_ERROR(core.database.ForgetCell(machine, request.name(), call.By()));
  core.look_soon(machine);
  return v1::ForgetCellResponse();
}

}  // namespace axiscal::handlers
