#include "core/records/chunk.h"

#include <cmath>

#include "core/base/demand.h"
#include "core/base/error_detail.h"
#include "core/session/checksum.h"

namespace axiscal::records {
namespace {

absl::Status Refuse(int64_t seq, const std::string& reason, const std::string& text) {
  return base::Error(absl::StatusCode::kInvalidArgument, absl::StrCat("chunk ", seq, ": ", text),
                     {reason, {{"seq", absl::StrCat(seq)}, {"field", "chunk"}, {"rule", text}}});
}

// What is wrong with a column, or nothing. `readings` are those of the chunk's first column, `first`.
std::string WrongIn(const session::Column& column, const ColumnSpec& spec, size_t readings, const std::string& first) {
  if (column.name != spec.name) return absl::StrCat("column ", column.name, ", expected ", spec.name);
  const size_t count = spec.is_text ? column.texts.size() : column.values.size();
  const size_t wrong_kind_count = spec.is_text ? column.values.size() : column.texts.size();
  if (wrong_kind_count > 0) {
    return column.name + (spec.is_text ? ": numbers, must be texts" : ": texts, must be numbers");
  }
  if (count != readings || count < 1 || count > kMaxChunkReadings) {
    return absl::StrCat(column.name, ": ", count, " readings, must be 1 to ", kMaxChunkReadings, " and as many as in ",
                        first, " (", readings, ")");
  }
  // All are looked at: a loop without a way out is several times faster.
  bool has_infinity = false;
  for (const double value : column.values) has_infinity |= std::isinf(value);
  for (size_t row = 0; has_infinity && row < count; ++row) {
    if (std::isinf(column.values[row])) return absl::StrCat(column.name, ": reading ", row, " is infinite");
  }
  size_t text_bytes = 0;
  for (const std::string& text : column.texts) text_bytes += text.size();
  if (text_bytes > kMaxChunkTextBytes) {
    return absl::StrCat(column.name, ": ", text_bytes, " bytes of text, at most ", kMaxChunkTextBytes);
  }
  return "";
}

}  // namespace

Chunk Chunk::Seal(int64_t seq, std::vector<session::Column> columns) {
  DEMAND(seq >= 0 && !columns.empty());
  const int readings = ReadingCount(columns[0]);
  DEMAND(readings >= 1 && readings <= kMaxChunkReadings);
  for (const session::Column& column : columns) {
    DEMAND(ReadingCount(column) == readings && (column.values.empty() || column.texts.empty()));
  }
  const uint32_t crc32c = session::ChunkCrc32c(columns);
  return Chunk(seq, std::move(columns), crc32c);
}

absl::StatusOr<Chunk> Chunk::Verify(int64_t seq, std::vector<session::Column> columns, uint32_t crc32c,
                                    const std::vector<ColumnSpec>& specs) {
  if (seq < 0) return Refuse(seq, "CHUNK_INVALID", "seq must be >= 0");
  if (columns.size() != specs.size() || columns.empty()) {
    return Refuse(seq, "CHUNK_INVALID", absl::StrCat(columns.size(), " columns, the session has ", specs.size()));
  }
  const size_t readings = specs[0].is_text ? columns[0].texts.size() : columns[0].values.size();
  for (size_t i = 0; i < columns.size(); ++i) {
    const std::string wrong = WrongIn(columns[i], specs[i], readings, specs[0].name);
    if (!wrong.empty()) return Refuse(seq, "CHUNK_INVALID", wrong);
  }
  if (session::ChunkCrc32c(columns) != crc32c) {
    return Refuse(seq, "CHUNK_CORRUPT", "its checksum does not fit its content: send it again");
  }
  return Chunk(seq, std::move(columns), crc32c);
}

bool Chunk::HasColumns(const std::vector<ColumnSpec>& specs) const {
  return std::equal(columns_.begin(), columns_.end(), specs.begin(), specs.end(),
                    [](const session::Column& column, const ColumnSpec& spec) {
                      return column.name == spec.name && column.texts.empty() != spec.is_text;
                    });
}

}  // namespace axiscal::records
