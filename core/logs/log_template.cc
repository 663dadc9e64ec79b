#include "core/logs/log_template.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "core/session/header_rules.h"
#include "core/session/line_reader.h"
#include "core/session/text.h"

namespace axiscal::logs {
namespace {

std::string Trimmed(const std::string& text) {
  const size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(" \t") + 1 - begin);
}

absl::StatusOr<KnownFormat> FormatOf(const std::string& name) {
  if (name == "dprnt") return KnownFormat::kDprnt;
  if (name == "linuxcnc-probe") return KnownFormat::kLinuxCncProbe;
  if (name == "sinumerik-write") return KnownFormat::kSinumerikWrite;
  return absl::InvalidArgumentError(session::Quoted(name) + ", expected dprnt, linuxcnc-probe or sinumerik-write");
}

// What the programs of Yao 2022 and of core/plan print beside touches, and the head of a Sinumerik file.
absl::Status AddUsualLines(LogTemplate* out) {
  if (out->format == KnownFormat::kSinumerikWrite) {
    for (const char* const head : {"%_N_{*}", ";$PATH={*}"}) {
      ASSIGN_OR_RETURN(LinePattern pattern, ParsePattern(head));
      out->skip.push_back(std::move(pattern));
    }
  } else if (out->format != KnownFormat::kDprnt) {
    return absl::OkStatus();
  }
  if (!out->count) {
    ASSIGN_OR_RETURN(out->count, ParsePattern("Number of Points {count}"));
  }
  if (out->mark) return absl::OkStatus();
  ASSIGN_OR_RETURN(LinePattern model, ParsePattern("Feature Model {*}"));
  out->skip.push_back(std::move(model));
  return absl::OkStatus();
}

// "X 25.4 -390" : axis or column, scale, offset.
absl::Status ReadScale(const std::string& value, LogTemplate* out) {
  const size_t blank = value.find(' ');
  std::vector<double> numbers;
  if (blank == std::string::npos || !session::ParseNumbers(value.substr(blank), &numbers) || numbers.size() != 2 ||
      numbers[0] == 0.0 || std::abs(numbers[0]) > 1e4 || std::abs(numbers[1]) > 1e6) {
    return absl::InvalidArgumentError(session::Quoted(value) +
                                      ", expected an axis or a column, a scale other than 0 and an offset: 'X 25.4 0'");
  }
  if (!out->scales.emplace(value.substr(0, blank), ColumnScale{numbers[0], numbers[1]}).second)
    return absl::InvalidArgumentError(session::Quoted(value) + ": " + value.substr(0, blank) + " is scaled twice");
  return absl::OkStatus();
}

absl::Status ReadApproach(const std::string& value, LogTemplate* out) {
  if (value == "feature") {
    out->approach_is_feature = true;
    return absl::OkStatus();
  }
  std::vector<double> n;
  constexpr double kUnit = 1e-3;
  if (!session::ParseNumbers(value, &n) || n.size() != 3 ||
      std::abs(std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) - 1.0) > kUnit) {
    return absl::InvalidArgumentError(session::Quoted(value) +
                                      ", expected 'feature' or a unit vector 'nx ny nz' in machine axes");
  }
  out->approach = {n[0], n[1], n[2]};
  return absl::OkStatus();
}

absl::Status ReadPattern(const std::string& value, const std::string& field, std::optional<LinePattern>* out) {
  ASSIGN_OR_RETURN(*out, ParsePattern(value));
  if (field.empty() || HasField(**out, field)) return absl::OkStatus();
  return absl::InvalidArgumentError(session::Quoted(value) + ", expected a field {" + field + "}");
}

// What follows is of a feature, or of a rod.
absl::Status ReadMark(const std::string& value, std::optional<LinePattern>* out) {
  ASSIGN_OR_RETURN(*out, ParsePattern(value));
  if (HasField(**out, "feature") || HasField(**out, "rod")) return absl::OkStatus();
  return absl::InvalidArgumentError(session::Quoted(value) + ", expected a field {feature} or {rod}");
}

absl::Status ReadRule(const std::string& rule, const std::string& value, LogTemplate* out) {
  if (rule == "format") {
    ASSIGN_OR_RETURN(out->format, FormatOf(value));
    return absl::OkStatus();
  }
  if (rule == "line") return ReadPattern(value, "", &out->line);
  if (rule == "count") return ReadPattern(value, "count", &out->count);
  if (rule == "mark") return ReadMark(value, &out->mark);
  if (rule == "skip") {
    constexpr size_t kMostSkips = 100;  // each is tried on every line
    if (out->skip.size() >= kMostSkips)
      return absl::InvalidArgumentError(absl::StrCat("is one more than the ", kMostSkips, " that a template may have"));
    ASSIGN_OR_RETURN(LinePattern pattern, ParsePattern(value));
    out->skip.push_back(std::move(pattern));
    return absl::OkStatus();
  }
  if (rule == "axis") return ReadScale(value, out);
  if (rule == "approach") return ReadApproach(value, out);
  if (rule == "decimal") {
    if (value != "." && value != ",") return absl::InvalidArgumentError(session::Quoted(value) + ", expected . or ,");
    out->decimal = value[0];
    return absl::OkStatus();
  }
  if (rule == "time") {
    if (value.find('%') == std::string::npos)
      return absl::InvalidArgumentError(session::Quoted(value) + ", expected a form such as %d.%m.%Y %H:%M:%S");
    out->time = value;
    return absl::OkStatus();
  }
  if (rule == "feature") {
    out->feature = value;
    return value.empty() ? absl::InvalidArgumentError("'', expected a feature's name") : absl::OkStatus();
  }
  if (rule == "seconds") {
    std::vector<double> n;
    if (!session::ParseNumbers(value, &n) || n.size() != 1 || !(n[0] > 0.0 && n[0] <= 1e5))
      return absl::InvalidArgumentError(session::Quoted(value) + ", expected seconds above 0 to 1e5");
    out->seconds = n[0];
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      "is no rule, expected format, line, skip, count, mark, axis, decimal, time, feature, approach or seconds");
}

absl::Status CheckWhole(const LogTemplate& out) {
  if (out.line.has_value() == (out.format != KnownFormat::kNone))
    return absl::InvalidArgumentError("expected either 'line: ...' or 'format: ...', the form of a reading's line");
  if (out.line && std::none_of(out.line->pieces.begin(), out.line->pieces.end(),
                               [](const Piece& piece) { return !piece.field.empty() && piece.field != "*"; }))
    return absl::InvalidArgumentError("line: '" + out.line->text + "' has no field, expected such as X{X_mm}");
  if (!out.time.empty() && (!out.line || !HasField(*out.line, "t_s")))
    return absl::InvalidArgumentError("time: expected a field {t_s} in 'line: ...', which it is the form of");
  return absl::OkStatus();
}

// What rules say of all lines, whichever stands first.
void Finish(LogTemplate* out) {
  const auto words = 1 + static_cast<int>(std::count(out->time.begin(), out->time.end(), ' '));
  if (!out->time.empty()) MakeText("t_s", words, &*out->line);
  for (std::optional<LinePattern>* const pattern : {&out->line, &out->count, &out->mark})
    if (*pattern) (*pattern)->decimal = out->decimal;
  for (LinePattern& skip : out->skip) skip.decimal = out->decimal;
}

}  // namespace

const std::vector<std::string>& KnownFormats() {
  static const auto& names = *new std::vector<std::string>{"dprnt", "linuxcnc-probe", "sinumerik-write"};
  return names;
}

absl::StatusOr<LogTemplate> FindFormat(const std::string& name) {
  LogTemplate out;
  out.name = name;
  ASSIGN_OR_RETURN(out.format, FormatOf(name));
  RETURN_IF_ERROR(AddUsualLines(&out));
  return out;
}

absl::StatusOr<LogTemplate> ReadTemplate(const std::string& text, const std::string& name) {
  const std::vector<std::string>& known = KnownFormats();
  if (std::find(known.begin(), known.end(), text) != known.end()) return FindFormat(text);
  return ParseTemplate(text, name);
}

absl::StatusOr<LogTemplate> ParseTemplate(const std::string& text, const std::string& name) {
  LogTemplate out;
  out.name = name;
  std::istringstream in(text);
  session::LineReader reader(in);
  session::Line line;
  std::set<std::string> said;
  while (true) {
    auto more = reader.Next(&line);
    if (!more.ok()) return base::Within(name, more.status());
    if (!*more) break;
    const std::string content = Trimmed(std::string(line.text));
    if (content.empty() || content[0] == ';') continue;
    const std::string place = absl::StrCat(name, ": line ", line.number);
    const bool is_header = content[0] == '#';
    const std::string body = is_header ? content.substr(1) : content;
    const size_t colon = body.find(':');
    if (colon == std::string::npos)
      return absl::InvalidArgumentError(
          absl::StrCat(place, ": ", session::Quoted(content), ", expected '# key: value' or 'rule: value'"));
    const std::string key = Trimmed(body.substr(0, colon)), value = Trimmed(body.substr(colon + 1));
    if (is_header) {
      // So that header entry i stands in line i + 1, as messages say.
      if (line.number != out.header.size() + 1) {
        return absl::InvalidArgumentError(
            absl::StrCat(place, ": header lines '# ", key, ": ...' stand first, before any rule or blank line"));
      }
      out.header.push_back({key, value});
      continue;
    }
    if (key != "skip" && key != "axis" && !said.insert(key).second)
      return absl::InvalidArgumentError(absl::StrCat(place, ": ", key, " is said twice, expected once"));
    RETURN_IF_ERROR(base::Within(absl::StrCat(place, ": ", session::Printable(key)), ReadRule(key, value, &out)));
  }
  RETURN_IF_ERROR(base::Within(name, CheckWhole(out)));
  RETURN_IF_ERROR(AddUsualLines(&out));
  Finish(&out);
  if (!out.header.empty()) RETURN_IF_ERROR(base::Within(name, session::ValidateHeader(out.header)));
  return out;
}

}  // namespace axiscal::logs
