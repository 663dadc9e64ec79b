// A program that comes up and goes down corrected, in one request: Programs.RewriteProgram, which stores nothing. It is
// answered when the whole of it is there, so that nobody has a part of a program that was refused farther on.
#include <google/protobuf/util/json_util.h>

#include <thread>

#include "absl/strings/ascii.h"
#include "axiscal/v1/programs_service.grpc.pb.h"
#include "core/base/crc32c.h"
#include "core/base/error_detail.h"
#include "proto/convert/program.h"
#include "proto/convert/status.h"
#include "server/http/errors.h"
#include "server/http/forward.h"
#include "server/http/plain.h"

namespace axiscal::http {
namespace {

constexpr char kParams[] = "axiscal-params";

absl::Status WrongParams(const std::string& text) {
  return base::Error(absl::StatusCode::kInvalidArgument, "Axiscal-Params: " + text, {"MESSAGE_INVALID", {}});
}

// How to rewrite: CompensateParams as JSON, in a field. The machine is the path's and the program is the body.
absl::StatusOr<v1::CompensateParams> ParamsOf(const Request& request, const std::string& machine) {
  v1::CompensateParams params;
  const std::string json = request.Field(kParams);
  if (!json.empty()) {
    const auto read = google::protobuf::util::JsonStringToMessage(json, &params);
    if (!read.ok()) return WrongParams(std::string(read.message()));
  }
  if (!params.machine_id().empty() && params.machine_id() != machine)
    return WrongParams("machineId is '" + params.machine_id() + "', the path says '" + machine + "'");
  if (params.program_id() != 0) return WrongParams("programId: the program is the body");
  params.set_machine_id(machine);
  return params;
}

using RewriteStream = grpc::ClientReaderWriter<v1::RewriteProgramRequest, v1::RewriteProgramResponse>;

void Send(RewriteStream& stream, const v1::CompensateParams& params, const std::string& bytes) {
  v1::RewriteProgramRequest message;
  *message.mutable_header()->mutable_params() = params;
  message.mutable_header()->set_size_bytes(static_cast<int64_t>(bytes.size()));
  message.mutable_header()->set_crc32c(base::Crc32c(0, bytes.data(), bytes.size()));
  bool is_open = stream.Write(message);
  for (size_t at = 0; is_open && at < bytes.size(); at += convert::kMaxProgramPartBytes) {
    message.set_data(bytes.substr(at, convert::kMaxProgramPartBytes));
    is_open = stream.Write(message);
  }
  stream.WritesDone();
}

struct Rewritten {
  std::string bytes;
  v1::RewriteProgramResult result;
};

absl::StatusOr<Rewritten> Rewrite(const PlainCall& call, const v1::CompensateParams& params, handlers::Share& share) {
  ASSIGN_OR_RETURN(const std::unique_ptr<ForwardedCall> forwarded,
                   ForwardedCall::Begin(call.core, call.request, call.credentials, call.exchange));
  const auto stub = v1::Programs::NewStub(call.channel);
  const auto stream = stub->RewriteProgram(&forwarded->context());
  // Both ways at a time: the server reads no more while nobody takes what it has rewritten.
  std::thread sender([&] { Send(*stream, params, call.request.body); });
  Rewritten rewritten;
  absl::Status taken;
  v1::RewriteProgramResponse message;
  while (taken.ok() && stream->Read(&message)) {
    if (message.has_result()) rewritten.result = message.result();
    if (message.part_case() != v1::RewriteProgramResponse::kData) continue;
    taken = share.Take(static_cast<int64_t>(message.data().size()));
    rewritten.bytes += message.data();
  }
  if (!taken.ok()) forwarded->context().TryCancel();
  sender.join();
  const grpc::Status ended = stream->Finish();
  RETURN_IF_ERROR(taken);
  if (!ended.ok()) return convert::FromProto(ErrorOf(ended));
  return rewritten;
}

// Whether the caller wants the report and not the program.
bool WantsReport(const Request& request) {
  for (const std::string& word : Words(request.Field("accept"), ',')) {
    if (absl::AsciiStrToLower(word.substr(0, word.find(';'))) == "application/json") return true;
  }
  return false;
}

absl::StatusOr<Answer> AnswerTo(const PlainCall& call, const std::string& machine) {
  ASSIGN_OR_RETURN(const v1::CompensateParams params, ParamsOf(call.request, machine));
  handlers::Share share(call.budget, call.request.counted_as);
  ASSIGN_OR_RETURN(Rewritten rewritten, Rewrite(call, params, share));
  const bool wants_report = WantsReport(call.request);
  return Answer{200,
                {{"Content-Type", wants_report ? "application/json" : "application/octet-stream"},
                 {"Cache-Control", "no-store"},
                 {"Axiscal-Calibration", std::to_string(rewritten.result.calibration_id())}},
                wants_report ? std::move(*rewritten.result.mutable_report_json()) : std::move(rewritten.bytes)};
}

}  // namespace

void RewriteProgram(const PlainCall& call, const std::string& machine) {
  absl::StatusOr<Answer> answer = AnswerTo(call, machine);
  call.exchange.Send(answer.ok() ? *std::move(answer) : ErrorAnswer(answer.status()));
}

}  // namespace axiscal::http
