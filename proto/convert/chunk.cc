// Chunks of readings: the hot path of every upload.
#include <cmath>

#include "core/base/error_detail.h"
#include "core/session/checksum.h"
#include "proto/convert/session.h"

namespace axiscal::convert {
namespace {

absl::Status ChunkError(const v1::Chunk& message, const std::string& reason, const std::string& text) {
  return base::Error(absl::StatusCode::kInvalidArgument, absl::StrCat("chunk ", message.seq(), ": ", text),
                     {reason, {{"seq", absl::StrCat(message.seq())}, {"field", "chunk"}, {"rule", text}}});
}

// Empty when all are numbers or empty cells (NaN).
std::string FindInfinity(const session::Column& column) {
  for (size_t row = 0; row < column.values.size(); ++row) {
    if (std::isinf(column.values[row])) return absl::StrCat(column.name, ": reading ", row, " is infinite");
  }
  return "";
}

}  // namespace

v1::Chunk ToProto(const records::Chunk& chunk) {
  v1::Chunk message;
  message.set_seq(chunk.seq);
  message.set_crc32c(chunk.crc32c);
  for (const session::Column& column : chunk.columns) {
    v1::ColumnCells* const cells = message.add_columns();
    cells->mutable_values()->Add(column.values.begin(), column.values.end());
    for (const std::string& text : column.texts) cells->add_texts(text);
  }
  return message;
}

absl::StatusOr<records::Chunk> FromProto(const v1::Chunk& message, const std::vector<records::ColumnSpec>& columns) {
  if (message.seq() < 0) return ChunkError(message, "CHUNK_INVALID", "seq must be >= 0");
  if (message.columns_size() != static_cast<int>(columns.size())) {
    return ChunkError(message, "CHUNK_INVALID",
                      absl::StrCat(message.columns_size(), " columns, the session has ", columns.size()));
  }
  records::Chunk chunk{message.seq(), {}, message.crc32c()};
  chunk.columns.resize(columns.size());
  int readings = 0;
  for (int i = 0; i < message.columns_size(); ++i) {
    const v1::ColumnCells& cells = message.columns(i);
    const int count = columns[i].is_text ? cells.texts_size() : cells.values_size();
    const int wrong_kind_count = columns[i].is_text ? cells.values_size() : cells.texts_size();
    if (wrong_kind_count > 0) {
      return ChunkError(
          message, "CHUNK_INVALID",
          columns[i].name + (columns[i].is_text ? ": numbers, must be texts" : ": texts, must be numbers"));
    }
    if (i == 0) readings = count;
    if (count != readings || count < 1 || count > kMaxChunkReadings) {
      return ChunkError(message, "CHUNK_INVALID",
                        absl::StrCat(columns[i].name, ": ", count, " readings, must be 1 to ", kMaxChunkReadings,
                                     " and as many as in ", columns[0].name, " (", readings, ")"));
    }
    session::Column& column = chunk.columns[i];
    column.name = columns[i].name;
    column.values.assign(cells.values().begin(), cells.values().end());
    column.texts.assign(cells.texts().begin(), cells.texts().end());
    const std::string infinity = FindInfinity(column);
    if (!infinity.empty()) return ChunkError(message, "CHUNK_INVALID", infinity);
  }
  if (session::ChunkCrc32c(chunk.columns) != message.crc32c()) {
    return ChunkError(message, "CHUNK_CORRUPT", "its checksum does not fit its content: send it again");
  }
  return chunk;
}

}  // namespace axiscal::convert
