#include "core/session/line_reader.h"

#include <cstring>

namespace axiscal::session {
namespace {

constexpr size_t kBlockBytes = size_t{1} << 20;

absl::Status CheckStart(std::string& buffer) {
  const auto starts_with = [&buffer](const char* mark) { return buffer.compare(0, std::strlen(mark), mark) == 0; };
  if (starts_with("\xFF\xFE") || starts_with("\xFE\xFF")) {
    return absl::InvalidArgumentError("line 1: UTF-16 (a byte-order mark), expected UTF-8");
  }
  if (starts_with("\xEF\xBB\xBF")) buffer.erase(0, 3);
  return absl::OkStatus();
}

}  // namespace

// Moves the unread part to the front and reads one more block behind it.
absl::Status LineReader::Fill() {
  buffer_.erase(0, begin_);
  begin_ = 0;
  const size_t kept = buffer_.size();
  buffer_.resize(kept + kBlockBytes);
  in_.read(buffer_.data() + kept, static_cast<std::streamsize>(kBlockBytes));
  const size_t got = static_cast<size_t>(in_.gcount());
  buffer_.resize(kept + got);
  if (in_.bad()) return absl::DataLossError("reading failed");
  at_end_ = got < kBlockBytes;
  const bool is_first = total_bytes_ == 0;
  total_bytes_ += got;
  if (total_bytes_ > most_bytes_) {
    return absl::InvalidArgumentError(absl::StrCat("more than ", most_bytes_, " bytes (", most_bytes_ >> 20,
                                                   " MB), the limit of a session file: split the session"));
  }
  if (const void* nul = std::memchr(buffer_.data() + kept, '\0', got); nul != nullptr) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a NUL byte at byte ", total_bytes_ - got + (static_cast<const char*>(nul) - buffer_.data() - kept),
        ": this is no text file, expected a session in UTF-8"));
  }
  return is_first ? CheckStart(buffer_) : absl::OkStatus();
}

absl::StatusOr<bool> LineReader::Next(Line* line) {
  if (total_bytes_ == 0 && !at_end_) RETURN_IF_ERROR(Fill());
  const auto find = [this] {
    return begin_ == buffer_.size()
               ? nullptr
               : static_cast<const char*>(std::memchr(buffer_.data() + begin_, '\n', buffer_.size() - begin_));
  };
  const char* end = find();
  if (end == nullptr && !at_end_) {
    RETURN_IF_ERROR(Fill());
    end = find();
  }
  const char* const start = buffer_.data() + begin_;
  size_t length = end != nullptr ? static_cast<size_t>(end - start) : buffer_.size() - begin_;
  if (end == nullptr && length == 0) return false;
  ++line_number_;
  if (length > kMaxLineBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat("line ", line_number_, ": longer than ", kMaxLineBytes, " bytes, this is no session file"));
  }
  begin_ += length + (end != nullptr ? 1 : 0);
  if (end != nullptr && length > 0 && start[length - 1] == '\r') --length;
  *line = {std::string_view(start, length), line_number_, end != nullptr};
  return true;
}

}  // namespace axiscal::session
