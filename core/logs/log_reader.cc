#include "core/logs/log_reader.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/ascii.h"
#include "absl/time/time.h"
#include "core/base/error_detail.h"
#include "core/session/line_reader.h"
#include "core/session/text.h"

namespace axiscal::logs {
namespace {

const FieldValue& FieldOf(const LinePattern& pattern, const Match& match, const std::string& field) {
  size_t i = 0;
  while (pattern.pieces[i].field != field) ++i;  // the template was checked to have it
  return match.fields[i];
}

// Nothing but blanks and marks of a file's begin and end.
bool SaysNothing(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c == ' ' || c == '\t' || c == '%' || c == '\x1A'; });
}

class Reader {
 public:
  Reader(const std::string& name, const LogTemplate& log_template, const LinePattern& pattern)
      : name_(name), template_(log_template), pattern_(pattern) {}

  absl::Status Add(size_t number, const std::string& text, bool has_line_end) {
    if (SaysNothing(text)) return absl::OkStatus();
    // What came before was not the last line.
    RETURN_IF_ERROR(failure_);
    last_is_reading_ = false;
    for (const LinePattern& skip : template_.skip) {
      if (MatchLine(skip, text).is_match) return absl::OkStatus();
    }
    if (!has_line_end) {
      log_.cut = CutLine{number, text};
      return absl::OkStatus();
    }
    if (template_.count) {
      const Match match = MatchLine(*template_.count, text);
      if (match.is_match) return Announce(number, FieldOf(*template_.count, match, "count").number);
    }
    if (template_.mark) {
      const Match match = MatchLine(*template_.mark, text);
      if (match.is_match) {
        for (const char* const name : {"feature", "rod"}) {
          if (HasField(*template_.mark, name)) feature_ = FieldOf(*template_.mark, match, name).text;
        }
        return absl::OkStatus();
      }
    }
    return AddReading(number, text);
  }

  absl::StatusOr<Log> Finish() {
    if (!failure_.ok()) {
      if (!may_be_cut_) return failure_;
      log_.cut = failed_line_;
    } else if (last_is_reading_ && LastIsShort()) {
      log_.cut = CutLine{log_.readings.back().line, last_text_};
      log_.readings.pop_back();
    }
    CloseAnnouncement();
    std::erase_if(log_.announcements, [](const Announcement& a) { return a.announced == a.found; });
    if (!log_.readings.empty()) return std::move(log_);
    return absl::InvalidArgumentError(absl::StrCat(name_, ": no line is a reading of the form '", pattern_.text,
                                                   "', expected at least one",
                                                   log_.cut ? " (its only one is cut)" : ""));
  }

 private:
  absl::Status AddReading(size_t number, const std::string& text) {
    Match match = MatchLine(pattern_, text);
    if (match.is_match) {
      RETURN_IF_ERROR(ReadTime(number, &match));
      log_.readings.push_back({number, std::move(match.fields), feature_});
      last_is_reading_ = true;
      last_text_ = text;
      return absl::OkStatus();
    }
    const std::string there =
        match.column < text.size() ? session::Quoted(text.substr(match.column)) : "the line's end";
    failure_ = WrongAt({number, match.column + 1},
                       absl::StrCat(name_, ": line ", number, ", column ", match.column + 1, ": ", there, ", expected ",
                                    match.expected, " (template ", template_.name, ")"));
    may_be_cut_ = match.column >= text.size();
    failed_line_ = {number, text};
    return absl::OkStatus();  // told when another line follows, or at the end
  }

  // Seconds since the first reading, of a moment as `time:` has it.
  absl::Status ReadTime(size_t number, Match* match) {
    if (template_.time.empty()) return absl::OkStatus();
    for (size_t i = 0; i < pattern_.pieces.size(); ++i) {
      if (pattern_.pieces[i].field != "t_s") continue;
      const std::string& text = match->fields[i].text;
      // A form has the point before decimals of seconds; other commas stand in the form as they do in the log.
      std::string with_points = text, why;
      for (size_t c = 1; template_.decimal == ',' && c + 1 < text.size(); ++c) {
        if (text[c] == ',' && absl::ascii_isdigit(text[c - 1]) && absl::ascii_isdigit(text[c + 1]))
          with_points[c] = '.';
      }
      absl::Time time;
      if (!absl::ParseTime(template_.time, with_points, &time, &why))
        return WrongAt({number, 0, "t_s"}, absl::StrCat(name_, ": line ", number, " (t_s): ", session::Quoted(text),
                                                        ", expected a time of the form ", template_.time, " (template ",
                                                        template_.name, ")"));
      if (!first_time_) first_time_ = time;
      match->fields[i].number = absl::ToDoubleSeconds(time - *first_time_);
    }
    return absl::OkStatus();
  }

  absl::Status Announce(size_t number, double count) {
    if (!(count >= 0.0 && count < 1e9 && std::floor(count) == count)) {
      return WrongAt({number, 0, "count"},
                     absl::StrCat(name_, ": line ", number, ": a count of ", count, ", expected a whole number"));
    }
    CloseAnnouncement();
    log_.announcements.push_back({number, static_cast<long>(count), 0});
    readings_before_ = log_.readings.size();
    return absl::OkStatus();
  }

  void CloseAnnouncement() {
    if (!log_.announcements.empty())
      log_.announcements.back().found = static_cast<long>(log_.readings.size() - readings_before_);
  }

  // A control prints a field with the same decimals every time: fewer in the last number of the last line are the rest
  // of a cut one.
  bool LastIsShort() const {
    if (log_.readings.size() < 3) return false;
    const auto decimals = [&](size_t reading) {
      const std::vector<FieldValue>& fields = log_.readings[reading].fields;
      return pattern_.is_any_order ? FewestDecimals(reading) : fields[last_number_].decimals;
    };
    const size_t last = log_.readings.size() - 1;
    for (size_t k = 1; k < last; ++k) {
      if (decimals(k) != decimals(0)) return false;
    }
    return decimals(last) < decimals(0);
  }

  // Any order: a field's decimals, the fewest of the line's.
  int FewestDecimals(size_t reading) const {
    int fewest = 100;
    for (size_t i = 0; i < pattern_.pieces.size(); ++i) {
      if (!pattern_.pieces[i].field.empty()) fewest = std::min(fewest, log_.readings[reading].fields[i].decimals);
    }
    return fewest;
  }

  static size_t LastNumber(const LinePattern& pattern) {
    size_t last = 0;
    for (size_t i = 0; i < pattern.pieces.size(); ++i) {
      if (!pattern.pieces[i].field.empty() && !pattern.pieces[i].is_text) last = i;
    }
    return last;
  }

  const std::string& name_;
  const LogTemplate& template_;
  const LinePattern& pattern_;
  const size_t last_number_ = LastNumber(pattern_);
  Log log_;
  std::string feature_, last_text_;
  size_t readings_before_ = 0;
  bool last_is_reading_ = false;
  std::optional<absl::Time> first_time_;
  absl::Status failure_;
  bool may_be_cut_ = false;
  CutLine failed_line_;
};

}  // namespace

absl::Status WrongAt(const LogPlace& place, const std::string& message) {
  base::ErrorDetail detail{"LOG_INVALID", {{"line", std::to_string(place.line)}}};
  if (place.column > 0) detail.facts["column"] = std::to_string(place.column);
  if (!place.name.empty()) detail.facts["name"] = place.name;
  return base::Error(absl::StatusCode::kInvalidArgument, message, detail);
}

absl::StatusOr<Log> ReadLog(std::istream& in, const std::string& log_name, const LogTemplate& log_template,
                            const LinePattern& line_pattern, const std::function<bool()>& cancelled) {
  constexpr size_t kLooksEvery = 1000;  // lines, some milliseconds
  session::LineReader lines(in);
  Reader reader(log_name, log_template, line_pattern);
  session::Line line;
  while (true) {
    auto more = lines.Next(&line);
    if (!more.ok()) return base::Within(log_name, more.status());
    if (!*more) break;
    if (cancelled && line.number % kLooksEvery == 0 && cancelled())
      return absl::CancelledError(absl::StrCat(log_name, ": reading was cancelled at line ", line.number));
    RETURN_IF_ERROR(reader.Add(line.number, std::string(line.text), line.has_line_end));
  }
  return reader.Finish();
}

}  // namespace axiscal::logs
