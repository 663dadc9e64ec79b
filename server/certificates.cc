#include "server/certificates.h"

#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <ctime>
#include <memory>

#include "core/base/files.h"

namespace axiscal::server {
namespace {

// Thousands of authorities.
constexpr size_t kMaxPemBytes = 16 << 20;

// How long before its end a certificate is warned of: long enough for an IT department to make another.
constexpr std::chrono::hours kWarnAhead = std::chrono::days(30);

using Bio = std::unique_ptr<BIO, decltype(&BIO_free)>;
using X509Pointer = std::unique_ptr<X509, decltype(&X509_free)>;
using KeyPointer = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;

// Nobody is there to be asked for a password.
int NoPassword(char*, int, int, void*) { return -1; }

Bio Open(const std::string& pem) { return {BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())), &BIO_free}; }

absl::Status Refuse(const std::string& file, const std::string& text) {
  ERR_clear_error();
  return absl::InvalidArgumentError(absl::StrCat(file, ": ", text));
}

absl::StatusOr<std::string> Read(const std::string& file) {
  absl::StatusOr<std::string> text = base::ReadFile(file, kMaxPemBytes);
  if (text.ok()) return text;
  return absl::InvalidArgumentError(text.status().message());
}

base::UtcTime TimeOf(const ASN1_TIME* time) {
  std::tm parts = {};
  if (ASN1_TIME_to_tm(time, &parts) != 1) return {};
  return base::UtcTime(std::chrono::seconds(timegm(&parts)));
}

std::string SubjectOf(const X509* certificate) {
  const Bio text(BIO_new(BIO_s_mem()), &BIO_free);
  X509_NAME_print_ex(text.get(), X509_get_subject_name(certificate), 0, XN_FLAG_ONELINE & ~ASN1_STRFLGS_ESC_MSB);
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(text.get(), &bytes);
  return {bytes, static_cast<size_t>(size)};
}

absl::StatusOr<std::vector<X509Pointer>> ReadCertificates(const std::string& file, const std::string& pem) {
  const Bio bio = Open(pem);
  std::vector<X509Pointer> all;
  while (X509* const one = PEM_read_bio_X509(bio.get(), nullptr, &NoPassword, nullptr))
    all.emplace_back(one, &X509_free);
  // Anything but the end of the text is a certificate that cannot be read.
  const unsigned long error = ERR_peek_last_error();
  const bool is_end = ERR_GET_LIB(error) == ERR_LIB_PEM && ERR_GET_REASON(error) == PEM_R_NO_START_LINE;
  if (all.empty() || !is_end)
    return Refuse(file,
                  absl::StrCat("certificate ", all.size() + 1, " cannot be read, must be PEM (BEGIN CERTIFICATE)"));
  ERR_clear_error();
  return all;
}

void Add(const std::string& file, const std::vector<X509Pointer>& read, std::vector<Certificate>& certificates) {
  for (const X509Pointer& one : read) {
    certificates.push_back(
        {file, SubjectOf(one.get()), TimeOf(X509_get0_notBefore(one.get())), TimeOf(X509_get0_notAfter(one.get()))});
  }
}

std::string Day(base::UtcTime time) {
  const std::time_t seconds = std::chrono::floor<std::chrono::seconds>(time).time_since_epoch().count();
  std::tm parts = {};
  gmtime_r(&seconds, &parts);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%d %H:%M UTC", &parts);
  return text;
}

}  // namespace

absl::StatusOr<TlsMaterial> ReadTls(const TlsFiles& files, base::UtcTime now) {
  TlsMaterial material;
  ASSIGN_OR_RETURN(material.certificate_pem, Read(files.certificate));
  ASSIGN_OR_RETURN(material.key_pem, Read(files.key));
  ASSIGN_OR_RETURN(const std::vector<X509Pointer> own, ReadCertificates(files.certificate, material.certificate_pem));
  const Bio key_text = Open(material.key_pem);
  const KeyPointer key(PEM_read_bio_PrivateKey(key_text.get(), nullptr, &NoPassword, nullptr), &EVP_PKEY_free);
  if (key == nullptr)
    return Refuse(files.key, "no key can be read, must be PEM (BEGIN PRIVATE KEY) without a password");
  if (X509_check_private_key(own.front().get(), key.get()) != 1)
    return Refuse(files.key, "is not the key of the certificate in " + files.certificate);
  Add(files.certificate, own, material.certificates);
  const Certificate& first = material.certificates.front();
  if (first.begins > now || first.ends <= now) {
    return Refuse(files.certificate,
                  absl::StrCat("the certificate of ", first.subject, " is valid from ", Day(first.begins), " to ",
                               Day(first.ends), ", now it is ", Day(now)));
  }
  if (files.client_ca.empty()) return material;
  ASSIGN_OR_RETURN(material.client_ca_pem, Read(files.client_ca));
  ASSIGN_OR_RETURN(const std::vector<X509Pointer> authorities,
                   ReadCertificates(files.client_ca, material.client_ca_pem));
  Add(files.client_ca, authorities, material.certificates);
  return material;
}

std::optional<base::UtcTime> EndOfCertificate(const std::string& pem) {
  const Bio bio = Open(pem);
  const X509Pointer one(PEM_read_bio_X509(bio.get(), nullptr, &NoPassword, nullptr), &X509_free);
  ERR_clear_error();
  if (one == nullptr) return std::nullopt;
  return TimeOf(X509_get0_notAfter(one.get()));
}

std::vector<std::string> EndWarnings::Due(const std::vector<Certificate>& certificates, base::UtcTime now) {
  std::erase_if(named_, [&](const auto& one) { return now - one.second >= std::chrono::days(1); });
  std::vector<std::string> sentences;
  for (const Certificate& one : certificates) {
    if (one.ends - now > kWarnAhead || !named_.emplace(std::pair(one.file, one.ends), now).second) continue;
    const auto days = std::chrono::floor<std::chrono::days>(one.ends - now).count();
    sentences.push_back(absl::StrCat(one.file, ": the certificate of ", one.subject,
                                     one.ends <= now ? " ended on " : absl::StrCat(" ends in ", days, " days, on "),
                                     Day(one.ends)));
  }
  return sentences;
}

}  // namespace axiscal::server
