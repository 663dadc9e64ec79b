// How a client behaves: deadlines, retries, windows.
#ifndef AXISCAL_CLIENT_OPTIONS_H_
#define AXISCAL_CLIENT_OPTIONS_H_

#include <chrono>
#include <functional>
#include <string>

#include "core/base/status.h"
#include "core/records/chunked_session.h"

namespace axiscal::client {

// How a client reaches a server with TLS, and shows who it is. PEM files; all empty: no TLS.
struct Identity {
  std::string ca;           // authorities that the server's certificate must be from
  std::string certificate;  // of this client, with its key; empty: none is shown
  std::string key;
  // A file with a token on one line; read again for each call, so that it can be replaced. Sent by TLS, to this machine
  // or into this process only.
  std::string token_file;

  bool has_tls() const { return !ca.empty() || !certificate.empty() || !key.empty(); }
};

struct Options {
  Identity identity = {};
  // A name for the server's log. Who asks is decided by the server (`identity`), and so is what it may do.
  std::string user = "anonymous";
  // W3C Trace Context of whatever calls are part of ("00-<32 hex>-<16 hex>-01"): each call is a step of that trace, in
  // the server's log and in the jobs that it creates. Empty: a trace of this client's own.
  std::string trace_parent = {};
  // How long Connect() waits for the server; 0 connects when the first call needs it.
  std::chrono::milliseconds connect_deadline = std::chrono::seconds(5);
  // Of one call, its retries included. Longer over slow links.
  std::chrono::milliseconds call_deadline = std::chrono::seconds(20);
  // Of one upload, download or watch stream; a stream that made progress before is resumed.
  std::chrono::milliseconds stream_deadline = std::chrono::minutes(30);
  // A transfer gives up after so long without any progress. Longer for cells that must survive a server's restart.
  std::chrono::milliseconds give_up_after = std::chrono::seconds(60);
  // Wait between attempts: doubles from first to max.
  std::chrono::milliseconds first_backoff = std::chrono::milliseconds(100);
  std::chrono::milliseconds max_backoff = std::chrono::seconds(1);
  // Readings per chunk, 1 to 4096. Smaller where memory is scarce; below 100 it is slow.
  int chunk_readings = records::kUsualChunkReadings;
  // Chunks sent and not yet acknowledged, at most, 1 to 64.
  int window_chunks = 8;
};

// The trace's id, 32 hexadecimal digits; empty where the text is no traceparent of version 00.
std::string TraceIdOf(const std::string& trace_parent);

// INVALID_ARGUMENT that names field, value and rule.
absl::Status Validate(const Options& options);

// How far a transfer is.
struct TransferProgress {
  int64_t done = 0;  // readings (sessions) or bytes (programs) that the other side has for sure
  int64_t total = 0;
  int interruptions = 0;  // how often the stream broke and was resumed
};
using ProgressCallback = std::function<void(const TransferProgress&)>;

}  // namespace axiscal::client

#endif  // AXISCAL_CLIENT_OPTIONS_H_
