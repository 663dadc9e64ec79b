// Lines of a stream, read in blocks: a file of any size costs one block of memory.
#ifndef AXISCAL_CORE_SESSION_LINE_READER_H_
#define AXISCAL_CORE_SESSION_LINE_READER_H_

#include <istream>
#include <string>
#include <string_view>

#include "core/base/status.h"

namespace axiscal::session {

inline constexpr size_t kMaxSessionBytes = size_t{256} << 20;
inline constexpr size_t kMaxLineBytes = size_t{64} << 10;

struct Line {
  std::string_view text;      // without its line end (LF or CRLF); valid until the next call
  size_t number = 0;          // from 1
  bool has_line_end = false;  // false: the stream ended inside this line
};

class LineReader {
 public:
  // The stream must outlive the reader. A UTF-8 byte-order mark at its start is passed over. Beyond `most_bytes`
  // nothing is read.
  explicit LineReader(std::istream& in, size_t most_bytes = kMaxSessionBytes) : in_(in), most_bytes_(most_bytes) {}

  // False at the end of the stream, else `line` is the next line. INVALID_ARGUMENT: beyond the most bytes or
  // kMaxLineBytes, a NUL byte (no text file), UTF-16. DATA_LOSS: the stream failed.
  absl::StatusOr<bool> Next(Line* line);
  // Of the stream, up to the block that is read now.
  size_t bytes_read() const { return total_bytes_; }

 private:
  absl::Status Fill();

  std::istream& in_;
  const size_t most_bytes_;
  std::string buffer_;
  size_t begin_ = 0;  // of the unread part of buffer_
  size_t total_bytes_ = 0;
  size_t line_number_ = 0;
  bool at_end_ = false;
};

}  // namespace axiscal::session

#endif  // AXISCAL_CORE_SESSION_LINE_READER_H_
