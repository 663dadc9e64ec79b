// How a corrected position becomes a word: the one rule, which all words of a written block follow, those of axes and
// those of arcs (docs/nc.md, "Rules for the bytes").
//   - A word has the decimals that it is written with or the control's resolution, whichever is finer; an inserted word
//     has the resolution. A word that counts least increments has the resolution, and no decimals are added to it.
//     Centres of arcs have more where the control would else refuse the arc (Piece::centre_decimals).
//   - Its number is the whole number of its last decimal (the grain) nearest to target - base, halves away from zero
//     (RoundToGrains); base is what a word of 0 means.
//   - The control stands at base + number x grain then; what follows counts from there, so that rounding never adds up.
//   - A word whose number is the written one keeps its bytes.
#ifndef AXISCAL_CORE_NC_CORRECTED_WORD_H_
#define AXISCAL_CORE_NC_CORRECTED_WORD_H_

#include <algorithm>

#include "core/nc/block.h"
#include "core/nc/options.h"

namespace axiscal::nc {

// What a word can hold.
struct WordForm {
  int decimals = 0;
  Ticks grain = 0;             // of its last decimal
  bool is_increments = false;  // its number counts grains, and is written without a point
};

struct CorrectedWord {
  int64_t number = 0;  // of grains
  WordForm form;
  bool is_negated = false;  // its sign is a sense of rotation: what is written is -number

  // Where the control stands that was told the word.
  Ticks Position(Ticks base) const { return base + number * form.grain; }
};

// The decimals that words have at least.
struct WordRule {
  int decimals_mm = 0, decimals_inch = 0;
  bool has_increments = false;  // words without a point count least increments

  static WordRule Of(const RewriteOptions& options) {
    return {options.decimals_mm, options.decimals_inch, options.integer_words == IntegerWords::kLeastIncrement};
  }

  // Of an inserted word; `ticks_per_unit` is that of its axis.
  WordForm Inserted(Ticks ticks_per_unit) const {
    const int decimals = ticks_per_unit == kTicksPerInch ? decimals_inch : decimals_mm;
    return {decimals, GrainTicks(ticks_per_unit, decimals), false};
  }
  // Of a written word. Angles have the decimals of mm in programs in inch, too.
  WordForm Of(const Word& word, Ticks ticks_per_unit) const {
    const int least = ticks_per_unit == kTicksPerInch ? decimals_inch : decimals_mm;
    if (IsIncrements(word)) return {least, GrainTicks(ticks_per_unit, least), true};
    const int decimals = std::max<int>(least, word.number.decimals);
    return {decimals, GrainTicks(ticks_per_unit, decimals), false};
  }
  bool IsIncrements(const Word& word) const { return has_increments && !word.number.has_point; }
};

// The form with at least so many decimals; increments have theirs.
inline WordForm AtLeast(int decimals, const WordForm& form, Ticks ticks_per_unit) {
  if (form.is_increments || form.decimals >= decimals) return form;
  return {decimals, GrainTicks(ticks_per_unit, decimals), false};
}

// The form with the decimals at which `value` is said exactly; increments have theirs.
inline WordForm ExactForm(WordForm form, Ticks value, Ticks ticks_per_unit) {
  while (!form.is_increments && form.decimals < kMaxDecimals && value % form.grain != 0)
    form.grain = GrainTicks(ticks_per_unit, ++form.decimals);
  return form;
}

inline CorrectedWord WordFor(Ticks target, Ticks base, const WordForm& form) {
  return {RoundToGrains(target - base, form.grain), form};
}

// The position nearest to `target` that a word can say whose 0 means `base`; `target` itself where the grain is 0.
inline Ticks NearestHeld(Ticks target, Ticks base, Ticks grain) {
  return grain == 0 ? target : base + RoundToGrains(target - base, grain) * grain;
}

// Whether an axis that stands at `at` needs no word: it is within half a grain of where it should be.
inline bool IsHeld(Ticks target, Ticks at, Ticks grain) {
  const Ticks apart = target - at;
  return apart <= grain / 2 && apart >= -(grain / 2);
}

// Whether the word says so already.
inline bool IsSaid(const CorrectedWord& corrected, const Word& word) {
  const int says = corrected.form.is_increments ? corrected.form.decimals : word.number.decimals;
  const int64_t number = corrected.is_negated ? -corrected.number : corrected.number;
  return number == word.number.mantissa * kPowersOfTen[corrected.form.decimals - says];
}

// Writes the number and returns its end; may touch kMaxFixedBytes.
inline char* WriteNumber(const CorrectedWord& word, bool plus, char* to) {
  const int decimals = word.form.is_increments ? 0 : word.form.decimals;
  return WriteFixed(word.is_negated ? -word.number : word.number, decimals, plus, !word.form.is_increments, to);
}
template <typename Text>
void AppendNumber(const CorrectedWord& word, bool plus, Text* text) {
  char buffer[kMaxFixedBytes];
  text->append(buffer, static_cast<size_t>(WriteNumber(word, plus, buffer) - buffer));
}

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_CORRECTED_WORD_H_
