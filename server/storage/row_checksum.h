// The checksum of what some columns of a row say, as a function of SQL: row_crc32c(value, ...).
#ifndef AXISCAL_SERVER_STORAGE_ROW_CHECKSUM_H_
#define AXISCAL_SERVER_STORAGE_ROW_CHECKSUM_H_

#include <sqlite3.h>

namespace axiscal::storage {

// From now on statements of `db` may call row_crc32c(). Its result is the CRC-32C (core/base/crc32c.h) of its values in
// order, each as a byte for its type (SQLite's numbers: 1 integer, 2 real, 3 text, 4 blob, 5 null), integers and the
// bits of reals as 8 bytes, texts and blobs as the count of their bytes in 8 bytes and these; little endian. Files hold
// such sums, and migrations make them: what it gives never changes. What sqlite3_create_function() gives.
int AddRowChecksum(sqlite3* db);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_ROW_CHECKSUM_H_
