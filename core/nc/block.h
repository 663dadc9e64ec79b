// One block (line) of a program as words. Offsets count bytes from the block's begin; the bytes themselves stay with
// the caller.
#ifndef AXISCAL_CORE_NC_BLOCK_H_
#define AXISCAL_CORE_NC_BLOCK_H_

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/nc/decimal.h"

namespace axiscal::nc {

// What a word's number counts from, where the word says it itself.
enum class Distance : uint8_t {
  kModal,        // as G90 or G91 says
  kAbsolute,     // X=AC(5)
  kIncremental,  // X=IC(5), IX+5 of Klartext
  kShortestWay,  // C=DC(5): absolute; of a rotary axis that counts from 0 to 360 deg
  kUpwards,      // C=ACP(5): the same in the positive sense
  kDownwards,    // C=ACN(5)
};

struct Word {
  char letter = 0;  // capital; 0: a keyword
  bool is_lower = false;
  Distance distance = Distance::kModal;
  bool says_inch = false, says_mm = false;  // of a keyword that takes the rest: BEGIN PGM PART INCH
  int16_t keyword = 0;     // index into Dialect::keywords
  uint32_t letter_at = 0;
  uint32_t number_at = 0;  // sign included
  uint32_t end = 0;
  Decimal number;
};

// Why a block cannot be read as words. kNone: it was.
enum class LexProblem : uint8_t {
  kNone,
  kNestedComment,  // ended at the first or at the last ')': controllers differ
  kUnclosedComment,
  kNoNumber,       // a letter without a number: text, unknown keywords, empty words
  kNumberTooLong,  // more than 18 digits
  kTooManyWords,
  kExpression,  // # [ ] = , macro arithmetic
  kStrayCharacter,
  kSemicolon,    // ';' ends a block on some controllers, and what follows is another
  kSlashInside,  // '/' that does not begin the block
};

inline constexpr int kMaxWords = 64;

// How a plain word (plain_words.h) of at most eight characters behind its sign was written: where its letter, its sign
// and its point stand. The word at the same place in the next line usually has the same layout.
struct WordLayout {
  uint32_t size = 0;                           // letter, sign and number
  uint16_t head = 1, head_mask = 0;            // letter, and the sign if there is one; these are no word's
  int64_t negative = 0;                        // -1: the sign is '-'
  uint64_t point = 0, point_mask = 0;          // of the number's eight last characters, the last one highest
  uint32_t point_shift = 0;                    // 8: there is a point
  uint64_t whole_mask = 0, fraction_mask = 0;  // of the digits, the point taken out
};
inline constexpr int kMaxLayouts = 16;

struct Block {
  std::array<Word, kMaxWords> words;
  // Of the first words, as the lexer left them; for its next line.
  std::array<WordLayout, kMaxLayouts> layouts;
  int layout_count = 0;
  int word_count = 0;
  bool is_deletable = false;    // begins with '/'
  bool has_assignment = false;  // #100=5 and no other use of it: moves nothing
  bool is_marked = false;       // a comment carries our mark
  bool has_expression = false;  // a word's number is the value of variables
  // Variables that the block sets, by name, with their values; none: not known.
  std::vector<std::pair<std::string, std::optional<double>>> assigned;
  LexProblem problem = LexProblem::kNone;
  uint32_t problem_at = 0;
  // Of a block with TOOL CALL: what stands behind DL; digits = 0: nothing.
  Decimal length_difference;
  // The same of DR; `has_odd_radius`: what stands there is no number.
  Decimal radius_difference;
  bool has_odd_radius = false;

  const Word* begin() const { return words.data(); }
  const Word* end() const { return words.data() + word_count; }
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_BLOCK_H_
