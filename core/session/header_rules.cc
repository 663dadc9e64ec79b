#include "core/session/header_rules.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_split.h"
#include "core/session/stated_facts.h"
#include "core/session/text.h"

namespace axiscal::session {
namespace {

std::string EntryPlace(size_t index, const HeaderEntry& entry) {
  return absl::StrCat("line ", HeaderLine(index), ": ", Printable(entry.key), ": ");
}

// Index of the only entry with `key`; a second one is refused, none is npos.
absl::StatusOr<size_t> FindOnce(const std::vector<HeaderEntry>& header, const std::string& key) {
  size_t found = std::string::npos;
  for (size_t i = 0; i < header.size(); ++i) {
    if (header[i].key != key) continue;
    if (found != std::string::npos) {
      return absl::InvalidArgumentError(
          absl::StrCat(EntryPlace(i, header[i]), "stands in line ", HeaderLine(found), " already, expected once"));
    }
    found = i;
  }
  return found;
}

absl::Status ValidateEntry(size_t index, const HeaderEntry& entry, const HeaderRule& rule) {
  const auto refuse = [&] {
    return absl::InvalidArgumentError(
        absl::StrCat(EntryPlace(index, entry), Quoted(entry.value), ", expected ", rule.expected));
  };
  if (rule.count == 0) {
    if (!entry.value.empty() && entry.value.size() <= kMaxNameBytes) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrCat(EntryPlace(index, entry), Quoted(entry.value),
                                                   ", expected a text of 1 to ", kMaxNameBytes, " bytes"));
  }
  std::vector<double> numbers;
  if (!ParseNumbers(entry.value, &numbers) || static_cast<int>(numbers.size()) != rule.count) return refuse();
  const auto fits = [&rule](double number) { return number >= rule.min && number <= rule.max; };
  return std::all_of(numbers.begin(), numbers.end(), fits) ? absl::OkStatus() : refuse();
}

absl::Status ValidateKeys(const std::vector<HeaderEntry>& header, const std::vector<HeaderRule>& rules,
                          const std::string& who) {
  for (const HeaderRule& rule : rules) {
    ASSIGN_OR_RETURN(const size_t found, FindOnce(header, rule.key));
    if (found == std::string::npos) {
      return absl::InvalidArgumentError(absl::StrCat("line ", HeaderLine(header.size()), ": header key ", rule.key,
                                                     " is missing, ", who, " needs '# ", rule.key, ": ...' (",
                                                     rule.expected, ")"));
    }
    RETURN_IF_ERROR(ValidateEntry(found, header[found], rule));
  }
  return absl::OkStatus();
}

absl::Status ValidateFeatures(const std::vector<HeaderEntry>& header, const InstrumentFormat& format) {
  bool any = format.features.empty();
  for (size_t i = 0; i < header.size(); ++i) {
    const FeatureRule* rule = FindFeatureRule(format, header[i].key);
    if (rule == nullptr) continue;
    any = true;
    RETURN_IF_ERROR(FindOnce(header, header[i].key).status());
    RETURN_IF_ERROR(ValidateEntry(i, header[i], {"", rule->count, -kMaxLengthMm, kMaxLengthMm, rule->expected}));
  }
  if (any) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("line ", HeaderLine(header.size()), ": no '# ",
                                                 format.features[0].prefix, " NAME: ...', instrument ", format.name,
                                                 " needs at least one"));
}

// Readings that no column of an axis belongs to have no commanded position either.
absl::Status ValidateDatum(const std::vector<HeaderEntry>& header, const InstrumentFormat& format) {
  ASSIGN_OR_RETURN(const size_t datum, FindOnce(header, "datum"));
  if (datum == std::string::npos) return absl::OkStatus();
  const std::string place = EntryPlace(datum, header[datum]);
  if (format.axes == AxisColumns::kNone) {
    return absl::InvalidArgumentError(
        absl::StrCat(place, "instrument ", format.name, " has no commanded positions, expected no datum line"));
  }
  const auto axes = ParseDatum(header[datum].value);
  return axes.ok() ? absl::OkStatus() : absl::InvalidArgumentError(absl::StrCat(place, axes.status().message()));
}

// What the machine carried, and where down is, as they were during the session.
absl::Status ValidateLoad(const std::vector<HeaderEntry>& header) {
  ASSIGN_OR_RETURN(const size_t payload, FindOnce(header, "payload_kg"));
  if (payload != std::string::npos) {
    RETURN_IF_ERROR(ValidateEntry(
        payload, header[payload],
        {"payload_kg", 1, 0.0, kMaxPayloadKg, absl::StrFormat("one mass in kg from 0 to %g", kMaxPayloadKg)}));
  }
  ASSIGN_OR_RETURN(const size_t gravity, FindOnce(header, "gravity"));
  if (gravity == std::string::npos) return absl::OkStatus();
  const HeaderRule rule = {"gravity", 3, -1.0, 1.0,
                           "the direction of gravity, a unit vector in machine coordinates: 0 0 -1"};
  RETURN_IF_ERROR(ValidateEntry(gravity, header[gravity], rule));
  std::vector<double> down;
  ParseNumbers(header[gravity].value, &down);
  constexpr double kUnit = 1e-6;  // of the length, as directions in machine.json
  if (std::abs(std::hypot(down[0], down[1], down[2]) - 1.0) <= kUnit) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(EntryPlace(gravity, header[gravity]), Quoted(header[gravity].value), ", expected ", rule.expected));
}

absl::Status ValidateOptional(const std::vector<HeaderEntry>& header, const InstrumentFormat& format) {
  RETURN_IF_ERROR(ValidateDatum(header, format));
  RETURN_IF_ERROR(ValidateLoad(header));
  RETURN_IF_ERROR(ValidateStatedFacts(header, format));
  ASSIGN_OR_RETURN(const size_t setup, FindOnce(header, "setup"));
  if (setup != std::string::npos) RETURN_IF_ERROR(ValidateEntry(setup, header[setup], {"setup", 0, 0, 0, "a text"}));
  ASSIGN_OR_RETURN(const size_t started, FindOnce(header, "started"));
  if (started != std::string::npos && !ParseIso8601(header[started].value)) {
    return absl::InvalidArgumentError(absl::StrCat(EntryPlace(started, header[started]), Quoted(header[started].value),
                                                   ", expected a date and time of ISO 8601: 2026-05-31T14:03:00Z"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<std::string>> ParseDatum(const std::string& value) {
  std::vector<std::string> words = absl::StrSplit(value, ' ', absl::SkipEmpty());
  const auto is_axis = [](const std::string& word) {
    return word[0] >= 'A' && word[0] <= 'Z' &&
           std::all_of(word.begin() + 1, word.end(), [](char c) { return c >= '0' && c <= '9'; });
  };
  const bool is_free = words.size() > 1 && words[0] == "free";
  if (!is_free || !std::all_of(words.begin() + 1, words.end(), is_axis)) {
    return absl::InvalidArgumentError(
        absl::StrCat(Quoted(value),
                     ", expected 'free' and the linear axes whose work offset was set anew: "
                     "free X Z"));
  }
  words.erase(words.begin());
  for (size_t i = 0; i < words.size(); ++i) {
    if (std::find(words.begin(), words.begin() + static_cast<std::ptrdiff_t>(i), words[i]) !=
        words.begin() + static_cast<std::ptrdiff_t>(i))
      return absl::InvalidArgumentError(
          absl::StrCat(Quoted(value), ": axis ", words[i], " is there twice, expected once"));
  }
  return words;
}

const FeatureRule* FindFeatureRule(const InstrumentFormat& format, const std::string& key) {
  for (const FeatureRule& rule : format.features) {
    if (key.size() > rule.prefix.size() + 1 && key.compare(0, rule.prefix.size() + 1, rule.prefix + " ") == 0)
      return &rule;
  }
  return nullptr;
}

absl::Status ValidateHeader(const std::vector<HeaderEntry>& header) {
  if (header.size() > kMaxHeaderEntries) {
    return absl::InvalidArgumentError(
        absl::StrCat(header.size(), " header lines, at most ", kMaxHeaderEntries, " are read"));
  }
  for (size_t i = 0; i < header.size(); ++i) {
    const HeaderEntry& entry = header[i];
    const auto trimmed = [](const std::string& text) {
      return text.empty() || (text.front() != ' ' && text.back() != ' ');
    };
    if (entry.key.empty() || entry.key.find(':') != std::string::npos || !trimmed(entry.key) || !trimmed(entry.value) ||
        !IsPlainText(entry.key) || !IsPlainText(entry.value)) {
      return absl::InvalidArgumentError(
          absl::StrCat(EntryPlace(i, entry), Quoted(entry.value), ", expected '# key: value' in UTF-8"));
    }
  }
  RETURN_IF_ERROR(ValidateKeys(header, CommonHeader(), "every session"));
  ASSIGN_OR_RETURN(const size_t instrument, FindOnce(header, "instrument"));
  const InstrumentFormat* format = FindInstrumentFormat(header[instrument].value);
  if (format == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat(EntryPlace(instrument, header[instrument]),
                                                   Quoted(header[instrument].value), ", expected one of ",
                                                   InstrumentNames()));
  }
  RETURN_IF_ERROR(ValidateKeys(header, format->header, "instrument " + format->name));
  RETURN_IF_ERROR(ValidateFeatures(header, *format));
  return ValidateOptional(header, *format);
}

}  // namespace axiscal::session
