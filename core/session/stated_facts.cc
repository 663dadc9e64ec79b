#include "core/session/stated_facts.h"

#include <algorithm>
#include <chrono>

#include "absl/strings/ascii.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "core/session/header_rules.h"
#include "core/session/text.h"

namespace axiscal::session {
namespace {

constexpr char kExpansion[] = "expansion ", kCertificate[] = "certificate ";
constexpr double kPerMillion = 1e-6;
// Invar has 1 um/(m K), steel 11.5, aluminium 23, plastics 100; carbon fibre shrinks a little.
constexpr double kLeastPerMillion = -20.0, kMostPerMillion = 300.0, kMostSigmaPerMillion = 50.0;
constexpr double kSmallestPerMillion = 0.001;  // glass ceramics have 0.02

bool HasPrefix(const HeaderEntry& entry, const std::string& prefix) {
  return entry.key.compare(0, prefix.size(), prefix) == 0;
}

absl::Status Expected(const HeaderEntry& entry, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat(Quoted(entry.value), ", expected ", what));
}

std::vector<std::string> WordsOf(const std::string& text) { return absl::StrSplit(text, ' ', absl::SkipEmpty()); }

bool ParseNumber(const std::string& text, double* number) {
  std::vector<double> numbers;
  if (!ParseNumbers(text, &numbers) || numbers.size() != 1) return false;
  *number = numbers[0];
  return true;
}

bool IsTemperatureColumn(const std::string& name) {
  return name == "temp_C" || (name.size() > 4 && name.compare(0, 2, "T_") == 0 && name.ends_with("_C"));
}

// Of which instrument a value of this thing is a fact.
struct CertifiedValue {
  const char *of, *instrument, *unit, *sigma_unit;
  double unit_size, sigma_size, least, most;  // least and most in `unit`
};
constexpr CertifiedValue kCertified[] = {
    {"bar_length", "ballbar", "mm", "um", 1.0, 1e-3, kMinBarLengthMm, kMaxBarLengthMm},
    {"scale", "length", "um/m", "um/m", kPerMillion, kPerMillion, -1e4, 1e4},
};

const CertifiedValue* FindCertified(const std::string& of) {
  for (const CertifiedValue& one : kCertified)
    if (of == one.of) return &one;
  return nullptr;
}

absl::StatusOr<Certificate::Value> ParseValue(const HeaderEntry& entry, const std::string& of,
                                              const std::vector<std::string>& words) {
  const CertifiedValue* const known = FindCertified(of);
  if (known == nullptr)
    return Expected(entry, "no value: only those of bar_length and scale are used, of others number and date");
  const std::string form =
      absl::StrFormat("'NUMBER due DATE value V %s U EXPANDED %s k FACTOR'", known->unit, known->sigma_unit);
  double value = 0.0, expanded = 0.0, factor = 0.0;
  const bool fits = words.size() == 11 && words[3] == "value" && ParseNumber(words[4], &value) &&
                    words[5] == known->unit && words[6] == "U" && ParseNumber(words[7], &expanded) &&
                    words[8] == known->sigma_unit && words[9] == "k" && ParseNumber(words[10], &factor);
  if (!fits) return Expected(entry, form);
  if (value < known->least || value > known->most)
    return Expected(entry, absl::StrFormat("a value from %g to %g %s", known->least, known->most, known->unit));
  constexpr double kLeastFactor = 1.0, kMostFactor = 5.0;
  if (!(expanded > 0.0) || factor < kLeastFactor || factor > kMostFactor)
    return Expected(entry, "U > 0 and a coverage factor k from 1 to 5");
  return Certificate::Value{value * known->unit_size, expanded / factor * known->sigma_size};
}

absl::Status CheckInstrument(const Expansion& expansion, const InstrumentFormat& format) {
  const std::pair<const char*, const char*> of_one[] = {
      {"bar", "ballbar"}, {"instrument", "length"}, {"artefact", "touch"}};
  for (const auto& [of, instrument] : of_one) {
    if (expansion.of == of && format.name != instrument)
      return absl::InvalidArgumentError(
          absl::StrCat("is of instrument ", instrument, ", this session's is ", format.name));
  }
  if (format.axes == AxisColumns::kNone)
    return absl::InvalidArgumentError(
        absl::StrCat("instrument ", format.name, " has no temperature beside each reading, expected no expansion"));
  return absl::OkStatus();
}

}  // namespace

std::string Expansion::text(base::Language language) const {
  const double a = per_kelvin / kPerMillion, sigma = sigma_per_kelvin / kPerMillion;
  if (language == base::Language::kEnglish)
    return absl::StrFormat("expansion of %s%s, %g +- %g um/(m K)", of, axis.empty() ? "" : " " + axis, a, sigma);
  const char* const german = of == "bar"          ? "des Stabs"
                             : of == "instrument" ? "des Messmittels"
                             : of == "artefact"   ? "des Normals"
                             : of == "workpiece"  ? "des Werkstücks"
                                                  : "des Maßstabs";
  return absl::StrCat("Ausdehnung ", german, axis.empty() ? "" : " ", axis, ", ",
                      base::NumberIn(language, absl::StrFormat("%g ± %g", a, sigma)), " µm/(m K)");
}

std::string Certificate::text(base::Language language) const {
  if (language == base::Language::kEnglish) return absl::StrCat("certificate ", number, " of ", of);
  return absl::StrCat("Kalibrierschein ", number, " für ",
                      of == "bar_length" ? "die Stablänge"
                      : of == "scale"    ? "die Teilung"
                                         : of);
}

std::string ThermometerText(const std::string& column, double sigma_kelvin, base::Language language) {
  if (language == base::Language::kEnglish) return absl::StrFormat("thermometer of %s, +- %g K", column, sigma_kelvin);
  return absl::StrCat("Thermometer ", column, ", ± ", base::NumberIn(language, absl::StrFormat("%g", sigma_kelvin)),
                      " K");
}

absl::StatusOr<Expansion> ParseExpansion(const HeaderEntry& entry) {
  const std::vector<std::string> what = WordsOf(entry.key.substr(sizeof(kExpansion) - 1));
  Expansion expansion;
  if (what.size() == 1 &&
      (what[0] == "bar" || what[0] == "instrument" || what[0] == "artefact" || what[0] == "workpiece")) {
    expansion.of = what[0];
  } else if (what.size() == 2 && what[0] == "scale") {
    expansion.of = what[0];
    expansion.axis = what[1];
  } else {
    return absl::InvalidArgumentError(
        "expected 'expansion' and one of bar, instrument, artefact, workpiece, or 'scale' and an axis");
  }
  const std::vector<std::string> words = WordsOf(entry.value);
  const std::string rule = absl::StrFormat(
      "a coefficient from %g to %g (0, or at least %g in size) and its standard uncertainty from 0 to %g, um/(m K), "
      "and, if it is not temp_C, the column of its temperature: 11.5 0.5 T_bar_C",
      kLeastPerMillion, kMostPerMillion, kSmallestPerMillion, kMostSigmaPerMillion);
  double coefficient = 0.0, sigma = 0.0;
  if (words.size() < 2 || words.size() > 3 || !ParseNumber(words[0], &coefficient) || !ParseNumber(words[1], &sigma))
    return Expected(entry, rule);
  if (coefficient < kLeastPerMillion || coefficient > kMostPerMillion || sigma < 0.0 || sigma > kMostSigmaPerMillion)
    return Expected(entry, rule);
  // A number in 1/K.
  if (coefficient != 0.0 && std::abs(coefficient) < kSmallestPerMillion) return Expected(entry, rule);
  expansion.column = words.size() == 3 ? words[2] : "temp_C";
  if (!IsTemperatureColumn(expansion.column)) return Expected(entry, rule);
  expansion.per_kelvin = coefficient * kPerMillion;
  expansion.sigma_per_kelvin = sigma * kPerMillion;
  return expansion;
}

absl::StatusOr<Certificate> ParseCertificate(const HeaderEntry& entry) {
  Certificate certificate;
  certificate.of = entry.key.substr(sizeof(kCertificate) - 1);
  const std::vector<std::string> words = WordsOf(entry.value);
  constexpr size_t kDateBytes = 10;  // 2027-01-31, no time of day
  const std::optional<base::UtcTime> due =
      words.size() >= 3 && words[1] == "due" && words[2].size() == kDateBytes ? ParseIso8601(words[2]) : std::nullopt;
  if (!due)
    return Expected(entry, "'NUMBER due DATE', the date as 2027-01-31, and behind it a value where there is one");
  certificate.number = words[0];
  certificate.due = words[2];
  certificate.valid_until = *due + std::chrono::hours(24);
  if (words.size() > 3) {
    ASSIGN_OR_RETURN(certificate.value, ParseValue(entry, certificate.of, words));
  }
  return certificate;
}

std::vector<Expansion> ExpansionsOf(const std::vector<HeaderEntry>& header) {
  std::vector<Expansion> expansions;
  for (const HeaderEntry& entry : header) {
    if (!HasPrefix(entry, kExpansion)) continue;
    if (auto expansion = ParseExpansion(entry); expansion.ok()) expansions.push_back(*std::move(expansion));
  }
  return expansions;
}

std::vector<Certificate> CertificatesOf(const std::vector<HeaderEntry>& header) {
  std::vector<Certificate> certificates;
  for (const HeaderEntry& entry : header) {
    if (!HasPrefix(entry, kCertificate)) continue;
    if (auto certificate = ParseCertificate(entry); certificate.ok()) certificates.push_back(*std::move(certificate));
  }
  return certificates;
}

namespace {
// A key's words, small, with one blank between them.
std::string SmallWordsOf(const std::string& key) {
  return absl::AsciiStrToLower(absl::StrJoin(absl::StrSplit(key, ' ', absl::SkipEmpty()), " "));
}
}  // namespace

absl::Status ValidateStatedFacts(const std::vector<HeaderEntry>& header, const InstrumentFormat& format) {
  bool any_scale = false, any_workpiece = false;
  for (size_t i = 0; i < header.size(); ++i) {
    const HeaderEntry& entry = header[i];
    const std::string place = absl::StrCat("line ", HeaderLine(i), ": ", Printable(entry.key));
    const bool is_expansion = HasPrefix(entry, kExpansion), is_certificate = HasPrefix(entry, kCertificate);
    const bool is_sigma = entry.key == kTemperatureSigmaKey;
    // Taken for a key that says nothing, "Expansion bar" would leave readings as they are in silence.
    const std::string words = SmallWordsOf(entry.key), first = words.substr(0, words.find(' '));
    if ((first == "expansion" && !is_expansion) || (first == "certificate" && !is_certificate))
      return absl::InvalidArgumentError(absl::StrCat(place, ": expected '", first, "' in small letters, then of what"));
    if (!is_expansion && !is_certificate && !is_sigma) continue;
    for (size_t before = 0; before < i; ++before) {
      if (SmallWordsOf(header[before].key) == words)
        return absl::InvalidArgumentError(
            absl::StrCat(place, ": stands in line ", HeaderLine(before), " already, expected once"));
    }
    if (is_sigma) {
      double sigma = 0.0;
      constexpr double kMostKelvin = 10.0;
      if (!ParseNumber(entry.value, &sigma) || !(sigma > 0.0) || sigma > kMostKelvin)
        return absl::InvalidArgumentError(
            absl::StrCat(place, ": ", Quoted(entry.value),
                         ", expected one number above 0 up to 10, the standard uncertainty of the thermometers in K"));
    } else if (is_expansion) {
      const auto expansion = ParseExpansion(entry);
      if (!expansion.ok()) return base::Within(place, expansion.status());
      RETURN_IF_ERROR(base::Within(place, CheckInstrument(*expansion, format)));
      any_scale |= expansion->of == "scale";
      any_workpiece |= expansion->of == "workpiece";
      if (any_scale && any_workpiece)
        return absl::InvalidArgumentError(
            absl::StrCat(place,
                         ": figures are those of the machine at 20 deg C (scale) or of what it cuts there (workpiece), "
                         "expected only one of both"));
    } else {
      const auto certificate = ParseCertificate(entry);
      if (!certificate.ok()) return base::Within(place, certificate.status());
      const CertifiedValue* const known = FindCertified(certificate->of);
      if (certificate->value && format.name != known->instrument)
        return absl::InvalidArgumentError(absl::StrCat(place, ": a value of ", certificate->of, " is of instrument ",
                                                       known->instrument, ", this session's is ", format.name));
    }
  }
  return absl::OkStatus();
}

}  // namespace axiscal::session
