#include "client/cli/tls_probe.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <memory>

#include "core/base/clock.h"
#include "core/base/files.h"

namespace axiscal::cli {
namespace {

constexpr std::chrono::milliseconds kPatience(3000);
constexpr size_t kMaxPemBytes = 1 << 20;

using X509Pointer = std::unique_ptr<X509, decltype(&X509_free)>;

// A connected socket, closed with it.
class Socket {
 public:
  explicit Socket(int descriptor) : descriptor_(descriptor) {}
  ~Socket() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int get() const { return descriptor_; }

 private:
  const int descriptor_;
};

// While it lives, a connection that the other side has closed is an error of a write, not the end of the process:
// OpenSSL answers an end within the handshake by an alert.
class BrokenPipesAreErrors {
 public:
  BrokenPipesAreErrors() {
    struct sigaction ignore {};
    ignore.sa_handler = SIG_IGN;
    sigaction(SIGPIPE, &ignore, &before_);
  }
  ~BrokenPipesAreErrors() { sigaction(SIGPIPE, &before_, nullptr); }
  BrokenPipesAreErrors(const BrokenPipesAreErrors&) = delete;
  BrokenPipesAreErrors& operator=(const BrokenPipesAreErrors&) = delete;

 private:
  struct sigaction before_ {};
};

// Empty, or why not.
std::string ConnectTo(int descriptor, const sockaddr* address, socklen_t size) {
  fcntl(descriptor, F_SETFL, O_NONBLOCK);
  if (connect(descriptor, address, size) == 0) return "";
  if (errno != EINPROGRESS) return std::strerror(errno);
  pollfd wait{descriptor, POLLOUT, 0};
  if (poll(&wait, 1, static_cast<int>(kPatience.count())) <= 0)
    return absl::StrCat("no answer within ", kPatience.count() / 1000, " s");
  int error = 0;
  socklen_t error_size = sizeof(error);
  getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &error, &error_size);
  return error == 0 ? "" : std::strerror(error);
}

std::string SubjectOf(const X509* certificate) {
  char text[256] = {};
  X509_NAME_oneline(X509_get_subject_name(certificate), text, sizeof(text));
  return text;
}

int DaysLeft(const X509* certificate) {
  int days = 0, seconds = 0;
  // Both have one sign.
  if (ASN1_TIME_diff(&days, &seconds, nullptr, X509_get0_notAfter(certificate)) != 1) return 0;
  return seconds < 0 && days == 0 ? -1 : days;
}

// What the handshake shows. The server may end it when we show no certificate; its own has come by then.
void Handshake(int descriptor, const std::string& host, const std::string& ca, TlsProbe& probe) {
  const BrokenPipesAreErrors pipes;
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context(SSL_CTX_new(TLS_client_method()), &SSL_CTX_free);
  if (context == nullptr) return;
  const bool has_ca = !ca.empty() && SSL_CTX_load_verify_locations(context.get(), ca.c_str(), nullptr) == 1;
  const std::unique_ptr<SSL, decltype(&SSL_free)> tls(SSL_new(context.get()), &SSL_free);
  if (tls == nullptr || SSL_set_fd(tls.get(), descriptor) != 1) return;
  const unsigned char http2[] = {2, 'h', '2'};
  SSL_set_alpn_protos(tls.get(), http2, sizeof(http2));
  in6_addr unused{};
  const bool is_ip = inet_pton(AF_INET, host.c_str(), &unused) == 1 || inet_pton(AF_INET6, host.c_str(), &unused) == 1;
  if (is_ip) {
    X509_VERIFY_PARAM_set1_ip_asc(SSL_get0_param(tls.get()), host.c_str());
  } else {
    SSL_set_tlsext_host_name(tls.get(), host.c_str());
    SSL_set1_host(tls.get(), host.c_str());
  }
  const base::SteadyTime end = base::SystemClock().SteadyNow() + kPatience;
  while (true) {
    const int result = SSL_connect(tls.get());
    if (result == 1) break;
    const int why = SSL_get_error(tls.get(), result);
    if ((why != SSL_ERROR_WANT_READ && why != SSL_ERROR_WANT_WRITE) || base::SystemClock().SteadyNow() > end) break;
    pollfd wait{descriptor, static_cast<short>(why == SSL_ERROR_WANT_READ ? POLLIN : POLLOUT), 0};
    poll(&wait, 1, 100);
  }
  const X509Pointer certificate(SSL_get1_peer_certificate(tls.get()), &X509_free);
  ERR_clear_error();
  if (certificate == nullptr) return;
  probe.speaks_tls = true;
  probe.subject = SubjectOf(certificate.get());
  probe.days_left = DaysLeft(certificate.get());
  const long verdict = SSL_get_verify_result(tls.get());
  if (has_ca && verdict != X509_V_OK) probe.refused = X509_verify_cert_error_string(verdict);
  probe.is_out_of_time = has_ca && (verdict == X509_V_ERR_CERT_HAS_EXPIRED || verdict == X509_V_ERR_CERT_NOT_YET_VALID);
  if (!ca.empty() && !has_ca) probe.refused = ca + " holds no authority that can be read";
}

}  // namespace

TlsProbe ProbeServer(const std::string& address, const std::string& ca) {
  TlsProbe probe;
  const base::SteadyTime start = base::SystemClock().SteadyNow();
  if (address.rfind("unix:", 0) == 0) {
    const std::string path = address.substr(std::strlen("unix:"));
    sockaddr_un name{};
    name.sun_family = AF_UNIX;
    if (path.size() >= sizeof(name.sun_path)) {
      probe.error = "the path is too long for a socket";
      return probe;
    }
    std::memcpy(name.sun_path, path.data(), path.size());
    const Socket socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    probe.error = ConnectTo(socket.get(), reinterpret_cast<const sockaddr*>(&name), sizeof(name));
    return probe;
  }
  const std::string bare = address.rfind("dns:", 0) == 0 ? address.substr(address.find_first_not_of('/', 4)) : address;
  const size_t colon = bare.rfind(':');
  std::string host = bare.substr(0, colon);
  const std::string port = colon == std::string::npos ? "443" : bare.substr(colon + 1);
  if (host.size() > 1 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(host.c_str(), port.c_str(), &hints, &found); error != 0) {
    probe.error = gai_strerror(error);
    probe.has_no_address = true;
    return probe;
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> all(found, &freeaddrinfo);
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    const Socket socket(::socket(one->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0));
    probe.error = socket.get() < 0 ? std::strerror(errno) : ConnectTo(socket.get(), one->ai_addr, one->ai_addrlen);
    if (!probe.error.empty()) continue;
    probe.connect_ms = std::chrono::duration<double, std::milli>(base::SystemClock().SteadyNow() - start).count();
    Handshake(socket.get(), host, ca, probe);
    return probe;
  }
  return probe;
}

absl::StatusOr<int> DaysLeftOf(const std::string& pem_file) {
  ASSIGN_OR_RETURN(const std::string pem, base::ReadFile(pem_file, kMaxPemBytes));
  const std::unique_ptr<BIO, decltype(&BIO_free)> bio(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())),
                                                      &BIO_free);
  const X509Pointer certificate(PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr), &X509_free);
  ERR_clear_error();
  if (certificate == nullptr) return absl::InvalidArgumentError(pem_file + ": holds no certificate that can be read");
  return DaysLeft(certificate.get());
}

}  // namespace axiscal::cli
