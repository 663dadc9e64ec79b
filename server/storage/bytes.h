// Building and taking apart small binary records. A reader never runs past its end: it remembers that it failed and
// gives zeros.
#ifndef AXISCAL_SERVER_STORAGE_BYTES_H_
#define AXISCAL_SERVER_STORAGE_BYTES_H_

#include <cstddef>
#include <cstdint>
#include <string>

namespace axiscal::storage {

// LEB128: 7 bits a byte, low ones first.
inline void PutVarint(std::string& bytes, uint64_t number) {
  for (; number >= 0x80; number >>= 7) bytes += static_cast<char>(number | 0x80);
  bytes += static_cast<char>(number);
}

// Small magnitudes of either sign become small numbers: 0, -1, 1, -2 ... are 0, 1, 2, 3 ...
inline uint64_t ZigZag(int64_t number) {
  return (static_cast<uint64_t>(number) << 1) ^ static_cast<uint64_t>(number >> 63);
}
inline int64_t UnZigZag(uint64_t code) { return static_cast<int64_t>(code >> 1) ^ -static_cast<int64_t>(code & 1); }

class ByteReader {
 public:
  ByteReader(const char* data, size_t size) : data_(data), left_(size) {}
  explicit ByteReader(const std::string& bytes) : ByteReader(bytes.data(), bytes.size()) {}

  uint8_t Byte() {
    const char* byte = Take(1);
    return byte != nullptr ? static_cast<uint8_t>(*byte) : 0;
  }
  uint64_t Varint() {
    uint64_t number = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      const uint8_t byte = Byte();
      number |= static_cast<uint64_t>(byte & 0x7f) << shift;
      if (byte < 0x80) return number;
    }
    ok_ = false;
    return 0;
  }
  // The next `size` bytes, or nullptr.
  const char* Take(size_t size) {
    ok_ = ok_ && size <= left_;
    if (!ok_) return nullptr;
    const char* const start = data_;
    data_ += size;
    left_ -= size;
    return start;
  }
  size_t left() const { return left_; }
  bool ok() const { return ok_; }

 private:
  const char* data_;
  size_t left_;
  bool ok_ = true;
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_BYTES_H_
