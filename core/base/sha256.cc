#include "core/base/sha256.h"

#include <openssl/evp.h>

#include "core/base/demand.h"

namespace axiscal::base {

struct Sha256::Context {
  EVP_MD_CTX* evp = EVP_MD_CTX_new();
  ~Context() { EVP_MD_CTX_free(evp); }
};

Sha256::Sha256() : context_(std::make_unique<Context>()) {
  DEMAND(EVP_DigestInit_ex(context_->evp, EVP_sha256(), nullptr) == 1);
}

Sha256::~Sha256() = default;

void Sha256::Add(const void* data, size_t size) { DEMAND(EVP_DigestUpdate(context_->evp, data, size) == 1); }

std::string Sha256::HexDigest() {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  DEMAND(EVP_DigestFinal_ex(context_->evp, digest, &size) == 1);
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (unsigned int i = 0; i < size; ++i) {
    text += kDigits[digest[i] >> 4];
    text += kDigits[digest[i] & 15];
  }
  return text;
}

std::string Sha256Hex(const std::string& text) {
  Sha256 sha;
  sha.Add(text);
  return sha.HexDigest();
}

}  // namespace axiscal::base
