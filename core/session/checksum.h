// The checksums with which a session travels, computed alike by client, server and store.
#ifndef AXISCAL_CORE_SESSION_CHECKSUM_H_
#define AXISCAL_CORE_SESSION_CHECKSUM_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/session/session.h"

namespace axiscal::session {

// CRC-32C of one chunk's content, column after column: a number column is its IEEE 754 doubles, little-endian (so -0
// differs from 0 and a NaN counts by its bits); a text column is each text's length in bytes as a little-endian uint32,
// then its bytes. Names are not covered.
uint32_t ChunkCrc32c(const std::vector<Column>& columns);

// The hash that closes a session: SHA-256 (hex) of the CRCs of its chunks in order of seq, each as a little-endian
// uint32.
std::string SessionHash(const std::vector<uint32_t>& chunk_crc32cs);

}  // namespace axiscal::session

#endif  // AXISCAL_CORE_SESSION_CHECKSUM_H_
