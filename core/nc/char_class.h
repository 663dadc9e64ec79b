// What a byte is to the lexer.
#ifndef AXISCAL_CORE_NC_CHAR_CLASS_H_
#define AXISCAL_CORE_NC_CHAR_CLASS_H_

#include <cstdint>
#include <string_view>

#include "core/nc/plain_words.h"

namespace axiscal::nc {

enum CharClass : uint8_t { kOther, kBlank, kDigit, kUpper, kLower, kMacro };

struct CharClasses {
  uint8_t of[256];
  constexpr CharClasses() : of() {
    of[static_cast<int>(' ')] = of[static_cast<int>('\t')] = kBlank;
    for (int c = '0'; c <= '9'; ++c) of[c] = kDigit;
    for (int c = 'A'; c <= 'Z'; ++c) of[c] = kUpper;
    of[static_cast<int>(':')] = kUpper;  // ISO's letter of the program number
    for (int c = 'a'; c <= 'z'; ++c) of[c] = kLower;
    for (const char c : {'#', '[', ']', '=', ',', '<', '>', '*'}) of[static_cast<int>(c)] = kMacro;
  }
};
inline constexpr CharClasses kClasses;

inline uint8_t Class(char c) { return kClasses.of[static_cast<unsigned char>(c)]; }
inline char Capital(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

inline std::string_view WithoutBlanks(std::string_view text) {
  while (!text.empty() && Class(text.front()) == kBlank) text.remove_prefix(1);
  while (!text.empty() && Class(text.back()) == kBlank) text.remove_suffix(1);
  return text;
}

// Digits up to `end`.
inline const char* ReadDigits(const char* at, const char* end, uint64_t* number) {
  uint64_t value = *number;
  for (; at != end && Digit(*at) <= 9; ++at) value = value * 10 + Digit(*at);
  *number = value;
  return at;
}

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_CHAR_CLASS_H_
