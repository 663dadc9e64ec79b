// Bytes on their way out: like a string, but room can be taken without being filled first.
#ifndef AXISCAL_CORE_NC_OUT_BUFFER_H_
#define AXISCAL_CORE_NC_OUT_BUFFER_H_

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

namespace axiscal::nc {

class OutBuffer {
 public:
  const char* data() const { return bytes_.data(); }
  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  void clear() { size_ = 0; }

  // At least `size` bytes to write to, behind what is there; Take says where the writing ended.
  char* Room(size_t size) {
    if (bytes_.size() - size_ < size) bytes_.resize(std::max(2 * bytes_.size(), size_ + size));
    return bytes_.data() + size_;
  }
  void Take(const char* end) { size_ = static_cast<size_t>(end - bytes_.data()); }

  void append(const char* bytes, size_t size) {
    if (size == 0) return;
    std::memcpy(Room(size), bytes, size);
    size_ += size;
  }
  void append(const std::string& bytes) { append(bytes.data(), bytes.size()); }
  void insert(size_t at, const std::string& bytes) {
    Room(bytes.size());
    std::memmove(bytes_.data() + at + bytes.size(), bytes_.data() + at, size_ - at);
    std::memcpy(bytes_.data() + at, bytes.data(), bytes.size());
    size_ += bytes.size();
  }
  void push_back(char c) {
    *Room(1) = c;
    ++size_;
  }

 private:
  std::vector<char> bytes_;
  size_t size_ = 0;
};

// Copies a few bytes, without the call that memcpy is for a size that is not known. Returns the end.
inline char* CopyShort(const char* from, size_t size, char* to) {
  if (size >= 16) {
    for (; size > 16; from += 16, to += 16, size -= 16) __builtin_memcpy(to, from, 16);
    // What is left, with some of the last step again.
    __builtin_memcpy(to + size - 16, from + size - 16, 16);
    return to + size;
  }
  if (size & 8) __builtin_memcpy(to, from, 8), to += 8, from += 8;
  if (size & 4) __builtin_memcpy(to, from, 4), to += 4, from += 4;
  if (size & 2) __builtin_memcpy(to, from, 2), to += 2, from += 2;
  if (size & 1) *to++ = *from;
  return to;
}

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_OUT_BUFFER_H_
