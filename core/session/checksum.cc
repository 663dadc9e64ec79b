#include "core/session/checksum.h"

#include <bit>

#include "core/base/crc32c.h"
#include "core/base/sha256.h"

namespace axiscal::session {

static_assert(std::endian::native == std::endian::little, "checksums are defined over little-endian bytes");

uint32_t ChunkCrc32c(const std::vector<Column>& columns) {
  uint32_t crc = 0;
  for (const Column& column : columns) {
    crc = base::Crc32c(crc, column.values.data(), column.values.size() * sizeof(double));
    for (const std::string& text : column.texts) {
      const uint32_t size = static_cast<uint32_t>(text.size());
      crc = base::Crc32c(crc, &size, sizeof(size));
      crc = base::Crc32c(crc, text.data(), text.size());
    }
  }
  return crc;
}

std::string SessionHash(const std::vector<uint32_t>& chunk_crc32cs) {
  base::Sha256 sha;
  sha.Add(chunk_crc32cs.data(), chunk_crc32cs.size() * sizeof(uint32_t));
  return sha.HexDigest();
}

}  // namespace axiscal::session
