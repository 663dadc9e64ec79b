// What the detector tells: facts, and their words for a technician.
#ifndef AXISCAL_CORE_DRIFT_FINDING_H_
#define AXISCAL_CORE_DRIFT_FINDING_H_

#include <string>
#include <variant>
#include <vector>

#include "core/drift/calibration.h"

namespace axiscal::drift {

// How sure a finding is, as a word. The share of alarms that were right over simulated machines is in docs/drift.md.
enum class Word { kPossible, kProbable, kCertain };
const char* Text(Word word);  // "possible", "probable", "certain"

// One error's part in a finding, in its unit.
struct Amount {
  std::string symbol;
  Unit unit = Unit::kUm;
  double size = 0.0;
  double sigma = 0.0;  // one standard uncertainty
};

// Errors that moved together and stayed where they went.
struct StepChange {
  base::UtcTime after;          // the last calibration before it
  base::UtcTime by;             // the first calibration after it
  base::UtcTime found_at;       // the calibration with which it was found
  std::vector<Amount> amounts;  // size: now - before; in the order in which they were found, the clearest first
  double score = 0.0;           // ln of the odds for a step against outliers and nothing
  double certainty = 0.0;       // 0 .. 1
  Word word = Word::kPossible;
  bool is_revision = false;  // of the step told last, of the same dates: bad calibrations were in its sizes
};

// What was told as a step went back at once: bad calibrations rather than a step.
struct Retraction {
  base::UtcTime after, by;  // of the step that was told
  base::UtcTime at;         // the calibration that shows it
  std::vector<std::string> symbols;
};

// Errors that stood elsewhere in one calibration: an outlier, or the first calibration after a step. Repeat it.
struct Suspect {
  base::UtcTime at;
  std::vector<Amount> amounts;  // size: measured - expected
  double certainty = 0.0;       // that this calibration is not one more like those before
};

// Wear: an error that goes one way. Sizes per year.
struct Slope {
  base::UtcTime at;      // the calibration with which it is said
  bool is_over = false;  // said before, and no longer so
  Amount per_year{};
  double certainty = 0.0;
};

// An error that comes and goes with the year, or with the recorded temperature. Never said before two years.
struct Season {
  base::UtcTime at;
  bool is_over = false;
  Amount amplitude{};                  // half of the way from the lowest to the highest within a year
  std::optional<Amount> per_kelvin{};  // where temperatures were recorded
  double certainty = 0.0;
};

// Calibrations scatter by another factor than they state.
struct Noise {
  base::UtcTime at;
  bool is_over = false;
  std::string symbol;
  double factor = 1.0;  // scatter from calibration to calibration by stated sigma
};

// Suspect calibrations one after the other that agree with nothing: what was known of the machine is given up.
struct Unstable {
  base::UtcTime since, at;
};

using Finding = std::variant<StepChange, Retraction, Suspect, Slope, Season, Noise, Unstable>;

// One or two sentences: "between 5 and 12 May 2026 EX0C and EB0C jumped together by 21 um and 14 urad, certainty
// 99.7 %". Dates are UTC.
std::string Text(const Finding& finding);

// "possible" below the score 1, "probable" to 4, "certain" above.
Word WordOf(double score);

// The share of alarms of this score that were right over simulated machines (docs/drift.md).
double CertaintyOf(double score);

}  // namespace axiscal::drift

#endif  // AXISCAL_CORE_DRIFT_FINDING_H_
