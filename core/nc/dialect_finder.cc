#include "core/nc/dialect_finder.h"

#include <algorithm>
#include <cstdint>
#include <map>

#include "absl/strings/str_cat.h"
#include "core/base/demand.h"
#include "core/nc/char_class.h"
#include "core/nc/dialect.h"
#include "core/nc/job_report.h"
#include "core/nc/lexer.h"

namespace axiscal::nc {
namespace {

using Mask = uint32_t;

bool BeginsWith(std::string_view text, std::string_view capitals) {
  return text.size() >= capitals.size() &&
         std::equal(capitals.begin(), capitals.end(), text.begin(), [](char a, char b) { return a == Capital(b); });
}

// "0 BEGIN PGM A MM", "7 L X+10 R0 FMAX", "8 TOOL CALL 5 Z", with or without the block's number.
bool IsKlartext(std::string_view line) {
  while (!line.empty() && line.front() >= '0' && line.front() <= '9') line.remove_prefix(1);
  line = WithoutBlanks(line);
  for (const char* const begin : {"BEGIN PGM ", "END PGM ", "TOOL CALL ", "TOOL DEF ", "CYCL DEF ", "CYCL CALL",
                                  "CALL LBL ", "BLK FORM ", "PLANE SPATIAL ", "FUNCTION TCPM"}) {
    if (BeginsWith(line, begin)) return true;
  }
  if (!BeginsWith(line, "L ") && !BeginsWith(line, "LN ")) return false;
  line = WithoutBlanks(line.substr(2));
  if (!line.empty() && Capital(line.front()) == 'I') line.remove_prefix(1);
  return line.size() > 1 && std::string_view("XYZABCUVW").find(Capital(line.front())) != std::string_view::npos &&
         (line[1] == '+' || line[1] == '-');
}

// A sign of a macro or a named variable; one in a comment is none.
bool HasSign(std::string_view line, std::string_view sign) {
  int depth = 0;
  for (size_t at = 0; at < line.size(); ++at) {
    if (line[at] == ';') return false;
    depth += line[at] == '(' ? 1 : line[at] == ')' && depth > 0 ? -1 : 0;
    if (depth == 0 && line.substr(at, sign.size()) == sign) return true;
  }
  return false;
}

// "o<drill> call [5]", "O100 sub".
bool IsNamedStructure(std::string_view line) {
  line = WithoutBlanks(line);
  if (line.size() < 2 || Capital(line.front()) != 'O') return false;
  line.remove_prefix(1);
  const size_t end = line.front() == '<' ? line.find('>') + 1 : line.find_first_not_of("0123456789");
  if (end == 0 || end == std::string_view::npos) return false;
  const std::string_view rest = WithoutBlanks(line.substr(end));
  for (const char* const word : {"SUB", "ENDSUB", "CALL", "IF", "WHILE", "DO", "REPEAT", "RETURN"}) {
    const size_t size = std::string_view(word).size();
    const bool is_whole =
        rest.size() == size || (rest.size() > size && !(Capital(rest[size]) >= 'A' && Capital(rest[size]) <= 'Z'));
    if (BeginsWith(rest, word) && is_whole) return true;
  }
  return false;
}

bool IsIso(const Dialect& dialect) { return !dialect.has_equals; }

// Not read as words, or with a G code that the dialect does not know. M codes that it does not know are the machine
// builder's, on any control.
bool IsMisread(std::string_view line, const Dialect& dialect, Block* block) {
  // O words with names, or with what they do behind them, are LinuxCNC's own.
  if (IsNamedStructure(line)) return dialect.name != "linuxcnc";
  const bool has_hash = HasSign(line, "#");
  if (HasSign(line, "#<") && dialect.name != "linuxcnc") return true;
  if (!IsIso(dialect) && has_hash) return true;
  Lex(line.data(), line.size(), dialect, block);
  for (const Word& word : *block) {
    if (word.letter == 'O' && !IsIso(dialect)) return true;
    if (word.letter != 'G' || dialect.roles['G' - 'A'] != Role::kCode) continue;
    int64_t tenths = word.number.mantissa;
    for (int i = word.number.decimals; i < 1; ++i) tenths *= 10;
    for (int i = word.number.decimals; i > 1 && tenths % 10 == 0; --i) tenths /= 10;
    if (tenths < 0 || tenths >= kCodes || dialect.g_codes[static_cast<size_t>(tenths)].meaning == Meaning::kUnknown)
      return true;
  }
  if (block->problem == LexProblem::kNone) return false;
  // Macros are known as such where they begin with the control's own sign.
  const bool is_macro =
      IsIso(dialect) ? has_hash || line.find('[') != std::string_view::npos : line.find('=') != std::string_view::npos;
  return block->problem != LexProblem::kExpression || !is_macro;
}

// What no lexer sees: heads of archives and tapes. Dialects that do not know it.
Mask MisreadHead(std::string_view line, const std::vector<const Dialect*>& dialects) {
  Mask mask = 0;
  for (size_t i = 0; i < dialects.size(); ++i) {
    const bool is_archive = BeginsWith(line, "%_N_") || BeginsWith(line, ";$PATH");
    if (is_archive && IsIso(*dialects[i])) mask |= Mask{1} << i;
  }
  return mask;
}

class Finder {
 public:
  Finder() {
    for (const Dialect& dialect : Dialects()) {
      if (dialect.name != "heidenhain" && dialect.name != "mazak") dialects_.push_back(&dialect);
    }
  }

  void Take(std::string_view line, int64_t number) {
    // What stands in front of the first % is no program but a listing, whatever its words are.
    if (!line.empty() && line.front() == '%' && !has_begun_) {
      has_begun_ = true;
      klartext_.clear();
      misread_.clear();
    }
    if (!klartext_.empty()) return;
    if (IsKlartext(line)) klartext_ = At(line, number);
    Mask mask = MisreadHead(line, dialects_);
    const bool is_head = !line.empty() && (line.front() == '%' || BeginsWith(line, ";$PATH"));
    for (size_t i = 0; !is_head && i < dialects_.size(); ++i)
      mask |= IsMisread(line, *dialects_[i], &block_) ? Mask{1} << i : Mask{0};
    if (mask != 0) misread_.try_emplace(mask, At(line, number));
  }

  FittingDialects Found() const {
    if (!klartext_.empty()) return {{"heidenhain"}, klartext_};
    FittingDialects found;
    for (size_t i = 0; i < dialects_.size(); ++i) {
      std::string against;
      for (size_t other = 0; other < dialects_.size() && against.empty(); ++other) against = Evidence(other, i);
      if (against.empty()) {
        found.names.push_back(dialects_[i]->name);
      } else if (found.evidence.empty()) {
        found.evidence = against;
      }
    }
    DEMAND(!found.names.empty());  // the dialect that misreads the fewest kinds of blocks is never left out
    return found;
  }

 private:
  static std::string At(std::string_view line, int64_t number) {
    const std::string text(WithoutBlanks(line));
    const BlockText block = {text.data(), text.size(), text.size(), number};
    return absl::StrCat("line ", number, ": '", Shown(block), "'");
  }

  // A block that `by` reads and `out` does not, where `out` reads none that `by` does not; else "".
  std::string Evidence(size_t by, size_t out) const {
    std::string block;
    for (const auto& [mask, where] : misread_) {
      const bool is_by = mask >> by & 1, is_out = mask >> out & 1;
      if (is_by && !is_out) return "";
      if (is_out && !is_by && block.empty()) block = where;
    }
    return block;
  }

  std::vector<const Dialect*> dialects_;
  std::map<Mask, std::string> misread_;  // by which of them, and the first such block
  std::string klartext_;
  bool has_begun_ = false;  // a line with % has come
  Block block_;
};

}  // namespace

FittingDialects FindDialects(std::string_view program) {
  Finder finder;
  // Lex reads the byte behind a line.
  const std::string text(program);
  int64_t number = 0;
  if (text.compare(0, 3, "\xEF\xBB\xBF") == 0) program.remove_prefix(3);
  for (size_t at = text.size() - program.size(); at < text.size();) {
    const size_t end = std::min(text.find('\n', at), text.size());
    size_t size = end - at;
    if (size > 0 && text[at + size - 1] == '\r') --size;
    finder.Take(std::string_view(text).substr(at, size), ++number);
    at = end + 1;
  }
  return finder.Found();
}

}  // namespace axiscal::nc
