// The words that nearly every block consists of: a capital letter, directly behind it a number of at most 18 digits
// without blanks inside, blanks. Everything else is the lexer's (lexer.cc). Inline: this runs for every word of a
// program.
#ifndef AXISCAL_CORE_NC_PLAIN_WORDS_H_
#define AXISCAL_CORE_NC_PLAIN_WORDS_H_

#include <cstddef>

#include "core/nc/block.h"

namespace axiscal::nc {

inline unsigned Digit(char c) { return static_cast<unsigned char>(c) - static_cast<unsigned>('0'); }

// Digits up to a byte that is none: the line's end at the latest.
inline const char* ReadDigits(const char* at, uint64_t* number) {
  uint64_t value = *number;
  for (unsigned digit; (digit = Digit(*at)) <= 9; ++at) value = value * 10 + digit;
  *number = value;
  return at;
}

// Fills `word` and returns where the next one begins; nullptr when it is not plain. Need not look for `end`: no word
// goes on there.
inline const char* ReadPlainWord(const char* text, const char* at, const char* end, Word* word) {
  const char letter = *at;
  if (letter < 'A' || letter > 'Z') return nullptr;
  const char sign = at[1];
  const char* const first = at + 1 + (sign == '-' || sign == '+');
  uint64_t mantissa = 0;
  const char* last = ReadDigits(first, &mantissa);
  ptrdiff_t digits = last - first, decimals = 0;
  const bool has_point = *last == '.';
  if (has_point) {
    const char* const fraction = last + 1;
    last = ReadDigits(fraction, &mantissa);
    decimals = last - fraction;
    digits += decimals;
  }
  if (digits == 0 || digits > 18) return nullptr;
  const char* next = last;
  while (*next == ' ') ++next;
  // Another part of the number behind a blank, or a character that the slow way must judge.
  if ((*next < 'A' || *next > 'Z') && next != end) return nullptr;
  word->letter = letter;
  word->is_lower = false;
  word->distance = Distance::kModal;
  word->letter_at = static_cast<uint32_t>(at - text);
  word->number_at = word->letter_at + 1;
  word->end = static_cast<uint32_t>(last - text);
  word->number.mantissa = sign == '-' ? -static_cast<int64_t>(mantissa) : static_cast<int64_t>(mantissa);
  word->number.decimals = static_cast<int8_t>(decimals);
  word->number.digits = static_cast<int8_t>(digits);
  word->number.has_point = has_point;
  word->number.has_plus = sign == '+';
  return next;
}

// Appends plain words to the block and returns where the first byte stands that belongs to none of them.
inline const char* ReadPlainWords(const char* text, const char* at, const char* end, Block* block) {
  int count = block->word_count;
  while (at != end && count < kMaxWords) {
    const char* const next = ReadPlainWord(text, at, end, &block->words[static_cast<size_t>(count)]);
    if (next == nullptr) break;
    at = next;
    ++count;
  }
  block->word_count = count;
  return at;
}

// Whether the block is plain words from its first byte to its last; `block` has them then. Looks first whether each
// word is laid out as the one at its place in the line before was, which `block` remembers.
bool ReadPlainBlock(const char* text, const char* end, Block* block);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_PLAIN_WORDS_H_
