// A file that comes over a stream: a header that says how many bytes it has, then these bytes in parts.
#ifndef AXISCAL_SERVER_HANDLERS_DECLARED_BYTES_H_
#define AXISCAL_SERVER_HANDLERS_DECLARED_BYTES_H_

#include <cstdint>
#include <optional>
#include <string>

#include "core/base/status.h"

namespace axiscal::handlers {

class DeclaredBytes {
 public:
  // `has_header`, `has_data`: what the next message holds. INVALID_ARGUMENT STREAM_INVALID unless the header comes
  // first and once.
  absl::Status CheckOrder(bool has_header, bool has_data) const;
  // The header has come and says so.
  void Declare(int64_t size_bytes) { declared_ = size_bytes; }
  bool is_declared() const { return declared_.has_value(); }
  // The next part has come. INVALID_ARGUMENT for an empty or a too long one; OUT_OF_RANGE SIZE_EXCEEDED when more bytes
  // have come than the header says.
  absl::Status Take(const std::string& data);
  // No more parts come. ABORTED STREAM_INCOMPLETE when bytes are missing: a malformed message looks like a normal end.
  absl::Status CheckEnd() const;

 private:
  std::optional<int64_t> declared_;
  int64_t received_ = 0;
};

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_DECLARED_BYTES_H_
