// zstd with a context kept per thread. Level 1: measured logs gain nothing from higher ones, ingest loses much.
#ifndef AXISCAL_SERVER_STORAGE_ZSTD_BYTES_H_
#define AXISCAL_SERVER_STORAGE_ZSTD_BYTES_H_

#include <cstddef>
#include <string>

#include "absl/status/statusor.h"

namespace axiscal::storage {

std::string Compress(const std::string& bytes);
// DATA_LOSS unless `data` is one frame of exactly `raw_size` bytes.
absl::StatusOr<std::string> Decompress(const char* data, size_t size, size_t raw_size);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_ZSTD_BYTES_H_
