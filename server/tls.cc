#include "server/tls.h"

#include <grpc/grpc.h>
#include <grpc/grpc_security.h>

namespace axiscal::server {
namespace {

constexpr std::chrono::seconds kLookAgainAfter(1);

bool HaveSameText(const TlsMaterial& a, const TlsMaterial& b) {
  return a.certificate_pem == b.certificate_pem && a.key_pem == b.key_pem && a.client_ca_pem == b.client_ca_pem;
}

// gRPC's C++ classes fix the files at the start, or take a pair that does not fit and then refuse everybody. Its C
// library asks for them with each handshake.
grpc_ssl_certificate_config_reload_status Fetch(void* tls, grpc_ssl_server_certificate_config** config) {
  const std::optional<TlsMaterial> material = static_cast<Tls*>(tls)->TakeNew();
  if (!material) return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_UNCHANGED;
  const grpc_ssl_pem_key_cert_pair pair = {material->key_pem.c_str(), material->certificate_pem.c_str()};
  // gRPC insists on authorities, also where callers are asked for no certificate.
  const std::string& authorities =
      material->client_ca_pem.empty() ? material->certificate_pem : material->client_ca_pem;
  *config = grpc_ssl_server_certificate_config_create(authorities.c_str(), &pair, 1);
  return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_NEW;
}

class TlsCredentials final : public grpc::ServerCredentials {
 public:
  TlsCredentials(std::shared_ptr<Tls> tls, CallHeads& heads) : tls_(std::move(tls)) {
    const bool asks = !tls_->files().client_ca.empty();
    credentials_ =
        grpc_ssl_server_credentials_create_with_options(grpc_ssl_server_credentials_create_options_using_config_fetcher(
            asks ? kRequest : GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE, &Fetch, tls_.get()));
    heads.LookAt(credentials_);
  }
  ~TlsCredentials() override { grpc_server_credentials_release(credentials_); }
  void SetAuthMetadataProcessor(const std::shared_ptr<grpc::AuthMetadataProcessor>&) override {}

 private:
  static constexpr grpc_ssl_client_certificate_request_type kRequest = GRPC_SSL_REQUEST_CLIENT_CERTIFICATE_AND_VERIFY;

  int AddPortToServer(const std::string& address, grpc_server* server) override {
    return grpc_server_add_http2_port(server, address.c_str(), credentials_);
  }

  const std::shared_ptr<Tls> tls_;
  grpc_server_credentials* credentials_ = nullptr;
};

}  // namespace

absl::StatusOr<std::shared_ptr<Tls>> Tls::Create(const TlsFiles& files, Tell tell, base::Clock& clock) {
  ASSIGN_OR_RETURN(TlsMaterial material, ReadTls(files, clock.UtcNow()));
  return std::shared_ptr<Tls>(new Tls(files, std::move(tell), clock, std::move(material)));
}

std::shared_ptr<grpc::ServerCredentials> Tls::Credentials(std::shared_ptr<Tls> tls, CallHeads& heads) {
  return std::make_shared<TlsCredentials>(std::move(tls), heads);
}

void Tls::Look() {
  const base::SteadyTime now = clock_.SteadyNow();
  if (looked_at_ && now - *looked_at_ < kLookAgainAfter) return;
  looked_at_ = now;
  absl::StatusOr<TlsMaterial> read = ReadTls(files_, clock_.UtcNow());
  if (!read.ok()) {
    const std::string reason(read.status().message());
    if (reason != std::exchange(refused_, reason)) tell_(read.status());
    return;
  }
  refused_.clear();
  if (HaveSameText(*read, present_)) return;
  present_ = *std::move(read);
  is_taken_ = false;
  tell_(absl::OkStatus());
}

std::optional<TlsMaterial> Tls::TakeNew() {
  const base::MutexLock lock(mutex_);
  Look();
  if (std::exchange(is_taken_, true)) return std::nullopt;
  return present_;
}

std::vector<Certificate> Tls::certificates() {
  const base::MutexLock lock(mutex_);
  Look();
  return present_.certificates;
}

}  // namespace axiscal::server
