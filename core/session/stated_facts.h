// What a session's header states of lengths that grow with warmth, and of certificates (docs/formats.md, "To 20 deg C"
// and "Certificates").
//   # expansion WHAT: COEFFICIENT SIGMA [COLUMN]       um/(m K), standard uncertainty; temp_C or T_NAME_C
//   # certificate WHAT: NUMBER due DATE [value V UNIT U EXPANDED UNIT k FACTOR]
#ifndef AXISCAL_CORE_SESSION_STATED_FACTS_H_
#define AXISCAL_CORE_SESSION_STATED_FACTS_H_

#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/language.h"
#include "core/base/status.h"
#include "core/session/instrument_format.h"
#include "core/session/session.h"

namespace axiscal::session {

// A length L at 20 deg C is L (1 + per_kelvin (T - 20 deg C)) at T, T the reading's temperature in `column`.
struct Expansion {
  std::string of;                                   // "bar", "instrument", "artefact", "scale", "workpiece"
  std::string axis;                                 // of a scale: the linear axis that it belongs to
  double per_kelvin = 0.0, sigma_per_kelvin = 0.0;  // 1/K; standard uncertainty
  std::string column;                               // "temp_C", "T_bar_C"

  // "expansion of scale X, 8 +- 0.5 um/(m K)": sessions in which it is the same mean the same thing.
  std::string text(base::Language language = base::Language::kEnglish) const;
};

struct Certificate {
  // At 20 deg C: mm of "bar_length", a share of the length of "scale" (what it reads too much).
  struct Value {
    double value = 0.0, sigma = 0.0;  // sigma: expanded uncertainty / coverage factor
  };

  std::string of;             // "bar_length", "scale"; any other word of a thing that is only named
  std::string number;         // of the certificate
  std::string due;            // "2027-01-31", the last day on which it is valid
  base::UtcTime valid_until;  // the end of that day, UTC
  std::optional<Value> value;

  // "certificate 4711 of bar_length".
  std::string text(base::Language language = base::Language::kEnglish) const;
};

// The thermometer of a column: "thermometer of temp_C, +- 0.1 K".
std::string ThermometerText(const std::string& column, double sigma_kelvin,
                            base::Language language = base::Language::kEnglish);

// INVALID_ARGUMENT with value and rule, no place.
absl::StatusOr<Expansion> ParseExpansion(const HeaderEntry& entry);
absl::StatusOr<Certificate> ParseCertificate(const HeaderEntry& entry);

// Of a valid header.
std::vector<Expansion> ExpansionsOf(const std::vector<HeaderEntry>& header);
std::vector<Certificate> CertificatesOf(const std::vector<HeaderEntry>& header);

inline constexpr char kTemperatureSigmaKey[] = "temperature_sigma_K";

// OK when every such entry has its form, stands once and goes with the instrument. INVALID_ARGUMENT with line and key.
absl::Status ValidateStatedFacts(const std::vector<HeaderEntry>& header, const InstrumentFormat& format);

}  // namespace axiscal::session

#endif  // AXISCAL_CORE_SESSION_STATED_FACTS_H_
