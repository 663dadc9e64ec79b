// What the codes of a controller family mean, as a table. A dialect is data: the lexer, the interpreter and the
// rewriter only look it up.
#ifndef AXISCAL_CORE_NC_DIALECT_H_
#define AXISCAL_CORE_NC_DIALECT_H_

#include <cstdint>
#include <string>
#include <vector>

namespace axiscal::nc {

// What a G or M code does to the modal state.
enum class Meaning : uint8_t {
  kUnknown,   // not in the table: refused
  kHarmless,  // moves nothing and changes nothing that matters here
  kRapid,
  kLinear,
  kCancelMotion,  // G80: axis words after it have no meaning
  kOtherMotion,   // moves axes in a way that is not corrected, stays in force until another motion code
  kOneShot,       // moves axes or changes positions in this block only
  kDwell,         // X and U of this block are times
  kInch,
  kMillimetre,
  kAbsolute,
  kIncremental,
  kFeedPerMinute,
  kFeedInverseTime,
  kFeedPerTurn,
  kWorkOffset,  // selects an offset: needs to be stated
  kBlockerOn,   // a mode in which axis words are not axis positions; `blocker` names it
  kBlockerOff,
  kToolChange,  // axes may have moved
  kEndOfProgram,
  kSubprogram,  // control leaves this text: calls and jumps
  kEndOfBlock,  // takes effect after the block's move (M00, M05 ...): such a move cannot be split
};

// Modes that keep moves from being corrected. Bits of Modal::blockers.
enum Blocker : uint16_t {
  kCutterCompensation = 1,
  kToolLength = 2,
  kTiltedPlane = 4,
  kShift = 8,
  kScaling = 16,
  kMirror = 32,
  kPolar = 64,
  kModalMacro = 128,
  kCylinder = 256,
  kUnstatedOffset = 512,
};

struct CodeEntry {
  char letter;  // G or M
  int tenths;   // G54.1 is 541
  Meaning meaning;
  uint16_t blocker;  // of kBlockerOn and kBlockerOff
  const char* text;  // what the code does, for refusals
};

inline constexpr int kCodes = 10000;  // up to G999.9

struct CodeMeaning {
  Meaning meaning;
  uint16_t blocker;
  const char* text;
};

struct Dialect {
  std::string name;
  std::vector<CodeMeaning> g_codes, m_codes;  // by tenths, kCodes each
  std::string axis_letters;                   // in the order in which inserted words are written
  bool has_parenthesis_comments;              // ( ... )
  char line_comment;                          // to the end of the line; 0: none
};

const std::vector<Dialect>& Dialects();
// nullptr when there is none of that name.
const Dialect* FindDialect(const std::string& name);
// "cutter compensation is active", of the lowest bit set. `blockers` != 0.
const char* BlockerText(uint16_t blockers);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_DIALECT_H_
