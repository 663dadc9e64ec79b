// The machine-readable part of a failure: a stable reason (SEQ_GAP) and facts a program can act on (next_seq = 12). It
// travels as a payload of absl::Status and becomes google.rpc.ErrorInfo on the wire.
#ifndef AXISCAL_CORE_BASE_ERROR_DETAIL_H_
#define AXISCAL_CORE_BASE_ERROR_DETAIL_H_

#include <map>
#include <optional>
#include <string>

#include "core/base/status.h"

namespace axiscal::base {

struct ErrorDetail {
  std::string reason;  // upper case with underscores
  std::map<std::string, std::string> facts;

  bool operator==(const ErrorDetail&) const = default;
};

// A status with `message` for people and `detail` for programs. `code` must not be kOk.
absl::Status Error(absl::StatusCode code, const std::string& message, const ErrorDetail& detail);

// The detail of a status made by Error(), or nothing.
std::optional<ErrorDetail> GetErrorDetail(const absl::Status& status);
// Its reason, or "".
std::string ErrorReason(const absl::Status& status);

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_ERROR_DETAIL_H_
