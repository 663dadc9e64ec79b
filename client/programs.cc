// NC programs to and from the server.
#include <filesystem>
#include <fstream>

#include "axiscal/v1/programs_service.grpc.pb.h"
#include "client/connection.h"
#include "client/transfer.h"
#include "core/base/error_detail.h"
#include "core/base/files.h"
#include "core/base/sha256.h"
#include "proto/convert/program.h"

namespace axiscal::client {
namespace {

// Writes header and bytes as far as the stream takes them; an error is the source's.
absl::Status SendProgram(grpc::ClientWriter<v1::PutProgramRequest>& writer, const v1::PutProgramHeader& header,
                         const ProgramSource& source, const ProgressCallback& progress, int interruptions) {
  v1::PutProgramRequest request;
  *request.mutable_header() = header;
  bool is_open = writer.Write(request);
  for (int64_t offset = 0; is_open && offset < source.size;) {
    ASSIGN_OR_RETURN(std::string bytes, source.read_at(offset, convert::kMaxProgramPartBytes));
    if (bytes.empty()) return absl::DataLossError(source.name + " became shorter while it was sent");
    offset += static_cast<int64_t>(bytes.size());
    request.set_data(std::move(bytes));
    is_open = writer.Write(request);
    if (is_open && progress) progress({offset, source.size, interruptions});
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ProgramRecord> PutProgram(const Connection& connection, const ProgramSource& source,
                                         const ProgressCallback& progress) {
  const auto stub = v1::Programs::NewStub(connection.channel());
  v1::PutProgramHeader header;
  header.set_name(source.name);
  header.set_size_bytes(source.size);
  header.set_sha256(source.sha256);
  header.set_request_id(NewRequestId());
  Backoff backoff(connection.options());
  const base::SteadyTime give_up = base::SystemClock().SteadyNow() + connection.options().give_up_after;
  for (int interruptions = 0;; ++interruptions) {
    const auto context = connection.NewStreamContext();
    v1::PutProgramResponse response;
    const auto writer = stub->PutProgram(context.get(), &response);
    const absl::Status sent = SendProgram(*writer, header, source, progress, interruptions);
    if (!sent.ok()) context->TryCancel();
    writer->WritesDone();
    const absl::Status status = connection.FromGrpc(writer->Finish());
    RETURN_IF_ERROR(sent);
    if (status.ok()) return convert::FromProto(response.program());
    const bool is_cut = absl::IsUnavailable(status) || base::ErrorReason(status) == "STREAM_INCOMPLETE";
    if (!is_cut || !backoff.Wait(give_up)) return status;
  }
}

absl::StatusOr<ProgramRecord> GetProgram(const Connection& connection, ProgramId id, const TakeBytes& take,
                                         const ProgressCallback& progress) {
  const auto stub = v1::Programs::NewStub(connection.channel());
  v1::GetProgramRequest request;
  request.set_program_id(id.number());
  base::Sha256 sha;
  ProgramRecord record;
  int64_t received = 0;
  Backoff backoff(connection.options());
  base::SteadyTime give_up = base::SystemClock().SteadyNow() + connection.options().give_up_after;
  for (int interruptions = 0;; ++interruptions) {
    request.set_offset_bytes(received);
    const auto context = connection.NewStreamContext();
    const auto reader = stub->GetProgram(context.get(), request);
    v1::GetProgramResponse message;
    absl::Status taken;
    while (taken.ok() && reader->Read(&message)) {
      if (message.has_program()) {
        absl::StatusOr<ProgramRecord> head = convert::FromProto(message.program());
        taken = head.status();
        if (head.ok()) record = *std::move(head);
        continue;
      }
      sha.Add(message.data());
      received += static_cast<int64_t>(message.data().size());
      taken = take(message.data());
      give_up = base::SystemClock().SteadyNow() + connection.options().give_up_after;
      if (progress) progress({received, record.byte_count, interruptions});
    }
    if (!taken.ok()) context->TryCancel();
    const absl::Status status = connection.FromGrpc(reader->Finish());
    RETURN_IF_ERROR(taken);
    if (status.ok() && record.id == id && received == record.byte_count) break;
    if (!status.ok() && !absl::IsUnavailable(status)) return status;
    if (!backoff.Wait(give_up))
      return status.ok() ? absl::UnavailableError("the program ended before its end") : status;
  }
  if (sha.HexDigest() != record.sha256) return absl::DataLossError("the program's checksum does not fit what came");
  return record;
}

absl::StatusOr<ProgramSource> FileSource(const std::string& path) {
  RETURN_IF_ERROR(base::RequireFile(path));
  auto file = std::make_shared<std::ifstream>(path, std::ios::binary);
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (!*file || error) return absl::NotFoundError(path + ": cannot be read");
  ProgramSource source{std::filesystem::path(path).filename().string(), static_cast<int64_t>(size), "", nullptr};
  source.read_at = [file, path](int64_t offset, int64_t bytes) -> absl::StatusOr<std::string> {
    std::string part(static_cast<size_t>(bytes), '\0');
    file->clear();
    file->seekg(offset);
    file->read(part.data(), bytes);
    if (file->bad()) return absl::DataLossError(path + ": cannot be read");
    part.resize(static_cast<size_t>(file->gcount()));
    return part;
  };
  base::Sha256 sha;
  for (int64_t offset = 0; offset < source.size;) {
    ASSIGN_OR_RETURN(const std::string part, source.read_at(offset, convert::kMaxProgramPartBytes));
    if (part.empty()) return absl::DataLossError(path + " became shorter while it was read");
    sha.Add(part);
    offset += static_cast<int64_t>(part.size());
  }
  source.sha256 = sha.HexDigest();
  return source;
}

}  // namespace axiscal::client
