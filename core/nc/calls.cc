#include "core/nc/calls.h"

#include <algorithm>
#include <cstring>

#include "core/nc/char_class.h"
#include "core/nc/lexer.h"
#include "core/nc/line_splitter.h"

namespace axiscal::nc {
namespace {

constexpr size_t kMostNested = 16;             // controls stop between 4 and 20
constexpr int64_t kMostLinesRun = 20'000'000;  // of all subprograms
constexpr int64_t kMostRepeats = 9999;
constexpr int64_t kPackedRepeat = 10'000;  // of P51002: one run

// Of "O1000".
int64_t NumberOf(const std::string& target) { return std::strtoll(target.c_str() + 1, nullptr, 10); }

bool IsDigitAt(const std::string& text, size_t at) { return at < text.size() && text[at] >= '0' && text[at] <= '9'; }
bool IsNameAt(const std::string& text, size_t at) {
  return at < text.size() &&
         (IsDigitAt(text, at) || text[at] == '_' || (Capital(text[at]) >= 'A' && Capital(text[at]) <= 'Z'));
}
bool IsBlankAt(const std::string& text, size_t at) { return at < text.size() && (text[at] == ' ' || text[at] == '\t'); }

std::string Upper(std::string text) {
  for (char& c : text) c = Capital(c);
  return text;
}

// Reads a line from left to right, in any case.
class Cursor {
 public:
  explicit Cursor(const std::string& line) : text_(line.substr(0, TextSize(line.data(), line.size()))) {}
  size_t at() const { return at_; }
  void Skip() {
    while (IsBlankAt(text_, at_)) ++at_;
  }
  bool IsAtEnd() {
    Skip();
    return at_ == text_.size() || text_[at_] == ';' || text_[at_] == '\r';
  }
  bool Take(const std::string& capitals) {
    Skip();
    if (at_ + capitals.size() > text_.size()) return false;
    for (size_t i = 0; i < capitals.size(); ++i) {
      if (Capital(text_[at_ + i]) != capitals[i]) return false;
    }
    at_ += capitals.size();
    return true;
  }
  // The same where no letter or digit follows.
  bool TakeWord(const std::string& capitals) {
    const size_t begin = at_;
    if (Take(capitals) && !IsNameAt(text_, at_)) return true;
    at_ = begin;
    return false;
  }
  bool TakeNumber(int64_t* number) {
    Skip();
    const size_t begin = at_;
    for (*number = 0; IsDigitAt(text_, at_) && *number < 100'000'000; ++at_)
      *number = 10 * *number + (text_[at_] - '0');
    return at_ != begin;
  }
  // Letters, digits and '_', capitals.
  std::string TakeName() {
    Skip();
    const size_t begin = at_;
    while (IsNameAt(text_, at_)) ++at_;
    return Upper(text_.substr(begin, at_ - begin));
  }
  std::string TakeQuoted(char open, char close) {
    Skip();
    if (at_ == text_.size() || text_[at_] != open) return "";
    const size_t end = text_.find(close, at_ + 1);
    if (end == std::string::npos) return "";
    const std::string name = text_.substr(at_ + 1, end - at_ - 1);
    at_ = end + 1;
    return name;
  }
  char Now() const { return at_ < text_.size() ? text_[at_] : char{0}; }
  void Step() { ++at_; }

 private:
  std::string text_;
  size_t at_ = 0;
};

// "N10 O100 SUB", "O<drill> CALL [1]", "O100".
bool ReadOWord(const std::string& line, FlowLine* flow) {
  Cursor cursor(line);
  int64_t number = 0;
  if (cursor.Take("N") && !cursor.TakeNumber(&number)) return false;
  cursor.Skip();
  const size_t code_at = cursor.at();
  if (!cursor.Take("O")) return false;
  flow->code_at = code_at;
  flow->target_at = cursor.at();
  if (cursor.TakeNumber(&number)) {
    flow->target = absl::StrCat("O", number);
  } else {
    const std::string name = cursor.TakeQuoted('<', '>');
    if (name.empty()) return false;
    flow->target = "O<" + name + ">";
    std::transform(flow->target.begin(), flow->target.end(), flow->target.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    flow->target[0] = 'O';
  }
  flow->target_end = cursor.at();
  const auto ends = [&] { return cursor.IsAtEnd() || cursor.Now() == '('; };
  flow->is_alone = true;
  if (cursor.TakeWord("SUB")) {
    flow->kind = FlowLine::Kind::kHead;
    flow->is_alone = ends();
  } else if (cursor.TakeWord("ENDSUB")) {
    flow->kind = FlowLine::Kind::kReturn;
    flow->is_alone = ends();
  } else if (cursor.TakeWord("CALL")) {
    flow->kind = FlowLine::Kind::kCall;
    // [1] [2*[#1+3]]: its arguments.
    while (cursor.Take("[")) {
      for (int depth = 1; cursor.Now() != 0 && depth > 0; cursor.Step())
        depth += cursor.Now() == '[' ? 1 : cursor.Now() == ']' ? -1 : 0;
    }
    flow->is_alone = ends();
    flow->code_end = cursor.at();
  } else if (ends() && flow->target[1] != '<') {
    flow->kind = FlowLine::Kind::kHead;
  } else {
    return false;
  }
  return true;
}

// G54, G90 and the like, which do not look at P and L.
bool StatesMode(const Word& word, const Dialect& dialect) {
  const int64_t value = word.number.decimals == 0 ? word.number.mantissa : -1;
  if (word.letter != 'G' || value < 0 || 10 * value >= kCodes) return false;
  const CodeMeaning& code = dialect.g_codes[static_cast<size_t>(10 * value)];
  return IsPlainMode(code.meaning) || (code.meaning == Meaning::kWorkOffset && code.detail != 1);  // 1: G154 P
}

FlowLine ReadIso(const std::string& line, const Dialect& dialect) {
  FlowLine flow;
  if (dialect.takes_loaded_tool && ReadOWord(line, &flow)) return flow;
  flow = FlowLine();
  Block block;
  Lex(line.data(), TextSize(line.data(), line.size()), dialect, &block);
  if (block.problem != LexProblem::kNone || block.has_assignment) return flow;
  const Word *call = nullptr, *number = nullptr, *repeats = nullptr, *end = nullptr, *other = nullptr, *code = nullptr;
  const Word* head = nullptr;
  for (const Word& word : block) {
    if (word.letter == 'N') continue;
    if (code == nullptr) code = &word;
    flow.code_end = word.end;
    const int64_t value = word.number.decimals == 0 ? word.number.mantissa : -1;
    const bool is_m = word.letter == 'M' && value >= 0 && 10 * value < kCodes;
    const Meaning meaning = is_m ? dialect.m_codes[static_cast<size_t>(10 * value)].meaning : Meaning::kUnknown;
    const bool is_call =
        (is_m && meaning == Meaning::kCall && (value == 98 || value == 97)) || (word.letter == 'G' && value == 65);
    if (is_call) {
      if (call != nullptr) other = &word;
      call = &word;
    } else if (is_m && meaning == Meaning::kEndOfProgram) {
      end = &word;
    } else if (word.letter == 'P' && number == nullptr) {
      number = &word;
    } else if (word.letter == 'L' && repeats == nullptr) {
      repeats = &word;
    } else if (word.letter == 'O') {
      head = &word;
    } else if (call == nullptr && number == nullptr && repeats == nullptr && StatesMode(word, dialect)) {
      flow.has_codes = true;
    } else {
      // Arguments of a macro set its variables.
      const bool may_be_argument = word.letter != 0 && word.letter != 'G' && word.letter != 'M';
      if (other == nullptr || !may_be_argument) other = &word;
      flow.is_section |= !may_be_argument;  // for the moment: a code beside G65
    }
  }
  if (code != nullptr) flow.code_at = code->letter_at;
  const bool has_code = flow.is_section;
  flow.is_section = false;
  if (call != nullptr) {
    flow.kind = FlowLine::Kind::kCall;
    const bool is_macro = call->letter == 'G';
    const bool is_number = number != nullptr && number->number.decimals == 0 && number->number.mantissa > 0;
    flow.is_alone = is_number && end == nullptr && head == nullptr && (other == nullptr || (is_macro && !has_code)) &&
                    (repeats == nullptr || (repeats->number.decimals == 0 && repeats->number.mantissa >= 0));
    flow.is_alone &= !(is_macro && flow.has_codes);
    if (!flow.is_alone) return flow;
    if (flow.has_codes) flow.code_at = call->letter_at;
    flow.target = absl::StrCat(call->number.mantissa == 97 ? "N" : "O", number->number.mantissa);
    flow.target_at = number->number_at, flow.target_end = number->end;
    flow.is_packed = number->number.digits > 4;
    if (repeats != nullptr) {
      flow.repeats = repeats->number.mantissa;
      flow.repeats_at = repeats->letter_at, flow.repeats_end = repeats->end;
    }
  } else if (end != nullptr) {
    const CodeMeaning& meaning = dialect.m_codes[static_cast<size_t>(10 * end->number.mantissa)];
    flow.kind = meaning.detail == 1 ? FlowLine::Kind::kReturn : FlowLine::Kind::kProgramEnd;
    flow.is_alone = other == nullptr && number == nullptr && repeats == nullptr && head == nullptr && !flow.has_codes;
    if (meaning.detail == 1 && (number != nullptr || repeats != nullptr)) flow.kind = FlowLine::Kind::kPlain;
  } else if (head != nullptr) {
    flow.kind = FlowLine::Kind::kHead;
    flow.is_alone = other == nullptr && number == nullptr && repeats == nullptr && code == head && !flow.has_codes;
    flow.target = absl::StrCat("O", head->number.mantissa);
    flow.target_at = head->number_at, flow.target_end = head->end;
  }
  return flow;
}

bool IsKeyword(const std::string& name, const Dialect& dialect) {
  return std::any_of(dialect.keywords.begin(), dialect.keywords.end(), [&](const Keyword& keyword) {
    return name.compare(0, std::strlen(keyword.name), keyword.name) == 0;
  });
}

FlowLine ReadSinumerik(const std::string& line, const Dialect& dialect) {
  FlowLine flow;
  Cursor cursor(line);
  int64_t number = 0;
  if (cursor.Take("%_N_")) {
    std::string name = cursor.TakeName();
    if (name.size() < 5) return flow;
    flow.kind = FlowLine::Kind::kHead;
    flow.is_alone = true;
    flow.target = name.substr(0, name.size() - 4);
    flow.target_at = 4, flow.target_end = 4 + flow.target.size();
    return flow;
  }
  if (cursor.Take("N") && !cursor.TakeNumber(&number)) cursor = Cursor(line);
  cursor.Skip();
  flow.code_at = cursor.at();
  if (cursor.TakeWord("PROC")) {
    cursor.Skip();
    flow.target_at = cursor.at();
    flow.target = cursor.TakeName();
    flow.target_end = cursor.at();
    flow.kind = FlowLine::Kind::kHead;
    cursor.TakeWord("DISPLOF");
    flow.is_alone = cursor.IsAtEnd();  // else parameters, or SAVE, which brings back the modal state
    return flow;
  }
  if (cursor.TakeWord("RET") || cursor.TakeWord("M17")) {
    flow.kind = cursor.IsAtEnd() ? FlowLine::Kind::kReturn : FlowLine::Kind::kPlain;
    flow.is_alone = true;
    if (flow.kind == FlowLine::Kind::kReturn) return flow;
  }
  const auto ends = [&] {
    if (cursor.IsAtEnd()) return true;
    cursor.Skip();
    flow.repeats_at = cursor.at();
    if (!cursor.Take("P")) return false;
    cursor.Take("=");
    if (!cursor.TakeNumber(&flow.repeats)) return false;
    flow.repeats_end = flow.code_end = cursor.at();
    return cursor.IsAtEnd();
  };
  cursor.Skip();
  if (cursor.TakeWord("CALL") || cursor.TakeWord("EXTCALL")) {
    const bool is_enclosed = cursor.Take("(");
    cursor.Skip();
    flow.target_at = cursor.at() + 1;
    flow.target = Upper(cursor.TakeQuoted('"', '"'));
    flow.target_end = flow.target_at + flow.target.size();
    if (is_enclosed) cursor.Take(")");
    flow.code_end = cursor.at();
    flow.kind = FlowLine::Kind::kCall;
    flow.is_alone = !flow.target.empty() && ends();
    for (const char* const end : {".SPF", ".MPF", "_SPF", "_MPF"}) {
      const size_t size = flow.target.size();
      if (size <= 4 || flow.target.compare(size - 4, 4, end) != 0) continue;
      flow.target.resize(size - 4);
      flow.target_end -= 4;
      break;
    }
    return flow;
  }
  flow.target_at = cursor.at();
  const std::string name = cursor.TakeName();
  flow.target_end = flow.code_end = cursor.at();
  const bool is_number =
      name.size() > 1 && name[0] == 'L' && name.find_first_not_of("0123456789", 1) == std::string::npos;
  const bool is_name = name.size() > 1 && !IsDigitAt(name, 0) && !IsDigitAt(name, 1) && !IsKeyword(name, dialect);
  if (is_number || is_name) {
    const bool has_arguments = cursor.Take("(");
    const bool is_empty = has_arguments && cursor.Take(")");
    if (is_empty) flow.code_end = cursor.at();
    flow.is_alone = has_arguments == is_empty && ends();
    flow.target = name;
    flow.kind = flow.is_alone || has_arguments ? FlowLine::Kind::kCall : FlowLine::Kind::kPlain;
    if (flow.kind == FlowLine::Kind::kCall) return flow;
  }
  flow = FlowLine();
  Block block;
  Lex(line.data(), TextSize(line.data(), line.size()), dialect, &block);
  for (const Word& word : block) {
    if (word.letter != 'M' || word.number.decimals != 0 || word.number.mantissa < 0 || word.number.mantissa > 99)
      continue;
    const CodeMeaning& meaning = dialect.m_codes[static_cast<size_t>(10 * word.number.mantissa)];
    if (meaning.meaning != Meaning::kEndOfProgram) continue;
    flow.kind = meaning.detail == 1 ? FlowLine::Kind::kReturn : FlowLine::Kind::kProgramEnd;
  }
  return flow;
}

FlowLine ReadKlartext(const std::string& line, const Dialect& dialect) {
  FlowLine flow;
  Cursor cursor(line);
  int64_t number = 0;
  cursor.TakeNumber(&number);
  cursor.Skip();
  flow.code_at = cursor.at();
  const auto label = [&] {
    cursor.Skip();
    flow.target_at = cursor.at();
    if (cursor.TakeNumber(&number)) {
      flow.target = absl::StrCat("LBL ", number);
    } else {
      const std::string name = cursor.TakeQuoted('"', '"');
      if (!name.empty()) flow.target = "LBL \"" + name + "\"";
    }
    flow.target_end = flow.code_end = cursor.at();
    return !flow.target.empty();
  };
  if (cursor.TakeWord("LBL")) {
    if (!label() || !cursor.IsAtEnd()) return FlowLine();
    flow.is_alone = true;
    flow.kind = flow.target == "LBL 0" ? FlowLine::Kind::kReturn : FlowLine::Kind::kHead;
    return flow;
  }
  if (cursor.TakeWord("CALL")) {
    flow.kind = FlowLine::Kind::kCall;
    if (cursor.TakeWord("LBL")) {
      if (!label()) return flow;
      if (cursor.TakeWord("REP")) {
        int64_t left = 0;
        flow.is_section = cursor.TakeNumber(&flow.repeats);
        if (cursor.Take("/")) cursor.TakeNumber(&left);
        flow.code_end = cursor.at();
        if (!flow.is_section) return flow;
      }
      flow.is_alone = cursor.IsAtEnd();
    } else if (cursor.TakeWord("PGM")) {
      cursor.Skip();
      flow.target_at = cursor.at();
      const std::string name = cursor.TakeName();
      flow.target_end = cursor.at();
      flow.target = "PGM " + name;
      if (cursor.Take(".H") || cursor.Take(".I")) flow.target_end = cursor.at() - 2;
      flow.code_end = cursor.at();
      flow.is_alone = !name.empty() && cursor.IsAtEnd();
    }
    return flow;
  }
  if (cursor.TakeWord("END PGM")) {
    flow.kind = FlowLine::Kind::kProgramEnd;
    flow.is_packed = true;  // of its text alone
    return flow;
  }
  if (cursor.TakeWord("BEGIN PGM")) {
    cursor.Skip();
    flow.kind = FlowLine::Kind::kHead;
    flow.target_at = cursor.at();
    flow.target = "PGM " + cursor.TakeName();
    flow.target_end = cursor.at();
    flow.is_alone = true;
    return flow;
  }
  Block block;
  Lex(line.data(), TextSize(line.data(), line.size()), dialect, &block);
  for (const Word& word : block) {
    if (word.letter != 'M' || word.number.decimals != 0 || word.number.mantissa < 0 || word.number.mantissa > 99)
      continue;
    if (dialect.m_codes[static_cast<size_t>(10 * word.number.mantissa)].meaning == Meaning::kEndOfProgram)
      flow.kind = FlowLine::Kind::kProgramEnd;
  }
  return flow;
}

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
    lines.push_back(text.substr(at, end - at));
    at = end;
  }
  return lines;
}

// The name of a file without folder and ending, in capitals.
std::string StemOf(const std::string& name) {
  const size_t slash = name.find_last_of('/');
  std::string stem = slash == std::string::npos ? name : name.substr(slash + 1);
  return Upper(stem.substr(0, stem.find('.')));
}

bool IsPercent(const std::string& line) {
  const size_t at = line.find_first_not_of(" \t");
  return at != std::string::npos && line[at] == '%';
}

bool IsDeletable(const std::string& line, const Dialect& dialect) {
  size_t at = 0;
  while (IsBlankAt(line, at) || (dialect.has_bare_keywords && IsDigitAt(line, at))) ++at;
  return at < line.size() && line[at] == '/';
}

}  // namespace

FlowLine ReadFlow(const std::string& line, const Dialect& dialect) {
  if (line.size() > kMaxLineBytes) return FlowLine();
  FlowLine flow = dialect.has_poles    ? ReadKlartext(line, dialect)
                  : dialect.has_equals ? ReadSinumerik(line, dialect)
                                       : ReadIso(line, dialect);
  flow.repeats = std::min(flow.repeats, kMostRepeats + 1);
  return flow;
}

Execution::Execution(const Dialect& dialect, const RewriteOptions& options, std::vector<std::string> lines,
                     int64_t first_line)
    : dialect_(dialect), options_(options) {
  AddText("", std::move(lines), first_line);
  for (const Subprogram& subprogram : options.subprograms) AddText(subprogram.name, LinesOf(subprogram.text), 1);
  for (size_t i = 0; i < texts_.size(); ++i) FindBodies(static_cast<int>(i));
  // A label in front of the program's end is run in line, too.
  const std::vector<FlowLine>& program_flow = texts_[0].flow;
  for (Body& body : bodies_) {
    const bool is_label = body.name.compare(0, 4, "LBL ") == 0 || (body.name[0] == 'N' && !dialect_.has_equals);
    const auto head = program_flow.begin() + static_cast<ptrdiff_t>(body.head);
    const bool is_behind_end = body.text != 0 || std::any_of(program_flow.begin(), head, [](const FlowLine& flow) {
                                 return flow.kind == FlowLine::Kind::kProgramEnd;
                               });
    if (is_label && !is_behind_end) body.problem = "the program runs into it: end the program in front of it";
  }
  std::vector<bool> is_called(bodies_.size(), false);
  is_apart_.assign(texts_[0].lines.size(), false);
  const auto set_apart = [this](const Body& body) {
    std::fill(is_apart_.begin() + static_cast<ptrdiff_t>(body.head),
              is_apart_.begin() + static_cast<ptrdiff_t>(body.end), true);
  };
  for (const Body& body : bodies_) {
    // "O100 SUB": read over where no call leads to it.
    if (body.text == 0 && body.must_be_called && body.problem.empty()) set_apart(body);
  }
  for (size_t i = 0; i < texts_.size(); ++i) {
    for (const FlowLine& flow : texts_[i].flow) {
      if (flow.kind != FlowLine::Kind::kCall || flow.is_section) continue;
      std::string problem;
      const int body = Resolve(static_cast<int>(i), flow, &problem);
      if (body < 0) continue;
      is_called[static_cast<size_t>(body)] = true;
      if (bodies_[static_cast<size_t>(body)].text == 0) set_apart(bodies_[static_cast<size_t>(body)]);
    }
  }
  // Two parts of one text that are called, one inside the other, cannot both have a copy of their own.
  for (size_t i = 0; i < bodies_.size(); ++i) {
    for (size_t k = 0; k < i; ++k) {
      Body &a = bodies_[i], &b = bodies_[k];
      if (a.text != b.text || a.end <= b.head || b.end <= a.head || !is_called[i] || !is_called[k]) continue;
      a.problem = b.problem = "it stands inside another subprogram, or holds one";
    }
  }
  Frame program;
  program.end = texts_[0].lines.size();
  program.is_entered = true;
  frames_.push_back(program);
}

void Execution::AddText(std::string name, std::vector<std::string> lines, int64_t first_line) {
  Text text;
  text.name = std::move(name);
  text.first_line = first_line;
  text.flow.reserve(lines.size());
  // Behind the closing '%', or 0x1A, no control reads on.
  bool has_ended = false;
  for (const std::string& line : lines) {
    has_ended |= texts_.empty() && !dialect_.has_equals && (IsPercent(line) || line.find('\x1A') != std::string::npos);
    text.flow.push_back(has_ended ? FlowLine() : ReadFlow(line, dialect_));
    if (!text.flow.back().target.empty()) used_[text.flow.back().target] = true;
  }
  text.lines = std::move(lines);
  texts_.push_back(std::move(text));
}

void Execution::AddBody(int text, const std::string& name, size_t head, size_t begin, size_t end, bool must_be_called) {
  Text& of = texts_[static_cast<size_t>(text)];
  Body body{text, head, begin, end, name, must_be_called, false, false, false, ""};
  if (of.bodies.count(name) != 0) bodies_[static_cast<size_t>(of.bodies[name])].problem = "it stands there twice";
  of.bodies.emplace(name, static_cast<int>(bodies_.size()));
  used_[name] = true;
  bodies_.push_back(body);
}

void Execution::FindBodies(int index) {
  const Text& text = texts_[static_cast<size_t>(index)];
  const size_t count = text.lines.size();
  using Kind = FlowLine::Kind;
  const auto is_percent = [&](size_t line) { return IsPercent(text.lines[line]); };
  if (dialect_.has_poles) {
    for (size_t i = 0; i < count; ++i) {
      if (text.flow[i].kind != Kind::kHead || text.flow[i].target.compare(0, 4, "LBL ") != 0) continue;
      size_t end = i + 1;
      while (end < count && !(text.flow[end].kind == Kind::kReturn)) ++end;
      AddBody(index, text.flow[i].target, i, i + 1, std::min(end + 1, count), false);
      if (end >= count) bodies_.back().problem = "no LBL 0 ends it";
    }
    if (index == 0) return;
    size_t begin = 0, end = count;
    for (size_t i = count; i-- > 0;) {
      if (text.flow[i].kind == Kind::kProgramEnd && text.flow[i].is_packed) end = i;
      if (text.flow[i].kind == Kind::kHead && text.flow[i].target.compare(0, 4, "PGM ") == 0) begin = i;
    }
    AddBody(index, "PGM " + StemOf(text.name), begin, begin + 1, std::min(end + 1, count), false);
    Body& body = bodies_.back();
    if (count == 0 || text.flow[begin].kind != Kind::kHead || end == count)
      body.problem = "its file does not begin with BEGIN PGM and end with END PGM";
    body.is_inch = count > 0 && Upper(text.lines[begin]).find("INCH") != std::string::npos;
    body.states_unit = true;
    return;
  }
  if (dialect_.has_equals) {
    size_t head = 0;
    std::string name = index == 0 ? "" : StemOf(text.name);
    for (size_t i = 0; i <= count; ++i) {
      const bool begins = i < count && text.flow[i].kind == Kind::kHead && text.lines[i].find('%') != std::string::npos;
      if (!begins && i < count) continue;
      if (!name.empty() && i > head) {
        size_t begin = head + (text.flow[head].kind == Kind::kHead);
        std::string problem;
        for (size_t k = head; k < i; ++k) {
          if (text.flow[k].kind != Kind::kHead) continue;
          if (text.lines[k].find('%') != std::string::npos) continue;
          if (!text.flow[k].is_alone) problem = "its PROC block has parameters or SAVE";
          begin = k + 1;
          break;
        }
        AddBody(index, name, head, begin, i, false);
        bodies_.back().problem = problem;
      }
      if (begins) head = i, name = text.flow[i].target;
    }
    return;
  }
  for (size_t i = 0; i < count; ++i) {
    const FlowLine& flow = text.flow[i];
    if (flow.kind != Kind::kHead) continue;
    size_t end = i + 1;
    const bool is_o_word = Upper(text.lines[i]).find("SUB") != std::string::npos && dialect_.takes_loaded_tool;
    if (is_o_word) {
      while (end < count && !(text.flow[end].kind == Kind::kReturn && text.flow[end].target == flow.target)) ++end;
      AddBody(index, flow.target, i, i + 1, std::min(end + 1, count), true);
      if (end >= count) bodies_.back().problem = "no ENDSUB ends it";
    } else {
      while (end < count && text.flow[end].kind != Kind::kHead && !is_percent(end)) ++end;
      AddBody(index, flow.target, i, i + 1, end, false);
    }
    if (!flow.is_alone) bodies_.back().problem = "words stand behind its number";
  }
  const bool has_head = !text.bodies.empty();
  if (index > 0 && !has_head) {
    std::string stem = StemOf(text.name);
    if (!stem.empty() && stem[0] == 'O') stem.erase(0, 1);
    if (stem.empty() || stem.find_first_not_of("0123456789") != std::string::npos) return;
    size_t begin = 0, end = count;
    while (begin < count && is_percent(begin)) ++begin;
    for (size_t i = begin; i < count; ++i) {
      if (is_percent(i)) end = std::min(end, i);
    }
    stem.erase(0, std::min(stem.find_first_not_of('0'), stem.size() - 1));
    AddBody(index, "O" + stem, begin, begin, end, false);
  }
  for (Body& body : bodies_) {
    if (body.text != index) continue;
    const bool returns = std::any_of(
        text.flow.begin() + static_cast<ptrdiff_t>(body.begin), text.flow.begin() + static_cast<ptrdiff_t>(body.end),
        [](const FlowLine& flow) { return flow.kind == Kind::kReturn || flow.kind == Kind::kProgramEnd; });
    if (!returns && body.problem.empty()) body.problem = "it does not end with a return";
  }
  // M97 P500 of Haas: N500 to M99.
  for (size_t i = 0; i < count; ++i) {
    const FlowLine& call = text.flow[i];
    if (call.kind != Kind::kCall || call.target[0] != 'N' ||
        texts_[static_cast<size_t>(index)].bodies.count(call.target) != 0)
      continue;
    for (size_t k = 0; k < count; ++k) {
      int64_t number = -1;
      Cursor cursor(text.lines[k]);
      if (!cursor.Take("N") || !cursor.TakeNumber(&number) || absl::StrCat("N", number) != call.target) continue;
      size_t end = k;
      while (end < count && text.flow[end].kind != Kind::kReturn && text.flow[end].kind != Kind::kHead &&
             !is_percent(end))
        ++end;
      AddBody(index, call.target, k, k, std::min(end + 1, count), false);
    }
  }
}

int Execution::Resolve(int text, const FlowLine& flow, std::string* problem) const {
  if (!flow.is_alone) {
    *problem = "put the call alone in its block, with plain numbers";
    return -1;
  }
  const auto find = [&](const Text& of, const std::string& name) {
    const auto found = of.bodies.find(name);
    return found == of.bodies.end() ? -1 : found->second;
  };
  const auto find_anywhere = [&](const std::string& name) {
    int found = find(texts_[static_cast<size_t>(text)], name);
    const bool is_local = name[0] == 'N' && !dialect_.has_equals;
    for (size_t i = 0; found < 0 && !is_local && name.compare(0, 4, "LBL ") != 0 && i < texts_.size(); ++i)
      found = find(texts_[i], name);
    return found;
  };
  int found = find_anywhere(flow.target);
  // P51002: O1002 five times, where no program has the whole number.
  if (found < 0 && flow.is_packed && dialect_.packs_repeats && flow.repeats_at == flow.repeats_end)
    found = find_anywhere(absl::StrCat("O", NumberOf(flow.target) % kPackedRepeat));
  if (found < 0 || !bodies_[static_cast<size_t>(found)].problem.empty()) {
    *problem = found < 0
                   ? absl::StrCat(flow.target, " stands neither behind it in this text nor in a file of --subprograms")
                   : absl::StrCat(flow.target, ": ", bodies_[static_cast<size_t>(found)].problem);
    return -1;
  }
  return found;
}

bool Execution::IsKnown(const std::string& name) const {
  return std::any_of(bodies_.begin(), bodies_.end(), [&](const Body& body) { return body.name == name; });
}

bool Execution::Next(Event* event) {
  using Kind = FlowLine::Kind;
  *event = Event();
  if (frames_.empty()) return false;
  Frame& frame = frames_.back();
  const bool is_program = frame.body < 0;
  event->text = frame.text;
  event->body = frame.body;
  if (!frame.is_entered) {
    frame.is_entered = true;
    event->kind = Event::Kind::kEnter;
    return true;
  }
  if (frame.line == frame.end || frame.has_returned) {
    if (is_program) {
      frames_.clear();
      return false;
    }
    event->kind = Event::Kind::kLeave;
    event->line = frame.line - 1;
    const bool may_run_out = dialect_.has_equals || frame.is_section;
    if (!frame.has_returned && !may_run_out) event->problem = "the subprogram does not end with a return";
    if (frame.runs_left > 0) {
      --frame.runs_left;
      frame.line = bodies_[static_cast<size_t>(frame.body)].begin;
      frame.is_entered = frame.has_returned = false;
    } else {
      frames_.pop_back();
    }
    return true;
  }
  const size_t line = frame.line++;
  event->line = line;
  const Text& text = texts_[static_cast<size_t>(frame.text)];
  const FlowLine& flow = text.flow[line];
  if (!is_program && ++lines_run_ > kMostLinesRun) {
    event->kind = Event::Kind::kApart;
    event->problem = absl::StrCat("its subprograms run more than ", kMostLinesRun, " blocks");
    frames_.clear();
    return true;
  }
  if (is_program && is_apart_[line]) {
    event->kind = Event::Kind::kApart;
    return true;
  }
  // Nothing runs behind the end of a Klartext program but what is called.
  if (is_program && has_ended_ && dialect_.has_poles) {
    event->kind = Event::Kind::kApart;
    return true;
  }
  const bool is_deletable = flow.kind != Kind::kPlain && IsDeletable(text.lines[line], dialect_);
  if (is_deletable && options_.block_delete != BlockDelete::kExecuted) {
    if (options_.block_delete == BlockDelete::kEither)
      event->call_problem = "in a block that may be skipped: state --block-delete";
    return true;
  }
  switch (flow.kind) {
    case Kind::kPlain:
      return true;
    case Kind::kHead:
      if (is_program) has_ended_ = false;
      // LBL of a section; the head of a text.
      if (dialect_.has_poles && flow.target.compare(0, 4, "LBL ") == 0) event->kind = Event::Kind::kApart;
      if (!is_program) event->kind = Event::Kind::kApart;
      return true;
    case Kind::kReturn:
      if (is_program) {
        has_ended_ = true;
        if (flow.target == "LBL 0") event->kind = Event::Kind::kApart, has_ended_ = false;
        return true;
      }
      if (frame.is_section) return true;
      frame.has_returned = true;
      if (flow.is_alone) {
        event->kind = Event::Kind::kApart;
      } else {
        event->is_followed_return = true;
      }
      return true;
    case Kind::kProgramEnd:
      if (is_program) {
        has_ended_ = true;
        return true;
      }
      if (flow.is_packed && dialect_.has_poles) {  // END PGM of the program that was called
        frame.has_returned = true;
        event->kind = Event::Kind::kApart;
        return true;
      }
      event->problem = "the end of the program in a subprogram: controls differ on where they go on";
      frames_.resize(1);
      has_ended_ = true;
      return true;
    case Kind::kCall:
      break;
  }
  int64_t repeats = flow.repeats;
  std::string problem;
  int body = -1;
  if (flow.is_section) {
    body = SectionOf(frame.text, line, flow, &problem);
  } else {
    body = Resolve(frame.text, flow, &problem);
    if (body >= 0 && bodies_[static_cast<size_t>(body)].name != flow.target) {
      repeats = NumberOf(flow.target) / kPackedRepeat;
      event->is_packed = true;
    }
  }
  if (body >= 0 && frames_.size() >= kMostNested) problem = absl::StrCat("calls nest deeper than ", kMostNested);
  if (body >= 0 && problem.empty() && (repeats < 1 || repeats > kMostRepeats))
    problem = "its number of repeats is not followed";
  if (!problem.empty()) {
    // M97 P500 of Haas, with N500 in front of it.
    const bool leads_back = std::any_of(bodies_.begin(), bodies_.end(), [&](const Body& of) {
      return of.name == flow.target && of.name[0] == 'N' && !dialect_.has_equals && of.text == frame.text &&
             of.head <= line;
    });
    if (leads_back && options_.on_unsupported == OnUnsupported::kPass)
      event->problem = "it leads back to blocks that may be corrected, and these hold for their order only";
    // A name that is no subprogram may be a word of the control.
    const bool is_name =
        dialect_.has_equals && !(flow.target.size() > 1 && flow.target[0] == 'L' && IsDigitAt(flow.target, 1));
    if (!is_name || IsKnown(flow.target)) event->call_problem = problem;
    return true;
  }
  event->kind = flow.has_codes ? Event::Kind::kLine : Event::Kind::kApart;
  event->is_call = true;
  const Body& called = bodies_[static_cast<size_t>(body)];
  Frame next;
  next.text = called.text;
  next.line = called.begin;
  next.end = called.end;
  next.body = body;
  next.runs_left = repeats - 1;
  next.is_section = flow.is_section;
  frames_.push_back(next);
  return true;
}

int Execution::SectionOf(int text, size_t call, const FlowLine& flow, std::string* problem) {
  const std::vector<FlowLine>& lines = texts_[static_cast<size_t>(text)].flow;
  size_t head = call;
  while (head > 0 && !(lines[head - 1].kind == FlowLine::Kind::kHead && lines[head - 1].target == flow.target)) --head;
  const auto between = [&](FlowLine::Kind kind) {
    return std::any_of(lines.begin() + static_cast<ptrdiff_t>(head), lines.begin() + static_cast<ptrdiff_t>(call),
                       [kind](const FlowLine& line) { return line.kind == kind; });
  };
  if (!flow.is_alone || head == 0) {
    *problem = absl::StrCat(flow.target, " does not stand in front of it in the same text");
  } else if (between(FlowLine::Kind::kReturn) || between(FlowLine::Kind::kProgramEnd)) {
    *problem = absl::StrCat("the part from ", flow.target, " on holds the end of a subprogram or program");
  }
  if (!problem->empty()) return -1;
  const std::string name = absl::StrCat(flow.target, " REP in line ", line_number(text, call));
  Text& of = texts_[static_cast<size_t>(text)];
  if (const auto known = of.bodies.find(name); known != of.bodies.end()) return known->second;
  AddBody(text, name, head - 1, head, call, false);
  bodies_.back().is_section = true;
  return static_cast<int>(bodies_.size()) - 1;
}

std::string Execution::FreeName(const std::string& name) {
  std::string free;
  const size_t digits = name.find_last_not_of("0123456789") + 1;
  const bool is_number = digits < name.size() && (digits == 1 || name.compare(0, digits, "LBL ") == 0);
  constexpr int64_t kLastOwn = 7999;  // from 8000 on controls may protect programs
  int64_t number = is_number ? std::strtoll(name.c_str() + digits, nullptr, 10) : 1;
  do {
    ++number;
    if (is_number && number > kLastOwn && name[0] == 'O') number = 1;
    if (is_number) {
      free = absl::StrCat(name.substr(0, digits), number);
    } else if (name.back() == '>' || name.back() == '"') {
      free = absl::StrCat(name.substr(0, name.size() - 1), "_", number, name.substr(name.size() - 1));
    } else {
      free = absl::StrCat(name, "_", number);
    }
  } while (used_.count(free) != 0);
  used_[free] = true;
  return free;
}

}  // namespace axiscal::nc
