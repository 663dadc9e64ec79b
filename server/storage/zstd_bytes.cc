#include "server/storage/zstd_bytes.h"

#include <zstd.h>

#include <memory>

#include "core/base/demand.h"

namespace axiscal::storage {
namespace {

constexpr int kLevel = 1;

}  // namespace

std::string Compress(const std::string& bytes) {
  thread_local const std::unique_ptr<ZSTD_CCtx, size_t (*)(ZSTD_CCtx*)> context(ZSTD_createCCtx(), ZSTD_freeCCtx);
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  const size_t size =
      ZSTD_compressCCtx(context.get(), packed.data(), packed.size(), bytes.data(), bytes.size(), kLevel);
  DEMAND(!ZSTD_isError(size));  // the buffer is large enough for anything
  packed.resize(size);
  return packed;
}

absl::StatusOr<std::string> Decompress(const char* data, size_t size, size_t raw_size) {
  thread_local const std::unique_ptr<ZSTD_DCtx, size_t (*)(ZSTD_DCtx*)> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
  std::string bytes(raw_size, '\0');
  const size_t got = ZSTD_decompressDCtx(context.get(), bytes.data(), bytes.size(), data, size);
  if (ZSTD_isError(got)) return absl::DataLossError(std::string("zstd: ") + ZSTD_getErrorName(got));
  if (got != raw_size) return absl::DataLossError("zstd: wrong size");
  return bytes;
}

}  // namespace axiscal::storage
