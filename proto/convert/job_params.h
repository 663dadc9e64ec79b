// The params of jobs on the wire and in the store, which keeps the bytes of their message.
#ifndef AXISCAL_PROTO_CONVERT_JOB_PARAMS_H_
#define AXISCAL_PROTO_CONVERT_JOB_PARAMS_H_

#include <string>

#include "axiscal/v1/job.pb.h"
#include "core/base/status.h"
#include "core/nc/options.h"
#include "core/records/job_params.h"

namespace axiscal::convert {

v1::JobParams ToProto(const records::JobParams& params);
// FIELD_INVALID: no kind, no machine, no session or one twice (also once to fit and once to check), a tool tip of other
// than three finite numbers, unknown choices. Symbols, dialects and the like are judged by the engine that uses them.
absl::StatusOr<records::JobParams> FromProto(const v1::JobParams& message);
// The same of one kind.
absl::StatusOr<records::JobParams> FromProto(const v1::IdentifyParams& message);
absl::StatusOr<records::JobParams> FromProto(const v1::CloseLoopParams& message);

v1::CompensateParams ToProto(const records::CompensateParams& params);
// Of a program that is stored (`needs_program`), or of one that comes with the call and has no id.
absl::StatusOr<records::CompensateParams> FromProto(const v1::CompensateParams& message, bool needs_program);

v1::RewriteOptions ToProto(const nc::RewriteOptions& options);
// Unset fields take the defaults of nc::RewriteOptions.
absl::StatusOr<nc::RewriteOptions> FromProto(const v1::RewriteOptions& message);

// The bytes that the store keeps, and back. Equal params have equal bytes.
std::string Serialize(const records::JobParams& params);
absl::StatusOr<records::JobParams> ParseJobParams(const std::string& bytes);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_JOB_PARAMS_H_
