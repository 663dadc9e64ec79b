// Cells beside machines.
#include "client/client_impl.h"

namespace axiscal::client {

absl::StatusOr<records::CellRecord> Client::ReportCell(const records::CellReport& report) {
  v1::ReportCellRequest request;
  *request.mutable_report() = convert::ToProto(report);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ReportCellResponse>(*impl_->ingest, &v1::Ingest::Stub::ReportCell, request));
  return convert::FromProto(response.cell());
}

absl::StatusOr<Page<records::CellRecord>> Client::ListCells(const std::optional<MachineId>& machine,
                                                            const PageRequest& page) {
  auto request = PageOf<v1::ListCellsRequest>(page);
  if (machine) request.set_machine_id(machine->text());
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ListCellsResponse>(*impl_->ingest, &v1::Ingest::Stub::ListCells, request));
  return ReadPage<records::CellRecord>(response.cells(), response.next_page_token());
}

absl::Status Client::ForgetCell(const MachineId& machine, const std::string& name) {
  v1::ForgetCellRequest request;
  request.set_machine_id(machine.text());
  request.set_name(name);
  return impl_->Call<v1::ForgetCellResponse>(*impl_->ingest, &v1::Ingest::Stub::ForgetCell, request).status();
}

}  // namespace axiscal::client
