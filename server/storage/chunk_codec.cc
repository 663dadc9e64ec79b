#include "server/storage/chunk_codec.h"

#include "core/base/error_detail.h"
#include "server/storage/bytes.h"
#include "server/storage/column_codec.h"

namespace axiscal::storage {
namespace {

constexpr char kVersion = 1;

absl::Status Invalid(const std::string& message) {
  return base::Error(absl::StatusCode::kInvalidArgument, message, {"CHUNK_INVALID", {}});
}

absl::Status CheckColumn(const session::Column& column, const ColumnSpec& spec, size_t count) {
  if (column.name != spec.name) return Invalid("column " + column.name + ", expected " + spec.name);
  const std::string kind = spec.is_text ? "texts" : "numbers";
  const size_t got = spec.is_text ? column.texts.size() : column.values.size();
  const size_t other = spec.is_text ? column.values.size() : column.texts.size();
  if (got != count || other != 0) {
    return Invalid(
        absl::StrCat("column ", column.name, " has ", got, " ", kind, ", expected ", count, " and nothing else"));
  }
  size_t text_bytes = 0;
  for (const std::string& text : column.texts) text_bytes += text.size();
  if (text_bytes > kMaxTextBytes) {
    return Invalid(
        absl::StrCat("column ", column.name, " has ", text_bytes, " bytes of text, at most ", kMaxTextBytes));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckColumns(const std::vector<session::Column>& columns, const std::vector<ColumnSpec>& specs) {
  if (columns.size() != specs.size()) {
    return Invalid(absl::StrCat(columns.size(), " columns, the session has ", specs.size()));
  }
  const size_t count = columns.empty() ? 0 : specs[0].is_text ? columns[0].texts.size() : columns[0].values.size();
  if (count < 1 || count > kMaxChunkReadings) {
    return Invalid(absl::StrCat(count, " readings in a chunk, must be 1 .. ", kMaxChunkReadings));
  }
  for (size_t i = 0; i < columns.size(); ++i) RETURN_IF_ERROR(CheckColumn(columns[i], specs[i], count));
  return absl::OkStatus();
}

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
  if (count < 1 || count > kMaxChunkReadings) return absl::DataLossError("impossible number of readings");
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
