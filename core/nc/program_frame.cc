#include "core/nc/program_frame.h"

#include <cstring>

namespace axiscal::nc {

bool ProgramFrame::IsNumberedPercent(const char* at, const char* end) {
  if (*at != 'N' && *at != 'n') return false;
  const char* const number = ++at;
  while (at != end && *at >= '0' && *at <= '9') ++at;
  if (at == number) return false;
  while (at != end && (*at == ' ' || *at == '\t')) ++at;
  if (at == end || *at != '%') return false;
  for (++at; at != end; ++at) {
    if (*at != ' ' && *at != '\t' && *at != '\r') return false;
  }
  return true;
}

ProgramFrame::Kind ProgramFrame::ReadSlowly(int64_t line, const char** text, size_t* size) {
  if (line == 1 && *size >= 3 && std::memcmp(*text, "\xEF\xBB\xBF", 3) == 0) {
    *text += 3;
    *size -= 3;
  }
  const char* at = *text;
  const char* const end = *text + *size;
  while (at != end && (*at == ' ' || *at == '\t' || *at == '\r' || *at == 0)) ++at;
  if (at == end) return Kind::kNotABlock;
  if (end - at > 3 && std::memcmp(at, "%_N", 3) == 0 && !has_ended_) {
    has_begun_ = true;
    return Kind::kHead;
  }
  if (has_ended_ && !is_cut_) {
    if (*at == '%') return Kind::kSecondProgram;
    if (*at == kSubstitute || has_tail_) return Kind::kNotABlock;
    has_tail_ = true;
    return Kind::kTail;
  }
  if (*at == '%' || IsNumberedPercent(at, end)) {
    has_ended_ = has_begun_;
    has_begun_ = true;
    is_cut_ = false;
    return Kind::kNotABlock;
  }
  is_cut_ |= *at == kSubstitute;
  has_ended_ |= is_cut_;
  while (at != end && (*at == kSubstitute || *at == ' ' || *at == '\t' || *at == '\r')) ++at;
  if (is_cut_) return at == end ? Kind::kNotABlock : Kind::kBehindCut;
  while ((*text)[*size - 1] == kSubstitute) {
    --*size;
    has_ended_ = is_cut_ = true;
  }
  has_begun_ = true;
  return Kind::kBlock;
}

}  // namespace axiscal::nc
