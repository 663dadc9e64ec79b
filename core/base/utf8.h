// UTF-8 as RFC 3629 has it: no overlong forms, no surrogates, at most U+10FFFF. Protobuf's text fields must hold it: a
// message with one that does not is refused whole by those who read it.
#ifndef AXISCAL_CORE_BASE_UTF8_H_
#define AXISCAL_CORE_BASE_UTF8_H_

#include <string>

namespace axiscal::base {

// Bytes of the well-formed character that begins at `at` (< text.size()); 0: none does.
size_t Utf8Bytes(const std::string& text, size_t at);

bool IsUtf8(const std::string& text);

// `text` where it is UTF-8; otherwise with U+FFFD for each byte that belongs to no character.
std::string ToUtf8(std::string text);

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_UTF8_H_
