// Splits one block into words without touching its bytes.
//
// Blanks may stand anywhere, also inside numbers (RS274/NGC 3.3.2). Letters may be small. A block that cannot be read
// as words has a problem set and the words before it; it is for the caller to refuse or pass it.
#ifndef AXISCAL_CORE_NC_LEXER_H_
#define AXISCAL_CORE_NC_LEXER_H_

#include <cstddef>
#include <string>

#include "core/nc/block.h"
#include "core/nc/dialect.h"
#include "core/nc/variables.h"

namespace axiscal::nc {

// `text` is the line without its end ("\n", "\r\n"); text[size] is that end, or the NUL behind a string. Every field of
// `block` is set, words beyond word_count excepted. Never fails.
// `variables`: values of those that words may name; nullptr: none is known.
void Lex(const char* text, size_t size, const Dialect& dialect, Block* block, const Variables* variables = nullptr);

// Whether what follows the ';' at `at` is words and nothing else, a code or a position among them.
bool IsBlockBehind(const char* at, const char* end);

// "nested comment at column 7".
std::string ToString(LexProblem problem, uint32_t at);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_LEXER_H_
