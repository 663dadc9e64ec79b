// SHA-256 in pieces (FIPS 180-4), as 64 lower-case hexadecimal digits.
#ifndef AXISCAL_CORE_BASE_SHA256_H_
#define AXISCAL_CORE_BASE_SHA256_H_

#include <cstddef>
#include <memory>
#include <string>

namespace axiscal::base {

class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  void Add(const void* data, size_t size);
  void Add(const std::string& text) { Add(text.data(), text.size()); }
  // The digest of all that was added; the object is spent afterwards.
  std::string HexDigest();

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

std::string Sha256Hex(const std::string& text);

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_SHA256_H_
