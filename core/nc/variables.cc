#include "core/nc/variables.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/units.h"
#include "core/nc/char_class.h"

namespace axiscal::nc {
namespace {

constexpr int64_t kLastLocal = 33;
constexpr int kMostNestedTerms = 20;
constexpr double kLargest = 1e6;  // of a value that is of use in a word

// Of '#': what Fanuc, Haas and LinuxCNC all leave to programs. Every R of Sinumerik is.
bool IsProgramsOwn(uint64_t number, const Dialect& dialect) {
  if (dialect.variable != '#') return true;
  return (number >= 1 && number <= 33) || (number >= 100 && number <= 199) || (number >= 500 && number <= 549);
}

bool IsPartOfName(char c) { return Class(c) == kUpper || Class(c) == kLower || Class(c) == kDigit || c == '_'; }

// Sums of products, from left to right.
class Parser {
 public:
  Parser(const char* at, const char* end, const Dialect& dialect, const Variables& variables)
      : at_(at), end_(end), dialect_(dialect), variables_(variables) {}

  // Behind what was read, without blanks.
  const char* EndOf(const char* begin) const {
    const char* last = at_;
    while (last != begin && Class(last[-1]) == kBlank) --last;
    return last;
  }
  std::optional<double> Sum(int depth) {
    std::optional<double> sum = Product(depth);
    while (sum) {
      const char* const before = at_;
      const bool is_plus = Take('+');
      if (!is_plus && !Take('-')) break;
      const std::optional<double> next = Product(depth);
      if (!next) return Undo(before);
      *sum += is_plus ? *next : -*next;
    }
    return sum;
  }
  // What may stand behind an address: without brackets a variable alone where '[' encloses expressions.
  std::optional<double> Value() {
    SkipBlanks();
    if (dialect_.has_equals) return Sum(0);
    return Term(0);
  }

 private:
  std::optional<double> Undo(const char* to) {
    at_ = to;
    return std::nullopt;
  }
  void SkipBlanks() {
    while (at_ != end_ && Class(*at_) == kBlank) ++at_;
  }
  bool Take(char c) {
    SkipBlanks();
    if (at_ == end_ || *at_ != c) return false;
    ++at_;
    return true;
  }
  std::optional<double> Product(int depth) {
    std::optional<double> product = Term(depth);
    while (product) {
      const char* const before = at_;
      const bool is_times = Take('*');
      if (is_times && at_ != end_ && *at_ == '*') return Undo(before);  // a power
      if (!is_times && !Take('/')) break;
      const std::optional<double> next = Term(depth);
      if (!next || (!is_times && *next == 0)) return Undo(before);
      *product = is_times ? *product * *next : *product / *next;
    }
    return product;
  }
  std::optional<double> Term(int depth) {
    if (depth > kMostNestedTerms) return std::nullopt;
    SkipBlanks();
    if (at_ == end_) return std::nullopt;
    if (Take('-')) {
      const std::optional<double> value = Term(depth + 1);
      return value ? std::optional<double>(-*value) : std::nullopt;
    }
    if (Take('+')) return Term(depth + 1);
    const char open = dialect_.variable == '#' ? '[' : '(', close = dialect_.variable == '#' ? ']' : ')';
    if (Take(open)) {
      const std::optional<double> value = Sum(depth + 1);
      return value && Take(close) ? value : std::nullopt;
    }
    if (Class(*at_) == kDigit || *at_ == '.') return Number();
    static constexpr const char* kFunctions[] = {"SIN", "COS", "TAN", "SQRT", "ABS"};
    for (const char* const name : kFunctions) {
      const size_t size = std::strlen(name);
      if (static_cast<size_t>(end_ - at_) <= size ||
          !std::equal(name, name + size, at_, [](char a, char b) { return a == Capital(b); }))
        continue;
      const char* const before = at_;
      at_ += size;
      if (!Take(open)) return Undo(before);
      const std::optional<double> value = Sum(depth + 1);
      if (!value || !Take(close)) return Undo(before);
      switch (name[1]) {
        case 'I':
          return std::sin(*value * base::kRadPerDeg);
        case 'O':
          return std::cos(*value * base::kRadPerDeg);
        case 'A':
          return std::tan(*value * base::kRadPerDeg);
        case 'Q':
          return *value < 0 ? std::nullopt : std::optional<double>(std::sqrt(*value));
        default:
          return std::abs(*value);
      }
    }
    std::string name;
    const char* const last = EndOfVariable(at_, end_, dialect_, &name);
    if (last == nullptr) return std::nullopt;
    const std::optional<double> value = variables_.Value(name);
    if (value) at_ = last;
    return value;
  }
  std::optional<double> Number() {
    double value = 0, place = 1;
    bool has_point = false, has_digit = false;
    const char* const begin = at_;
    for (; at_ != end_ && (Class(*at_) == kDigit || (*at_ == '.' && !has_point)); ++at_) {
      if (*at_ == '.') {
        has_point = true;
        continue;
      }
      has_digit = true;
      value = 10 * value + (*at_ - '0');
      if (has_point) place *= 10;
    }
    return has_digit ? std::optional<double>(value / place) : Undo(begin);
  }

  const char* at_;
  const char* const end_;
  const Dialect& dialect_;
  const Variables& variables_;
};

}  // namespace

std::optional<double> Variables::Value(const std::string& name) const {
  const auto found = values_.find(name);
  return found == values_.end() ? std::nullopt : std::optional<double>(found->second);
}

void Variables::Set(const std::string& name, std::optional<double> value) {
  if (value && std::abs(*value) <= kLargest) {
    values_[name] = *value;
  } else {
    values_.erase(name);
  }
}

void Variables::ForgetOfCycles() {
  constexpr size_t kOwnDigits = 2;  // Q0 to Q99 are the program's
  std::erase_if(values_,
                [](const auto& known) { return known.first[0] == 'Q' && known.first.size() > 1 + kOwnDigits; });
}

void Variables::ForgetLocals() {
  for (auto at = values_.begin(); at != values_.end();) {
    const bool is_local =
        at->first[0] == '#' && (at->first[1] == '<' || std::strtoll(at->first.c_str() + 1, nullptr, 10) <= kLastLocal);
    at = is_local ? values_.erase(at) : std::next(at);
  }
}

void Variables::TakeLocals(const Variables& caller) {
  constexpr int64_t kLastArgument = 30;
  for (const auto& [name, value] : caller.values_) {
    const bool is_named = name[0] == '#' && name[1] == '<';
    if (is_named ? name[2] != '_' : std::strtoll(name.c_str() + 1, nullptr, 10) <= kLastArgument) values_[name] = value;
  }
}

const char* EndOfVariable(const char* at, const char* end, const Dialect& dialect, std::string* name) {
  name->clear();
  if (at == end) return nullptr;
  if (*at == '_' && dialect.has_equals) {  // a name of Sinumerik's user variables
    const char* const begin = at;
    while (at != end && IsPartOfName(*at)) ++at;
    name->assign(begin, at);
    for (char& c : *name) c = Capital(c);
    return at;
  }
  if (dialect.variable == 0 || Capital(*at) != dialect.variable) return nullptr;
  name->push_back(dialect.variable);
  ++at;
  if (at != end && *at == '<' && dialect.variable == '#') {
    const char* const close = std::find(at, end, '>');
    if (close == end) return nullptr;
    for (; at != close; ++at) {
      if (*at != ' ') name->push_back(*at >= 'A' && *at <= 'Z' ? static_cast<char>(*at - 'A' + 'a') : *at);
    }
    return close + 1;
  }
  uint64_t number = 0;
  while (at != end && dialect.variable == '#' && Class(*at) == kBlank) ++at;
  const char* const digits = at;
  at = ReadDigits(at, end, &number);
  if (at == digits || at - digits > 9 || !IsProgramsOwn(number, dialect)) return nullptr;
  *name += std::to_string(number);
  return at;
}

std::optional<double> Evaluate(const char** at, const char* end, const Dialect& dialect, const Variables& variables) {
  Parser parser(*at, end, dialect, variables);
  const std::optional<double> value = parser.Value();
  if (!value || std::abs(*value) > kLargest) return std::nullopt;
  *at = parser.EndOf(*at);
  return value;
}

std::optional<double> EvaluateSum(const char** at, const char* end, const Dialect& dialect,
                                  const Variables& variables) {
  Parser parser(*at, end, dialect, variables);
  const std::optional<double> value = parser.Sum(0);
  if (!value || std::abs(*value) > kLargest) return std::nullopt;
  *at = parser.EndOf(*at);
  return value;
}

}  // namespace axiscal::nc
