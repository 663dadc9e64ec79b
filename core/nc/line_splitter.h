// Cuts a stream of bytes into lines, in constant memory: lines that lie within one piece are not copied.
#ifndef AXISCAL_CORE_NC_LINE_SPLITTER_H_
#define AXISCAL_CORE_NC_LINE_SPLITTER_H_

#include <cstring>
#include <string>

namespace axiscal::nc {

inline constexpr size_t kMaxLineBytes = 1u << 16;

class LineSplitter {
 public:
  // Calls line(text, size, is_overlong) for each complete line, its end included. A line of more than kMaxLineBytes
  // comes in pieces: the first with is_overlong, the following ones as `rest`(text, size), its end last.
  template <typename Line, typename Rest>
  void Feed(const char* bytes, size_t size, Line&& line, Rest&& rest) {
    const char* const end = bytes + size;
    while (bytes != end) {
      const void* const found = std::memchr(bytes, '\n', static_cast<size_t>(end - bytes));
      const char* const next = found ? static_cast<const char*>(found) + 1 : end;
      const size_t length = static_cast<size_t>(next - bytes);
      if (is_in_overlong_) {
        rest(bytes, length);
        is_in_overlong_ = found == nullptr;
      } else if (carry_.size() + length > kMaxLineBytes) {
        carry_.append(bytes, length);
        line(carry_.data(), carry_.size(), true);
        carry_.clear();
        is_in_overlong_ = found == nullptr;
      } else if (found == nullptr) {
        carry_.append(bytes, length);
      } else if (carry_.empty()) {
        line(bytes, length, false);
      } else {
        carry_.append(bytes, length);
        line(carry_.data(), carry_.size(), false);
        carry_.clear();
      }
      bytes = next;
    }
  }

  // The last line when the stream does not end with a line end.
  template <typename Line>
  void Finish(Line&& line) {
    if (!carry_.empty()) line(carry_.data(), carry_.size(), false);
    carry_.clear();
  }

 private:
  std::string carry_;
  bool is_in_overlong_ = false;
};

// Size of a line without its "\n" or "\r\n".
inline size_t TextSize(const char* line, size_t size) {
  if (size > 0 && line[size - 1] == '\n') --size;
  if (size > 0 && line[size - 1] == '\r') --size;
  return size;
}

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_LINE_SPLITTER_H_
