#include "core/nc/plain_words.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace axiscal::nc {
namespace {

// Characters as the layouts see them: digits are 0 to 9.
constexpr uint64_t kZeros = 0x3030303030303030;

// Eight digits, the first one in the lowest byte.
inline uint64_t NumberOf(uint64_t digits) {
  digits = digits * 10 + (digits >> 8);  // of two each, in every other byte
  const uint64_t outer = (digits & 0x000000FF000000FF) * 0x000F424000000064;
  const uint64_t inner = ((digits >> 16) & 0x000000FF000000FF) * 0x0000271000000001;
  return (outer + inner) >> 32;
}

// ReadPlainWord for a word with the same layout as an earlier one, which `layout` and the rest of `word` describe: all
// digits are read at once. Returns its end, or nullptr where the layout differs. A digit or a point may follow.
inline const char* ReadAlikeWord(const char* text, const char* at, const char* end, const WordLayout& layout,
                                 Word* word) {
  if (layout.size == 0 || end - at < static_cast<ptrdiff_t>(layout.size)) return nullptr;
  const char* const last = at + layout.size;
  uint16_t head;
  uint64_t eight;
  __builtin_memcpy(&head, at, sizeof(head));
  if (last - text >= 8) {
    __builtin_memcpy(&eight, last - 8, sizeof(eight));
  } else {
    if (end - text < 8) return nullptr;
    __builtin_memcpy(&eight, text, sizeof(eight));
    eight <<= 8 * (8 - (last - text));
  }
  eight ^= kZeros;
  if ((head & layout.head_mask) != layout.head || (eight & layout.point_mask) != layout.point) return nullptr;
  eight = (eight & layout.fraction_mask) | ((eight << layout.point_shift) & layout.whole_mask);
  if ((((eight + 0x0606060606060606) | eight) & 0xF0F0F0F0F0F0F0F0) != 0) return nullptr;
  word->letter_at = static_cast<uint32_t>(at - text);
  word->number_at = word->letter_at + 1;
  word->end = static_cast<uint32_t>(last - text);
  word->number.mantissa = (static_cast<int64_t>(NumberOf(eight)) ^ layout.negative) - layout.negative;
  return last;
}

// The layout of a plain word; an empty one where the word is too long.
WordLayout LayoutOf(const char* text, const Word& word) {
  WordLayout layout;
  const uint32_t size = word.end - word.number_at;
  const auto digits = static_cast<uint32_t>(word.number.digits), decimals = static_cast<uint32_t>(word.number.decimals);
  const bool has_sign = size > digits + word.number.has_point;
  if (std::endian::native == std::endian::big || size - has_sign > 8) return layout;
  const auto highest = [](uint32_t bytes) { return bytes == 0 ? 0 : ~uint64_t{0} << (64 - 8 * bytes); };
  const char* const at = text + word.letter_at;
  layout.size = size + 1;
  layout.head_mask = has_sign ? 0xFFFF : 0xFF;
  std::memcpy(&layout.head, at, sizeof(layout.head));
  layout.head &= layout.head_mask;
  layout.negative = has_sign && at[1] == '-' ? -1 : 0;
  layout.fraction_mask = highest(decimals);
  layout.whole_mask = highest(digits) ^ layout.fraction_mask;
  if (!word.number.has_point) return layout;
  layout.point_shift = 8;
  layout.point_mask = highest(decimals + 1) ^ layout.fraction_mask;
  layout.point = ((kZeros >> 56 ^ '.') * 0x0101010101010101) & layout.point_mask;
  return layout;
}

}  // namespace

bool ReadPlainBlock(const char* text, const char* end, Block* block) {
  const char* at = text;
  int count = 0;
  for (; at < end; ++count) {
    if (count == kMaxWords) return false;
    Word& word = block->words[static_cast<size_t>(count)];
    if (count < block->layout_count) {
      const char* const last = ReadAlikeWord(text, at, end, block->layouts[static_cast<size_t>(count)], &word);
      if (last != nullptr) {
        // Most words are separated by one blank. If no letter follows the blanks, the next word fails to read.
        if (*last == ' ') {
          at = last + 1;
          while (*at == ' ') ++at;
          continue;
        }
        at = last;
        if (at == end || (*at >= 'A' && *at <= 'Z')) continue;
        at -= block->layouts[static_cast<size_t>(count)].size;  // its number goes on
      }
    }
    at = ReadPlainWord(text, at, end, &word);
    if (at == nullptr) return false;
    if (count >= kMaxLayouts) continue;
    block->layouts[static_cast<size_t>(count)] = LayoutOf(text, word);
    block->layout_count = std::max(block->layout_count, count + 1);
  }
  block->word_count = count;
  return at == end;
}

}  // namespace axiscal::nc
