// Expected failures are absl::Status: a message says what, where and which limit ("run 12, sample 340: length_mm =
// nan"). Messages are built as std::string: Debian's Abseil has a string_view of its own.
#ifndef AXISCAL_CORE_BASE_STATUS_H_
#define AXISCAL_CORE_BASE_STATUS_H_

#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/cord.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

#define AXISCAL_CONCAT_INNER(a, b) a##b
#define AXISCAL_CONCAT(a, b) AXISCAL_CONCAT_INNER(a, b)

// Returns from the calling function when `expression` is not OK.
#define RETURN_IF_ERROR(expression)                  \
  do {                                               \
    ::absl::Status axiscal_status = (expression);    \
    if (!axiscal_status.ok()) return axiscal_status; \
  } while (false)

// ASSIGN_OR_RETURN(auto value, Function()): assigns the value or returns the error.
#define ASSIGN_OR_RETURN(target, expression) \
  ASSIGN_OR_RETURN_INNER(AXISCAL_CONCAT(axiscal_status_or_, __LINE__), target, expression)
#define ASSIGN_OR_RETURN_INNER(holder, target, expression) \
  auto holder = (expression);                              \
  if (!holder.ok()) return std::move(holder).status();     \
  target = *std::move(holder)

namespace axiscal::base {

// The same code, payloads and message with `where` in front: "fit/00-BX.csv: line 12: ...". OK stays OK.
inline absl::Status Within(const std::string& where, const absl::Status& status) {
  if (status.ok()) return status;
  absl::Status longer(status.code(), absl::StrCat(where, ": ", status.message()));
  status.ForEachPayload([&](absl::string_view url, const absl::Cord& payload) { longer.SetPayload(url, payload); });
  return longer;
}

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_STATUS_H_
