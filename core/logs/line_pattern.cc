#include "core/logs/line_pattern.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <set>

namespace axiscal::logs {
namespace {

bool IsBlank(char c) { return c == ' ' || c == '\t'; }
bool IsDigit(char c) { return c >= '0' && c <= '9'; }

size_t SkipBlanks(std::string_view line, size_t at) {
  while (at < line.size() && IsBlank(line[at])) ++at;
  return at;
}

std::string Trimmed(std::string_view text) {
  while (!text.empty() && IsBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsBlank(text.back())) text.remove_suffix(1);
  return std::string(text);
}

// The place behind `literal`, whose blanks stand for any number of blanks; npos and `*failed` where it differs.
size_t MatchLiteral(std::string_view line, size_t at, const std::string& literal, size_t* failed) {
  at = SkipBlanks(line, at);
  for (const char c : literal) {
    if (IsBlank(c)) {
      at = SkipBlanks(line, at);
      continue;
    }
    if (at >= line.size() || line[at] != c) {
      *failed = at;
      return std::string_view::npos;
    }
    ++at;
  }
  return at;
}

// Where an exponent that begins at `at` ends; `at` where there is none.
size_t ExponentEnd(std::string_view line, size_t at) {
  if (at >= line.size() || (line[at] != 'e' && line[at] != 'E')) return at;
  size_t end = at + 1;
  if (end < line.size() && (line[end] == '-' || line[end] == '+')) ++end;
  if (end >= line.size() || !IsDigit(line[end])) return at;
  while (end < line.size() && IsDigit(line[end])) ++end;
  return end;
}

// [blanks] [sign] [blanks] digits [. digits] [e [sign] digits]; npos where there is none. A decimal comma has digits
// behind it: it may part fields, too.
size_t MatchNumber(std::string_view line, size_t at, const LinePattern& pattern, FieldValue* value, size_t* failed) {
  at = SkipBlanks(line, at);
  std::string digits;
  if (at < line.size() && (line[at] == '-' || line[at] == '+')) {
    if (line[at] == '-') digits = "-";
    at = SkipBlanks(line, at + 1);
  }
  const size_t begin = at;
  size_t point = std::string_view::npos;
  const auto is_point = [&] {
    return line[at] == pattern.decimal && point == std::string_view::npos &&
           (pattern.decimal == '.' || (at + 1 < line.size() && IsDigit(line[at + 1])));
  };
  while (at < line.size() && (IsDigit(line[at]) || is_point())) {
    if (!IsDigit(line[at])) point = at;
    digits += IsDigit(line[at]) ? line[at] : '.';
    ++at;
  }
  const size_t mantissa_end = at;
  if (at > begin && pattern.may_have_exponents) at = ExponentEnd(line, at);
  digits.append(line.substr(mantissa_end, at - mantissa_end));
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value->number);
  if (error != std::errc() || end != digits.data() + digits.size()) {
    *failed = begin == at ? begin : at;
    return std::string_view::npos;
  }
  value->decimals = point == std::string_view::npos ? 0 : static_cast<int>(mantissa_end - point - 1);
  return at;
}

bool IsTag(const std::string& literal) {
  return !literal.empty() &&
         std::all_of(literal.begin(), literal.end(), [](unsigned char c) { return std::isalpha(c) != 0; });
}

bool HasTags(const std::vector<Piece>& pieces) {
  std::set<std::string> tags;
  for (const Piece& piece : pieces) {
    if (piece.field.empty() && piece.literal.empty()) continue;
    if (piece.field.empty() || piece.is_text || !IsTag(piece.literal) || !tags.insert(piece.literal).second)
      return false;
  }
  return !tags.empty();
}

Match Fail(size_t column, const std::string& expected) { return {false, {}, column, expected}; }

std::string NumberOf(const Piece& piece) { return "a number for " + piece.field; }

// What a comma between digits may be.
std::string CommaHint(const LinePattern& pattern, std::string_view line, size_t at) {
  const bool is_comma = pattern.decimal == '.' && at > 0 && at + 1 < line.size() && line[at] == ',' &&
                        IsDigit(line[at - 1]) && IsDigit(line[at + 1]);
  return is_comma ? "; of numbers with a decimal comma the template says 'decimal: ,'" : "";
}

Match MatchTagged(const LinePattern& pattern, std::string_view line) {
  Match match;
  match.fields.resize(pattern.pieces.size());
  std::vector<bool> seen(pattern.pieces.size(), false);
  for (size_t at = SkipBlanks(line, 0); at < line.size(); at = SkipBlanks(line, at)) {
    size_t found = pattern.pieces.size(), length = 0;
    for (size_t i = 0; i < pattern.pieces.size(); ++i) {
      const std::string& tag = pattern.pieces[i].literal;
      if (tag.size() <= length || line.substr(at, tag.size()) != tag) continue;
      found = i;
      length = tag.size();
    }
    if (found == pattern.pieces.size())
      return Fail(at, "a field of '" + pattern.text + "'" + CommaHint(pattern, line, at));
    if (seen[found]) return Fail(at, pattern.pieces[found].literal + " once");
    seen[found] = true;
    size_t failed = 0;
    at = MatchNumber(line, at + length, pattern, &match.fields[found], &failed);
    if (at == std::string_view::npos) return Fail(failed, NumberOf(pattern.pieces[found]));
  }
  for (size_t i = 0; i < pattern.pieces.size(); ++i) {
    if (!seen[i] && !pattern.pieces[i].field.empty())
      return Fail(line.size(), "also " + pattern.pieces[i].literal + " with " + NumberOf(pattern.pieces[i]));
  }
  match.is_match = true;
  return match;
}

// The end of a text: where the next literal begins, or the line's end.
size_t TextEnd(const LinePattern& pattern, size_t piece, std::string_view line, size_t at) {
  if (pattern.pieces[piece].ends_at_blank) {
    for (int word = 0; word < pattern.pieces[piece].words; ++word) {
      at = SkipBlanks(line, at);
      while (at < line.size() && !IsBlank(line[at])) ++at;
    }
    return at;
  }
  if (piece + 1 >= pattern.pieces.size() || pattern.pieces[piece + 1].literal.empty()) return line.size();
  for (; at < line.size(); ++at) {
    size_t failed = 0;
    if (!IsBlank(line[at]) && MatchLiteral(line, at, pattern.pieces[piece + 1].literal, &failed) != std::string::npos)
      return at;
  }
  return line.size();
}

Match MatchInOrder(const LinePattern& pattern, std::string_view line) {
  Match match;
  match.fields.resize(pattern.pieces.size());
  size_t at = 0;
  for (size_t i = 0; i < pattern.pieces.size(); ++i) {
    const Piece& piece = pattern.pieces[i];
    size_t failed = 0;
    at = MatchLiteral(line, at, piece.literal, &failed);
    if (at == std::string_view::npos) return Fail(failed, "'" + piece.literal + "'" + CommaHint(pattern, line, failed));
    if (piece.field.empty()) continue;
    if (piece.is_text) {
      const size_t end = TextEnd(pattern, i, line, at);
      match.fields[i].text = Trimmed(line.substr(at, end - at));
      if (match.fields[i].text.empty() && piece.field != "*")
        return Fail(SkipBlanks(line, at), "a text for " + piece.field);
      at = end;
      continue;
    }
    at = MatchNumber(line, at, pattern, &match.fields[i], &failed);
    if (at == std::string_view::npos) return Fail(failed, NumberOf(piece));
    // Digits that letters or a second point follow are no number.
    if (at < line.size() && i + 1 < pattern.pieces.size() && pattern.pieces[i + 1].literal.empty() &&
        !IsBlank(line[at]))
      return Fail(at, "a blank behind the number for " + piece.field);
  }
  at = SkipBlanks(line, at);
  if (at < line.size()) return Fail(at, "the end of the line" + CommaHint(pattern, line, at));
  match.is_match = true;
  return match;
}

}  // namespace

absl::StatusOr<LinePattern> ParsePattern(const std::string& text) {
  LinePattern pattern;
  pattern.text = text;
  std::set<std::string> names;
  const auto refuse = [&](const std::string& what) {
    return absl::InvalidArgumentError(absl::StrCat("'", text, "': ", what));
  };
  size_t at = 0;
  while (true) {
    const size_t open = text.find('{', at);
    if (text.substr(at, open - at).find('}') != std::string::npos) return refuse("a '}' without '{'");
    if (open == std::string::npos) break;
    const size_t close = text.find('}', open);
    if (close == std::string::npos) return refuse("a '{' without '}'");
    Piece piece;
    piece.literal = Trimmed(text.substr(at, open - at));
    piece.field = text.substr(open + 1, close - open - 1);
    piece.is_text = piece.field == "*" || piece.field == "feature" || piece.field == "run" || piece.field == "rod" ||
                    piece.field == "target";
    if (piece.field.empty()) return refuse("'{}' names no field");
    if (piece.field != "*" && !names.insert(piece.field).second)
      return refuse("field '" + piece.field + "' stands twice, expected once");
    if (!pattern.pieces.empty() && pattern.pieces.back().is_text && piece.literal.empty()) {
      if (open == at) return refuse("nothing tells where '{" + pattern.pieces.back().field + "}' ends");
      pattern.pieces.back().ends_at_blank = true;
    }
    pattern.pieces.push_back(std::move(piece));
    at = close + 1;
  }
  const std::string rest = Trimmed(text.substr(at));
  if (!rest.empty()) pattern.pieces.push_back({rest, "", false});
  pattern.is_any_order = HasTags(pattern.pieces);
  // An E behind a number may be the next tag.
  pattern.may_have_exponents = std::none_of(pattern.pieces.begin(), pattern.pieces.end(), [](const Piece& piece) {
    return piece.literal.starts_with('E') || piece.literal.starts_with('e');
  });
  return pattern;
}

void MakeText(const std::string& field, int words, LinePattern* pattern) {
  for (size_t i = 0; i < pattern->pieces.size(); ++i) {
    Piece& piece = pattern->pieces[i];
    if (piece.field != field) continue;
    piece.is_text = true;
    piece.words = words;
    piece.ends_at_blank = i + 1 < pattern->pieces.size() && pattern->pieces[i + 1].literal.empty();
  }
  pattern->is_any_order = HasTags(pattern->pieces);
}

bool HasField(const LinePattern& pattern, const std::string& field) {
  return std::any_of(pattern.pieces.begin(), pattern.pieces.end(),
                     [&](const Piece& piece) { return piece.field == field; });
}

Match MatchLine(const LinePattern& pattern, std::string_view line) {
  return pattern.is_any_order ? MatchTagged(pattern, line) : MatchInOrder(pattern, line);
}

}  // namespace axiscal::logs
