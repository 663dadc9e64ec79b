// Chunks of readings: the hot path of every upload.
#include "proto/convert/session.h"

namespace axiscal::convert {

v1::Chunk ToProto(const records::Chunk& chunk) {
  v1::Chunk message;
  message.set_seq(chunk.seq());
  message.set_crc32c(chunk.crc32c());
  for (const session::Column& column : chunk.columns()) {
    v1::ColumnCells* const cells = message.add_columns();
    cells->mutable_values()->Add(column.values.begin(), column.values.end());
    for (const std::string& text : column.texts) cells->add_texts(text);
  }
  return message;
}

absl::StatusOr<records::Chunk> FromProto(const v1::Chunk& message, const std::vector<records::ColumnSpec>& columns) {
  std::vector<session::Column> cells(static_cast<size_t>(message.columns_size()));
  for (size_t i = 0; i < cells.size(); ++i) {
    const v1::ColumnCells& from = message.columns(static_cast<int>(i));
    if (i < columns.size()) cells[i].name = columns[i].name;  // names do not travel with every chunk
    cells[i].values.assign(from.values().begin(), from.values().end());
    cells[i].texts.assign(from.texts().begin(), from.texts().end());
  }
  return records::Chunk::Verify(message.seq(), std::move(cells), message.crc32c(), columns);
}

}  // namespace axiscal::convert
