#include "server/storage/chunk_codec.h"

#include "core/base/status.h"
#include "core/records/chunk.h"
#include "server/storage/bytes.h"
#include "server/storage/column_codec.h"

namespace axiscal::storage {
namespace {

constexpr char kVersion = 1;

}  // namespace

std::string EncodeChunk(const std::vector<session::Column>& columns) {
  std::string bytes = {kVersion};
  PutVarint(bytes, columns.empty() ? 0 : std::max(columns[0].values.size(), columns[0].texts.size()));
  PutVarint(bytes, columns.size());
  for (const session::Column& column : columns) {
    const std::string coded = column.texts.empty() ? EncodeNumbers(column.values) : EncodeTexts(column.texts);
    PutVarint(bytes, coded.size());
    bytes += coded;
  }
  return bytes;
}

absl::StatusOr<std::vector<session::Column>> DecodeChunk(const std::string& bytes,
                                                         const std::vector<ColumnSpec>& specs) {
  ByteReader reader(bytes);
  if (reader.Byte() != kVersion) return absl::DataLossError("unknown version of chunk");
  const uint64_t count = reader.Varint();
  if (count < 1 || count > records::kMaxChunkReadings) return absl::DataLossError("impossible number of readings");
  if (reader.Varint() != specs.size() || !reader.ok()) return absl::DataLossError("wrong number of columns");
  std::vector<session::Column> columns(specs.size());
  for (size_t i = 0; i < specs.size(); ++i) {
    columns[i].name = specs[i].name;
    const uint64_t size = reader.Varint();
    const char* const start = reader.Take(size);
    if (start == nullptr) return absl::DataLossError("chunk is cut off");
    if (specs[i].is_text) {
      ASSIGN_OR_RETURN(columns[i].texts, DecodeTexts(ByteReader(start, size), count));
    } else {
      ASSIGN_OR_RETURN(columns[i].values, DecodeNumbers(ByteReader(start, size), count));
    }
  }
  if (reader.left() != 0) return absl::DataLossError("bytes are left over");
  return columns;
}

}  // namespace axiscal::storage
