#include "client/options.h"

#include "core/records/chunk.h"

namespace axiscal::client {

std::string TraceIdOf(const std::string& trace_parent) {
  constexpr size_t kSize = 55, kId = 3, kIdSize = 32, kSpan = 36, kFlags = 53;
  if (trace_parent.size() != kSize || trace_parent.rfind("00-", 0) != 0) return "";
  for (size_t i = kId; i < kSize; ++i) {
    const char c = trace_parent[i];
    const bool is_dash = i == kSpan - 1 || i == kFlags - 1;
    if (is_dash ? c != '-' : !((c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'))) return "";
  }
  return trace_parent.substr(kId, kIdSize);
}

absl::Status Validate(const Options& options) {
  const auto require = [](bool holds, const std::string& text) {
    return holds ? absl::OkStatus() : absl::InvalidArgumentError(text);
  };
  const auto positive = [&](const char* field, std::chrono::milliseconds value) {
    return require(value.count() > 0, absl::StrCat(field, " = ", value.count(), " ms, must be > 0"));
  };
  RETURN_IF_ERROR(require(!options.user.empty() && options.user.size() <= 200, "user must have 1 to 200 bytes"));
  for (const char c : options.user) {
    RETURN_IF_ERROR(require(c >= 0x20 && c < 0x7f, "user must be printable ASCII"));
  }
  RETURN_IF_ERROR(require(options.trace_parent.empty() || !TraceIdOf(options.trace_parent).empty(),
                          "trace_parent must be as W3C Trace Context has it: 00-<32 hex>-<16 hex>-<2 hex>"));
  const Identity& identity = options.identity;
  RETURN_IF_ERROR(require(identity.certificate.empty() == identity.key.empty(),
                          "identity.certificate and identity.key must be set together"));
  RETURN_IF_ERROR(require(!identity.has_tls() || !identity.ca.empty(),
                          "identity.ca must name the authority of the server's certificate"));
  RETURN_IF_ERROR(require(options.connect_deadline.count() >= 0, "connect_deadline must be >= 0"));
  RETURN_IF_ERROR(positive("call_deadline", options.call_deadline));
  RETURN_IF_ERROR(positive("stream_deadline", options.stream_deadline));
  RETURN_IF_ERROR(positive("give_up_after", options.give_up_after));
  RETURN_IF_ERROR(positive("first_backoff", options.first_backoff));
  RETURN_IF_ERROR(require(options.max_backoff >= options.first_backoff, "max_backoff must be >= first_backoff"));
  RETURN_IF_ERROR(require(
      options.chunk_readings >= 1 && options.chunk_readings <= records::kMaxChunkReadings,
      absl::StrCat("chunk_readings = ", options.chunk_readings, ", must be 1 to ", records::kMaxChunkReadings)));
  return require(options.window_chunks >= 1 && options.window_chunks <= 64,
                 absl::StrCat("window_chunks = ", options.window_chunks, ", must be 1 to 64"));
}

}  // namespace axiscal::client
