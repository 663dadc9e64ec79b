// What a server is started with.
#ifndef AXISCAL_SERVER_SERVER_OPTIONS_H_
#define AXISCAL_SERVER_SERVER_OPTIONS_H_

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "core/base/status.h"
#include "server/certificates.h"
#include "server/webhooks/poster.h"

namespace axiscal::server {

// More cores than the machines have on which it runs, and more uploads than a factory has cells.
inline constexpr int kMaxWorkers = 1024;
inline constexpr int kMaxUploads = 10'000;
inline constexpr int kMaxJobs = 1'000'000;
inline constexpr int kMaxCallsPerSecond = 1'000'000;
inline constexpr int64_t kMinWaitingBytes = 16 << 20;
inline constexpr int kMinWindowBytes = 64 << 10, kMaxWindowBytes = 16 << 20;

struct ServerOptions {
  // The SQLite file, made when it is not there, or the URL of a database of PostgreSQL (storage::PostgresOptions::url).
  std::string database_path;
  // Where to listen, as gRPC takes it ("127.0.0.1:7410", "unix:/run/axiscal.sock"). Port 0 picks a free one. Empty: on
  // no port.
  std::string listen_address;
  // Where to serve the same by HTTP (server/http), as above. Empty: nowhere. TLS and who must say who he is are the
  // same.
  std::string http_address;
  TlsFiles tls;
  // Callers must show who they are, by a certificate or a token (server/access). Without it everybody is "local:LOGIN"
  // and may do everything, and other machines must not reach the address. Always so with TLS.
  bool asks_identity = false;
  // Open calls are asked again so often whether they may go on. > 0.
  std::chrono::milliseconds ask_again = std::chrono::seconds(15);
  // Jobs at once; each uses one core. 1 to kMaxWorkers.
  int workers = 2;
  // Streams that bring sessions or programs at a time, each holding two threads; more are refused. 1 to kMaxUploads.
  int max_uploads = 500;
  // Of one principal: streams of a kind at a time, and calls a second (twice as many at once). 1 to kMaxUploads, 1 to
  // kMaxCallsPerSecond. Where nobody is asked who he is, there are no such limits.
  int streams_per_principal = 100;
  int calls_per_second = 1000;
  // Jobs that wait or run, of one principal and of one machine. 1 to kMaxJobs.
  int jobs_per_principal = 200;
  int jobs_per_machine = 500;
  // Of one session (14 hours at 1 kHz), and of one program. > 0.
  int64_t session_readings = 50'000'000;
  int64_t program_bytes = int64_t{1} << 30;
  // A caller that neither sends nor takes anything in the midst of a stream is cut off after so long, as is one that
  // does not take a reply (there the last server of the process that was started decides). > 0.
  std::chrono::milliseconds silence = std::chrono::minutes(5);
  // A connection without a call is closed after so long; clients open a new one with their next call. > 0.
  std::chrono::milliseconds connection_idle = std::chrono::minutes(5);
  // Connections from which nobody has called yet whom the server knows, where callers must say who they are: of each
  // port so many; one more ends the first of the host that has most. > 0.
  int strangers = 2000;
  // How far one stream may run ahead of what the server has read, bytes: rate <= window / round trip. 64 KB to 16 MB;
  // more costs memory per stream.
  int window_bytes = 1 << 20;
  // What callers of gRPC have half sent, of all connections together: where it is more, calls are cancelled until it is
  // less. At least kMinWaitingBytes.
  int64_t waiting_bytes = int64_t{512} << 20;
  // By HTTP, of all callers together and shared fairly between them (handlers::Budget): bytes of bodies, files and
  // messages, and requests under way; more are refused. > 0.
  int64_t http_bytes = int64_t{1} << 30;
  int http_requests = 3000;
  // A session or program whose upload was left for so long is given up and what came of it is dropped. Only time that a
  // server was up counts. > 0.
  std::chrono::hours session_expiry = std::chrono::hours(24 * 7);
  // Where backups stay that callers ask for; empty: they can only be sent.
  std::string backup_folder;
  // So many machines have series of their own in the metrics, those with most open events: 0 to 50.
  int metrics_machines = 0;
  // How webhooks are sent; absent: not at all.
  std::optional<webhooks::PosterOptions> webhook_posts = {};
  // Readings of complete sessions older than this are removed, unless a calibration stands on them; 0: never. Counted
  // as session_expiry. >= 0.
  std::chrono::hours keep_readings = std::chrono::hours(0);
  // Entries of the audit older than this are removed; 0: never. Counted as session_expiry. >= 0.
  std::chrono::hours keep_audit = std::chrono::hours(0);
  // How long Shutdown() lets calls and jobs go on before it cuts them off. >= 0.
  std::chrono::milliseconds drain = std::chrono::seconds(20);
};

// INVALID_ARGUMENT that names field, value and rule.
absl::Status Validate(const ServerOptions& options);

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_SERVER_OPTIONS_H_
