// What stands at a server's address, looked at without gRPC, so that a refusal can be told from a closed port and a
// certificate of another name from one that has ended.
#ifndef AXISCAL_CLIENT_CLI_TLS_PROBE_H_
#define AXISCAL_CLIENT_CLI_TLS_PROBE_H_

#include <string>

#include "core/base/status.h"

namespace axiscal::cli {

struct TlsProbe {
  std::string error;            // why there is no connection: name unknown, refused, no answer; empty: there is one
  bool has_no_address = false;  // it is that the name has no address here
  double connect_ms = 0.0;      // how long it took
  bool speaks_tls = false;
  // Of the certificate that the server shows, where it speaks TLS.
  std::string subject;
  int days_left = 0;            // negative: it has ended
  std::string refused;          // why it is not trusted by `ca` for this name; empty: it is
  bool is_out_of_time = false;  // it is that by this clock it has ended, or has not begun
};

// `address` as gRPC takes it: "HOST:PORT", "[::1]:7410", "unix:PATH". `ca`: a PEM file; empty: the certificate's name
// and authority are not looked at. Waits a few seconds at most.
TlsProbe ProbeServer(const std::string& address, const std::string& ca);

// Until the first certificate of a PEM file ends; negative: it has ended. INVALID_ARGUMENT, NOT_FOUND.
absl::StatusOr<int> DaysLeftOf(const std::string& pem_file);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_TLS_PROBE_H_
