// The files of TLS: the server's certificate with its key, and the authority whose certificates name callers. Read
// whole, or not at all.
#ifndef AXISCAL_SERVER_CERTIFICATES_H_
#define AXISCAL_SERVER_CERTIFICATES_H_

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/clock.h"
#include "core/base/status.h"

namespace axiscal::server {

// PEM files. Without `certificate` there is no TLS.
struct TlsFiles {
  std::string certificate;  // the server's, with those between it and its authority behind it
  std::string key;          // of the first certificate, without a password
  std::string client_ca;    // authorities of the callers' certificates; empty: callers show none

  bool is_set() const { return !certificate.empty(); }
};

struct Certificate {
  std::string file;
  std::string subject;  // "CN = axiscal.shop"
  base::UtcTime begins, ends;
};

// What the files hold.
struct TlsMaterial {
  std::string certificate_pem, key_pem, client_ca_pem;
  std::vector<Certificate> certificates;  // all of them, the server's own first
};

// INVALID_ARGUMENT that names the file: it cannot be read, holds no certificate, the key is not the certificate's or
// has a password, or the server's own certificate is not valid at `now`.
absl::StatusOr<TlsMaterial> ReadTls(const TlsFiles& files, base::UtcTime now);

// When a certificate ends; nothing where it cannot be read.
std::optional<base::UtcTime> EndOfCertificate(const std::string& pem);

// Warns of certificates a month before they end: once a day of each, and at once of one that took another's place.
class EndWarnings {
 public:
  // A sentence for each that ends within 30 days of `now` or has ended, and was not named within the day before.
  std::vector<std::string> Due(const std::vector<Certificate>& certificates, base::UtcTime now);

 private:
  // When it was named last, by file and end: a file that was renewed is another certificate.
  std::map<std::pair<std::string, base::UtcTime>, base::UtcTime> named_;
};

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_CERTIFICATES_H_
