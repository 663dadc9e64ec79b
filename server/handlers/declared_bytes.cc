#include "server/handlers/declared_bytes.h"

#include "absl/strings/str_cat.h"
#include "core/base/error_detail.h"
#include "proto/convert/field.h"
#include "proto/convert/program.h"

namespace axiscal::handlers {

absl::Status DeclaredBytes::CheckOrder(bool has_header, bool has_data) const {
  if (is_declared() ? has_data : has_header) return absl::OkStatus();
  return base::Error(absl::StatusCode::kInvalidArgument, "the header must come first and once, then data",
                     {"STREAM_INVALID", {}});
}

absl::Status DeclaredBytes::Take(const std::string& data) {
  if (data.empty() || data.size() > static_cast<size_t>(convert::kMaxProgramPartBytes)) {
    return convert::FieldError("data",
                               absl::StrCat(data.size(), " bytes, must be 1 to ", convert::kMaxProgramPartBytes));
  }
  received_ += static_cast<int64_t>(data.size());
  if (received_ <= *declared_) return absl::OkStatus();
  return base::Error(absl::StatusCode::kOutOfRange,
                     absl::StrCat("more than the ", *declared_, " bytes that the header says"), {"SIZE_EXCEEDED", {}});
}

absl::Status DeclaredBytes::CheckEnd() const {
  if (is_declared() && received_ == *declared_) return absl::OkStatus();
  return base::Error(absl::StatusCode::kAborted,
                     absl::StrCat("the stream ended after ", received_, " of ", declared_.value_or(0), " bytes"),
                     {"STREAM_INCOMPLETE", {}});
}

}  // namespace axiscal::handlers
