#include "server/storage/row_checksum.h"

#include <bit>
#include <cstdint>

#include "core/base/crc32c.h"

namespace axiscal::storage {
namespace {

uint32_t AddByte(uint32_t crc, int byte) {
  const auto one = static_cast<unsigned char>(byte);
  return base::Crc32c(crc, &one, 1);
}

uint32_t AddEightBytes(uint32_t crc, uint64_t number) {
  unsigned char bytes[8];
  for (int i = 0; i < 8; ++i) bytes[i] = static_cast<unsigned char>(number >> (8 * i));
  return base::Crc32c(crc, bytes, sizeof(bytes));
}

void RowCrc32c(sqlite3_context* context, int count, sqlite3_value** values) {
  uint32_t crc = 0;
  for (int i = 0; i < count; ++i) {
    sqlite3_value* const value = values[i];
    const int type = sqlite3_value_type(value);
    crc = AddByte(crc, type);
    if (type == SQLITE_INTEGER) {
      crc = AddEightBytes(crc, static_cast<uint64_t>(sqlite3_value_int64(value)));
    } else if (type == SQLITE_FLOAT) {
      // SQLite keeps -0.0 as 0.0.
      crc = AddEightBytes(crc, std::bit_cast<uint64_t>(sqlite3_value_double(value) + 0.0));
    } else if (type != SQLITE_NULL) {
      const void* const bytes = sqlite3_value_blob(value);
      const int size = sqlite3_value_bytes(value);
      crc = AddEightBytes(crc, static_cast<uint64_t>(size));
      if (size > 0) crc = base::Crc32c(crc, bytes, static_cast<size_t>(size));
    }
  }
  sqlite3_result_int64(context, crc);
}

}  // namespace

int AddRowChecksum(sqlite3* db) {
  return sqlite3_create_function(db, "row_crc32c", -1, SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_INNOCUOUS, nullptr,
                                 &RowCrc32c, nullptr, nullptr);
}

}  // namespace axiscal::storage
