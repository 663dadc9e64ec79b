#include "core/nc/preamble.h"

#include <algorithm>

#include "core/nc/lexer.h"
#include "core/nc/line_splitter.h"

namespace axiscal::nc {

// Plain text cannot be read as words, and holds no code, no word of an axis and nothing of macros: "IF[#1EQ0]GOTO5" and
// "G1 X=5" are blocks.
Preamble::Kind Preamble::KindOf(const Dialect& dialect, const char* text, size_t size) {
  if (!dialect.has_parenthesis_comments) return Kind::kProgram;  // their programs do not begin with '%'
  const char* at = text;
  const char* const end = text + TextSize(text, size);
  if (end - at >= 3 && at[0] == '\xEF' && at[1] == '\xBB' && at[2] == '\xBF') at += 3;
  while (at != end && (*at == ' ' || *at == '\t' || *at == '\r' || *at == 0)) ++at;
  if (at == end) return Kind::kNothing;
  if (*at == '%') return Kind::kPercent;
  Block block;
  Lex(at, static_cast<size_t>(end - at), dialect, &block);
  if (block.problem == LexProblem::kNone)
    return block.word_count > 0 || block.has_assignment ? Kind::kProgram : Kind::kNothing;
  const bool acts = std::any_of(block.begin(), block.end(), [&](const Word& word) {
    return word.letter == 0 || word.letter == 'G' || dialect.axis_letters.find(word.letter) != std::string::npos;
  });
  const bool is_macro = std::any_of(at, end, [](char c) { return c == '#' || c == '[' || c == 0; });
  return acts || is_macro || block.has_assignment || block.is_deletable ? Kind::kProgram : Kind::kText;
}

}  // namespace axiscal::nc
