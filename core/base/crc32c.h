// CRC-32C (Castagnoli, RFC 3720): "123456789" gives 0xE3069283.
#ifndef AXISCAL_CORE_BASE_CRC32C_H_
#define AXISCAL_CORE_BASE_CRC32C_H_

#include <cstddef>
#include <cstdint>

namespace axiscal::base {

// The CRC of what `crc` covers followed by `size` bytes at `data`; start with 0.
uint32_t Crc32c(uint32_t crc, const void* data, size_t size);

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_CRC32C_H_
