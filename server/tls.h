// TLS of the port: new files are taken by the next handshake, without a restart. Certificate, key and authorities are
// taken together or not at all: while they do not fit one another, what was in use stays in use.
#ifndef AXISCAL_SERVER_TLS_H_
#define AXISCAL_SERVER_TLS_H_

#include <grpcpp/security/server_credentials.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/mutex.h"
#include "server/call_heads.h"
#include "server/certificates.h"

namespace axiscal::server {

class Tls {
 public:
  // Told of new files that were taken (OK), and once of each reason why they are not. From any thread.
  using Tell = std::function<void(const absl::Status&)>;

  // ReadTls()'s errors. `tell` is not called by it.
  static absl::StatusOr<std::shared_ptr<Tls>> Create(const TlsFiles& files, Tell tell,
                                                     base::Clock& clock = base::SystemClock());

  // What a server listens with; keeps `tls` alive. Callers without a certificate are let in, their calls say who they
  // are; a certificate of another authority is refused. `heads` looks at their calls.
  static std::shared_ptr<grpc::ServerCredentials> Credentials(std::shared_ptr<Tls> tls, CallHeads& heads);

  // What holds now; null: as it was when it was asked for last. Looks at the files at most once a second.
  std::optional<TlsMaterial> TakeNew();
  // Of what is in use.
  std::vector<Certificate> certificates();
  const TlsFiles& files() const { return files_; }

 private:
  Tls(const TlsFiles& files, Tell tell, base::Clock& clock, TlsMaterial material)
      : files_(files), tell_(std::move(tell)), clock_(clock), present_(std::move(material)) {}
  void Look() AXISCAL_REQUIRES(mutex_);

  const TlsFiles files_;
  const Tell tell_;
  base::Clock& clock_;
  base::Mutex mutex_;
  TlsMaterial present_ AXISCAL_GUARDED_BY(mutex_);
  bool is_taken_ AXISCAL_GUARDED_BY(mutex_) = false;
  std::optional<base::SteadyTime> looked_at_ AXISCAL_GUARDED_BY(mutex_);
  std::string refused_ AXISCAL_GUARDED_BY(mutex_);  // the last reason that was told
};

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_TLS_H_
