#include "core/nc/move_reader.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "core/base/files.h"

namespace axiscal::nc {

absl::StatusOr<bool> MoveReader::Next(Event* event) {
  while (events_.empty()) {
    if (is_at_end_) return false;
    ASSIGN_OR_RETURN(const size_t size, reader_(buffer_.data(), buffer_.size()));
    const auto read = [this](const char* text, size_t length, bool is_overlong) { Line(text, length, is_overlong); };
    const auto line = [&](const char* text, size_t length, bool is_overlong) {
      preamble_.Take(interpreter_.dialect(), text, length, is_overlong, read,
                     [this](const char*, size_t) { interpreter_.SkipLine(); });
    };
    if (size == 0) {
      is_at_end_ = true;
      splitter_.Finish(line);
      preamble_.Finish(read);
    } else {
      splitter_.Feed(buffer_.data(), size, line, [](const char*, size_t) {});
    }
  }
  *event = std::move(events_.front());
  events_.pop_front();
  return true;
}

void MoveReader::Line(const char* text, size_t size, bool is_overlong) {
  if (is_overlong) {
    interpreter_.ReadOverlong(&step_);
  } else {
    interpreter_.Read(text, TextSize(text, size), &block_, &step_);
  }
  const bool is_event = step_.kind != StepKind::kNone || step_.is_tool_change || step_.ends_program;
  if (is_event) events_.push_back({interpreter_.line(), step_});
}

ByteReader TextReader(const std::string& text) {
  auto at = std::make_shared<size_t>(0);
  return [&text, at](char* buffer, size_t size) -> absl::StatusOr<size_t> {
    const size_t count = std::min(size, text.size() - *at);
    std::memcpy(buffer, text.data() + *at, count);
    *at += count;
    return count;
  };
}

absl::StatusOr<ByteReader> FileReader(const std::string& path) {
  RETURN_IF_ERROR(base::RequireFile(path));
  const std::shared_ptr<std::FILE> file(std::fopen(path.c_str(), "rb"), [](std::FILE* open) {
    if (open != nullptr) std::fclose(open);
  });
  if (file == nullptr) {
    const std::string message = absl::StrCat("cannot open ", path, ": ", std::strerror(errno));
    return errno == ENOENT ? absl::NotFoundError(message) : absl::UnavailableError(message);
  }
  return ByteReader([file, path](char* buffer, size_t size) -> absl::StatusOr<size_t> {
    const size_t count = std::fread(buffer, 1, size, file.get());
    if (count == 0 && std::ferror(file.get())) return absl::UnavailableError(absl::StrCat("cannot read ", path));
    return count;
  });
}

}  // namespace axiscal::nc
