// A controller's log to the server, sent again whole where the stream breaks.
#include "axiscal/v1/ingest_service.grpc.pb.h"
#include "client/connection.h"
#include "client/transfer.h"
#include "core/base/error_detail.h"
#include "core/base/sha256.h"
#include "proto/convert/log.h"
#include "proto/convert/program.h"

namespace axiscal::client {

absl::StatusOr<records::StoredLog> PutLog(const Connection& connection, const MachineId& machine,
                                          const std::string& name, const std::string& bytes,
                                          const records::LogForm& form) {
  const auto stub = v1::Ingest::NewStub(connection.channel());
  v1::PutLogHeader header;
  header.set_machine_id(machine.text());
  header.set_name(name);
  header.set_size_bytes(static_cast<int64_t>(bytes.size()));
  header.set_sha256(base::Sha256Hex(bytes));
  header.set_request_id(records::LogId(machine.text(), name, form, header.sha256()));
  *header.mutable_form() = convert::ToProto(form);
  Backoff backoff(connection.options());
  const base::SteadyTime give_up = base::SystemClock().SteadyNow() + connection.options().give_up_after;
  while (true) {
    const auto context = connection.NewStreamContext();
    v1::PutLogResponse response;
    const auto writer = stub->PutLog(context.get(), &response);
    v1::PutLogRequest request;
    *request.mutable_header() = header;
    bool is_open = writer->Write(request);
    for (size_t at = 0; is_open && at < bytes.size(); at += convert::kMaxProgramPartBytes) {
      request.set_data(bytes.substr(at, convert::kMaxProgramPartBytes));
      is_open = writer->Write(request);
    }
    writer->WritesDone();
    const absl::Status status = connection.FromGrpc(writer->Finish());
    if (status.ok()) return convert::FromProto(response);
    const bool is_cut = absl::IsUnavailable(status) || base::ErrorReason(status) == "STREAM_INCOMPLETE";
    if (!is_cut || !backoff.Wait(give_up)) return status;
  }
}

}  // namespace axiscal::client
