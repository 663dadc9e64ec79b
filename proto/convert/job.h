// Jobs on the wire.
#ifndef AXISCAL_PROTO_CONVERT_JOB_H_
#define AXISCAL_PROTO_CONVERT_JOB_H_

#include "axiscal/v1/job.pb.h"
#include "core/base/status.h"
#include "core/records/job.h"
#include "proto/convert/job_params.h"

namespace axiscal::convert {

v1::JobState ToProto(records::JobState state);
absl::StatusOr<records::JobState> FromProto(v1::JobState state);

// `record.params` must be the bytes of Serialize(), `record.result` the report's text.
v1::Job ToProto(const records::JobRecord& record);
// FIELD_INVALID: an id that is none, a state that is none, progress outside 0 to 1. Params that this side does not know
// are kept as bytes.
absl::StatusOr<records::JobRecord> FromProto(const v1::Job& message);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_JOB_H_
