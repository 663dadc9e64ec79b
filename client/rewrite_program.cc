// A program up and its rewritten form down, in one call.
#include <thread>

#include "axiscal/v1/programs_service.grpc.pb.h"
#include "client/connection.h"
#include "client/transfer.h"
#include "core/base/crc32c.h"
#include "proto/convert/job_params.h"
#include "proto/convert/program.h"

namespace axiscal::client {
namespace {

absl::Status Shorter(const ProgramSource& source) {
  return absl::DataLossError(source.name + " became shorter while it was read");
}

absl::StatusOr<uint32_t> Crc32cOf(const ProgramSource& source) {
  uint32_t crc32c = 0;
  for (int64_t offset = 0; offset < source.size;) {
    ASSIGN_OR_RETURN(const std::string bytes, source.read_at(offset, convert::kMaxProgramPartBytes));
    if (bytes.empty()) return Shorter(source);
    crc32c = base::Crc32c(crc32c, bytes.data(), bytes.size());
    offset += static_cast<int64_t>(bytes.size());
  }
  return crc32c;
}

using Stream = grpc::ClientReaderWriter<v1::RewriteProgramRequest, v1::RewriteProgramResponse>;

// As far as the stream takes it; an error is the source's.
absl::Status Send(Stream& stream, const v1::RewriteProgramHeader& header, const ProgramSource& source) {
  v1::RewriteProgramRequest request;
  *request.mutable_header() = header;
  bool is_open = stream.Write(request);
  for (int64_t offset = 0; is_open && offset < source.size;) {
    ASSIGN_OR_RETURN(std::string bytes, source.read_at(offset, convert::kMaxProgramPartBytes));
    if (bytes.empty()) return Shorter(source);
    offset += static_cast<int64_t>(bytes.size());
    request.set_data(std::move(bytes));
    is_open = stream.Write(request);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::string> RewriteProgram(const Connection& connection, const records::CompensateParams& params,
                                           const ProgramSource& source, const TakeBytes& take) {
  v1::RewriteProgramHeader header;
  *header.mutable_params() = convert::ToProto(params);
  header.set_size_bytes(source.size);
  ASSIGN_OR_RETURN(const uint32_t source_crc32c, Crc32cOf(source));
  header.set_crc32c(source_crc32c);
  const auto stub = v1::Programs::NewStub(connection.channel());
  const auto context = connection.NewStreamContext();
  const auto stream = stub->RewriteProgram(context.get());
  absl::Status sent, taken;
  std::thread sender([&] {
    sent = Send(*stream, header, source);
    if (!sent.ok()) context->TryCancel();
    stream->WritesDone();
  });
  v1::RewriteProgramResponse message;
  v1::RewriteProgramResult result;
  uint32_t crc32c = 0;
  int64_t received = 0;
  while (taken.ok() && stream->Read(&message)) {
    if (message.has_result()) result = message.result();
    if (message.part_case() != v1::RewriteProgramResponse::kData) continue;
    crc32c = base::Crc32c(crc32c, message.data().data(), message.data().size());
    received += static_cast<int64_t>(message.data().size());
    taken = take(message.data());
  }
  if (!taken.ok()) context->TryCancel();
  sender.join();
  const absl::Status status = connection.FromGrpc(stream->Finish());
  RETURN_IF_ERROR(sent);
  RETURN_IF_ERROR(taken);
  RETURN_IF_ERROR(status);
  if (result.size_bytes() != received || result.crc32c() != crc32c || result.report_json().empty()) {
    return absl::DataLossError("the rewritten program's size and checksum do not fit what came");
  }
  return result.report_json();
}

}  // namespace axiscal::client
