// The refusals that every kind of row shares.
#ifndef AXISCAL_SERVER_STORAGE_REFUSAL_H_
#define AXISCAL_SERVER_STORAGE_REFUSAL_H_

#include <string>

#include "core/base/error_detail.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// NOT_FOUND SESSION_NOT_FOUND "session 12 does not exist".
inline absl::Status NotFound(const std::string& kind, const std::string& reason_kind, const std::string& id) {
  return base::Error(absl::StatusCode::kNotFound, absl::StrCat(kind, " ", id, " does not exist"),
                     {reason_kind + "_NOT_FOUND", {{kind, id}}});
}

// The same of any row: also what a caller hears of one that is none of its business.
inline absl::Status Missing(const Resource& resource) {
  switch (resource.kind) {
    case ResourceKind::kMachine:
      return NotFound("machine", "MACHINE", resource.name);
    case ResourceKind::kSession:
      return NotFound("session", "SESSION", std::to_string(resource.number));
    case ResourceKind::kJob:
      return NotFound("job", "JOB", std::to_string(resource.number));
    case ResourceKind::kCalibration:
      return NotFound("calibration", "CALIBRATION", std::to_string(resource.number));
    case ResourceKind::kProgram:
      return NotFound("program", "PROGRAM", std::to_string(resource.number));
    case ResourceKind::kMark:
      return NotFound("mark", "MARK", std::to_string(resource.number));
    case ResourceKind::kEvent:
      return NotFound("event", "EVENT", std::to_string(resource.number));
  }
  return absl::NotFoundError("does not exist");
}

// ABORTED ETAG_MISMATCH unless `expected` is 0 or what is there.
inline absl::Status CheckEtag(const std::string& what, int64_t expected, int64_t present) {
  if (expected == 0 || expected == present) return absl::OkStatus();
  return base::Error(absl::StatusCode::kAborted,
                     absl::StrCat(what, " was changed meanwhile: etag = ", expected, ", present ", present),
                     {"ETAG_MISMATCH", {{"etag", std::to_string(present)}}});
}

inline absl::Status FailedPrecondition(const std::string& message, const std::string& reason) {
  return base::Error(absl::StatusCode::kFailedPrecondition, message, {reason, {}});
}

inline absl::Status InvalidArgument(const std::string& message, const std::string& reason) {
  return base::Error(absl::StatusCode::kInvalidArgument, message, {reason, {}});
}

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_REFUSAL_H_
