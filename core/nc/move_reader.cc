#include "core/nc/move_reader.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "core/base/files.h"
#include "core/nc/hole_patterns.h"

namespace axiscal::nc {

absl::StatusOr<bool> MoveReader::Fill() {
  while (next_ == count_) {
    next_ = count_ = 0;
    if (is_at_end_ && is_waiting_ && RunNext()) continue;
    if (is_at_end_ && corners_.is_holding()) {
      corners_.Release(kNoMoveBehind, this);
      continue;
    }
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
      splitter_.Feed(buffer_.data(), size, line, [this](const char* text, size_t length) {
        if (is_waiting_) waiting_.back().append(text, length);
      });
    }
  }
  return true;
}

absl::StatusOr<bool> MoveReader::Next(Event* event) {
  ASSIGN_OR_RETURN(const bool has_event, Fill());
  if (has_event) *event = std::move(events_[next_++]);
  return has_event;
}

absl::Status MoveReader::NextSome(std::vector<Event>* events, size_t* count) {
  ASSIGN_OR_RETURN(const bool has_event, Fill());
  *count = has_event ? count_ : 0;
  events->swap(events_);
  next_ = count_ = 0;
  return absl::OkStatus();
}

bool MoveReader::RunNext() {
  if (execution_ == nullptr) {
    execution_ = std::make_unique<Execution>(interpreter_.dialect(), interpreter_.options(), std::move(waiting_),
                                             first_waiting_);
  }
  Execution::Event event;
  if (!execution_->Next(&event)) return false;
  if (event.kind != Execution::Event::Kind::kLine || event.is_call || event.is_followed_return)
    corners_.Release(kNoMoveBehind, this);
  const std::string& block = execution_->lines(event.text)[event.line];
  if (event.is_call) interpreter_.NoteCallBlock(block);
  if (event.kind == Execution::Event::Kind::kEnter) interpreter_.EnterLevel();
  if (event.kind == Execution::Event::Kind::kLeave) interpreter_.LeaveLevel();
  if (event.kind != Execution::Event::Kind::kLine) return true;
  interpreter_.SetLine(execution_->line_number(event.text, event.line), event.is_followed_return, event.is_call,
                       event.call_problem);
  Line(block.data(), block.size(), block.size() > kMaxLineBytes);
  return true;
}

void MoveReader::Line(const char* text, size_t size, bool is_overlong) {
  if (is_waiting_ && execution_ == nullptr) {
    waiting_.emplace_back(text, size);
    return;
  }
  if (is_overlong) {
    corners_.Release("the block behind it is too long to be one", this);
  } else if (corners_.Wants(interpreter_.dialect(), text, size)) {
    return corners_.Take(interpreter_.line() + 1 + (is_waiting_ ? 0 : corners_.held_lines()), text, size, this);
  }
  ReadOrExpand(text, size, is_overlong);
}

void MoveReader::ReadOrExpand(const char* text, size_t size, bool is_overlong) {
  if (is_overlong || !MayBeHolePattern(interpreter_.dialect(), text, TextSize(text, size)))
    return ReadLine(text, size, is_overlong);
  const HolePattern pattern = ReadHolePattern(interpreter_, text, size);
  if (pattern.lines.empty()) return ReadLine(text, size, false);
  const int64_t number = interpreter_.line() + 1;
  for (const std::string& line : pattern.lines) {
    interpreter_.ReadAs(number);
    ReadLine(line.data(), line.size(), false);
  }
}

void MoveReader::ReadLine(const char* text, size_t size, bool is_overlong) {
  if (is_overlong) {
    interpreter_.ReadOverlong(&step_);
  } else {
    interpreter_.Read(text, TextSize(text, size), &block_, &step_);
  }
  if (step_.begins_structure) {
    is_waiting_ = true;
    first_waiting_ = interpreter_.line() + 1;
    waiting_.emplace_back(text, size);
    return;
  }
  const bool is_event = step_.kind != StepKind::kNone || step_.is_tool_change || step_.ends_program;
  if (!is_event) return;
  if (count_ == events_.size()) events_.emplace_back();
  Event& event = events_[count_++];
  event.line = interpreter_.line();
  event.step = step_;
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
