#include "core/base/crc32c.h"

#include <isa-l/crc.h>

#include <algorithm>

namespace axiscal::base {

uint32_t Crc32c(uint32_t crc, const void* data, size_t size) {
  // libisal neither inverts its register nor promises const, and counts in int.
  constexpr size_t kMaxStep = 1u << 30;
  auto* bytes = static_cast<unsigned char*>(const_cast<void*>(data));
  uint32_t remainder = ~crc;
  while (size > 0) {
    const size_t step = std::min(size, kMaxStep);
    remainder = crc32_iscsi(bytes, static_cast<int>(step), remainder);
    bytes += step;
    size -= step;
  }
  return ~remainder;
}

}  // namespace axiscal::base
