// A chunk: consecutive readings of all columns of a session, as they travel and are stored. Whoever holds a Chunk holds
// readings whose shape and checksum are right: only its two makers make one, so nobody looks twice.
#ifndef AXISCAL_CORE_RECORDS_CHUNK_H_
#define AXISCAL_CORE_RECORDS_CHUNK_H_

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/status.h"
#include "core/records/session.h"
#include "core/session/session.h"

namespace axiscal::records {

// The most readings of one chunk, on the wire and in the store.
inline constexpr int kMaxChunkReadings = 4096;
// All texts of one column of a chunk together have at most so many bytes.
inline constexpr size_t kMaxChunkTextBytes = size_t{8} << 20;

// Always: `seq` >= 0; at least one column; all columns equally long, 1 to kMaxChunkReadings readings, each with values
// or with texts; crc32c() is session::ChunkCrc32c(columns()).
class Chunk {
 public:
  // Of readings of our own, which are as said above: computes the checksum.
  static Chunk Seal(int64_t seq, std::vector<session::Column> columns);

  // Of readings that came from elsewhere with their checksum. INVALID_ARGUMENT CHUNK_INVALID when they do not fit
  // `specs`: number, names and kinds of the columns; a shape other than said above, an infinity (NaN is an empty cell,
  // which the session's reader judges). CHUNK_CORRUPT when the checksum does not fit. Facts: seq, field, rule.
  static absl::StatusOr<Chunk> Verify(int64_t seq, std::vector<session::Column> columns, uint32_t crc32c,
                                      const std::vector<ColumnSpec>& specs);

  int64_t seq() const { return seq_; }
  int reading_count() const { return ReadingCount(columns_[0]); }
  const std::vector<session::Column>& columns() const { return columns_; }
  uint32_t crc32c() const { return crc32c_; }

  // Whether these are readings of a session with such columns.
  bool HasColumns(const std::vector<ColumnSpec>& specs) const;

 private:
  Chunk(int64_t seq, std::vector<session::Column> columns, uint32_t crc32c)
      : seq_(seq), columns_(std::move(columns)), crc32c_(crc32c) {}
  static int ReadingCount(const session::Column& column) {
    return static_cast<int>(std::max(column.values.size(), column.texts.size()));
  }

  int64_t seq_;
  std::vector<session::Column> columns_;
  uint32_t crc32c_;
};

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_CHUNK_H_
