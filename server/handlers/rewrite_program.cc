#include "server/handlers/rewrite_program.h"

#include "core/base/crc32c.h"
#include "core/base/error_detail.h"
#include "proto/convert/field.h"
#include "proto/convert/program.h"

namespace axiscal::handlers {

RewriteProgramStream::RewriteProgramStream(Core& core, const Call& call,
                                           std::function<bool(const v1::RewriteProgramResponse&)> send)
    : core_(core), call_(call), send_(std::move(send)) {}

absl::Status RewriteProgramStream::Receive(const v1::RewriteProgramRequest& request) {
  RETURN_IF_ERROR(RequireAccepting(core_));
  RETURN_IF_ERROR(received_.CheckOrder(request.has_header(), request.part_case() == v1::RewriteProgramRequest::kData));
  return received_.is_declared() ? Rewrite(request.data()) : Begin(request.header());
}

absl::Status RewriteProgramStream::Begin(const v1::RewriteProgramHeader& header) {
  RETURN_IF_ERROR(convert::RequireNotNegative("header.size_bytes", header.size_bytes()));
  absl::StatusOr<records::CompensateParams> params = convert::FromProto(header.params(), false);
  if (!params.ok()) return convert::InField("header.params", params.status());
  ASSIGN_OR_RETURN(const records::MachineRecord machine, core_.database.GetMachine(params->machine));
  if (machine.deleted_at) {
    return base::Error(absl::StatusCode::kFailedPrecondition, "machine " + machine.id.text() + " is deleted",
                       {"MACHINE_DELETED", {}});
  }
  ASSIGN_OR_RETURN(inputs::Compensation compensation,
                   inputs::CompensationFor(core_.database, *params, "header.params"));
  compensation_.emplace(std::move(compensation));
  compensation_->options.source_crc32c = header.crc32c();
  ASSIGN_OR_RETURN(nc::Rewriter rewriter,
                   nc::Rewriter::Create(compensation_->compensator, compensation_->options,
                                        [this](const char* bytes, size_t size) { return Take(bytes, size); }));
  rewriter_.emplace(std::move(rewriter));
  header_ = header;
  received_.Declare(header.size_bytes());
  return absl::OkStatus();
}

absl::Status RewriteProgramStream::Rewrite(const std::string& bytes) {
  RETURN_IF_ERROR(received_.Take(bytes));
  received_crc32c_ = base::Crc32c(received_crc32c_, bytes.data(), bytes.size());
  return rewriter_->Feed(bytes.data(), bytes.size());
}

absl::Status RewriteProgramStream::Take(const char* bytes, size_t size) {
  sent_ += static_cast<int64_t>(size);
  sent_crc32c_ = base::Crc32c(sent_crc32c_, bytes, size);
  std::string& data = *response_.mutable_data();
  while (size > 0) {
    const size_t count = std::min(size, static_cast<size_t>(convert::kMaxProgramPartBytes) - data.size());
    data.append(bytes, count);
    bytes += count;
    size -= count;
    if (data.size() == static_cast<size_t>(convert::kMaxProgramPartBytes)) RETURN_IF_ERROR(SendData());
  }
  return absl::OkStatus();
}

absl::Status RewriteProgramStream::SendData() {
  if (!send_(response_)) {
    return base::Error(absl::StatusCode::kCancelled, "the caller has left", {"CALLER_GONE", {}});
  }
  response_.mutable_data()->clear();
  return absl::OkStatus();
}

absl::Status RewriteProgramStream::End() {
  RETURN_IF_ERROR(received_.CheckEnd());
  if (received_crc32c_ != header_.crc32c()) {
    return base::Error(
        absl::StatusCode::kFailedPrecondition,
        absl::StrFormat("the header says CRC-32C %08x, what came has %08x", header_.crc32c(), received_crc32c_),
        {"TOTALS_MISMATCH", {}});
  }
  RETURN_IF_ERROR(rewriter_->Finish());
  if (!response_.data().empty()) RETURN_IF_ERROR(SendData());
  nc::RewriteReport report = rewriter_->report();
  compensation_->AddTo(&report);
  v1::RewriteProgramResult& result = *response_.mutable_result();
  result.set_size_bytes(sent_);
  result.set_crc32c(sent_crc32c_);
  result.set_calibration_id(compensation_->calibration.id.number());
  result.set_report_json(reports::ToJson(nc::ReportOf(report)));
  if (!send_(response_)) {
    return base::Error(absl::StatusCode::kCancelled, "the caller has left", {"CALLER_GONE", {}});
  }
  return absl::OkStatus();
}

}  // namespace axiscal::handlers
