// The report of the loop (docs/formats.md, "Loop report").
#ifndef AXISCAL_CORE_REPORTS_LOOP_H_
#define AXISCAL_CORE_REPORTS_LOOP_H_

#include <array>

#include "core/base/status.h"
#include "core/machine/written_term.h"
#include "core/reports/axis_range.h"
#include "core/reports/fitted.h"

namespace axiscal::reports {

// An error term without its amplitude, and what texts call it: "EBB:harmonic(45)".
struct NamedTerm {
  machine::WrittenTerm term;
  std::string name = {};
};

// A named effect that the declared model lacked.
struct Effect {
  NamedTerm is = {};
  double amplitude = kNoNumber, amplitude_sigma = kNoNumber;  // in `unit`
  std::string unit = {};
  std::optional<double> phase_deg = {};  // of shapes that have one
  std::vector<int> alias_orders = {};    // of a harmonic: orders beyond Nyquist that would read the same
  double rms_um = kNoNumber;             // what it does to the readings
  double evidence = kNoNumber;
  std::vector<NamedTerm> equivalent = {};     // what the sessions cannot tell from it
  std::vector<std::string> same_always = {};  // of those, the effect by other names: no measurement tells them
};

enum class Verdict { kAdequate, kExtended, kUnexplained };
enum class Carrier { kTable, kTool };
enum class PartKind { kLocal, kSlip, kCheckSession, kBadReadings, kScatter };
enum class Change { kAdded, kDropped, kReplaced, kWithdrawn, kRefused };

// What slipped, and how far in x, y, z of the frame of the table or the tool. NaN: its session does not see that way.
struct Slip {
  Carrier carrier = Carrier::kTable;
  std::optional<Carrier> may_be = {};  // the readings do not tell one from the other
  std::array<double, 3> moved_um = {kNoNumber, kNoNumber, kNoNumber}, sigma_um = moved_um;
};

// What is no error of the machine: an instrument at fault, wrong nominal data, what does not repeat. Never compensated.
enum class CauseKind { kInstrument, kNominal, kNotRepeatable };
struct Cause {
  CauseKind kind = CauseKind::kInstrument;
  std::string subject = {};     // which instrument in which sessions, which entry of a file ...
  double evidence = kNoNumber;  // likelihood ratio, chi-square units
  std::string correction = {};  // what to do about it, with the values that were found
  // The same in German; empty in a report of a version that did not write it.
  std::string subject_german = {}, correction_german = {};
};

// An effect that was found and is not corrected, as the machine could be worse for it over the measured box: the
// readings do not tell well enough how large it is (uncertain), or what it is (undecided), or it does there many times
// of all that they show (hidden); or as all that was found promises no gain there (no gain).
enum class HeldBackKind { kUncertain, kUndecided, kNoGain, kHidden };
struct HeldBack {
  HeldBackKind kind = HeldBackKind::kUncertain;
  std::string subject = {};     // name of the effect
  double evidence = kNoNumber;  // of the effect
  double harm = kNoNumber;      // probability of being worse, with this effect and those after it, less those before it
  std::string measure = {};     // what would decide
};

// Structure that was found but has no name.
struct Unexplained {
  PartKind kind = PartKind::kLocal;
  std::string variable = {};                // axis, or "t" for a moment
  double from = kNoNumber, to = kNoNumber;  // in `unit`
  std::string unit = {};                    // mm, deg, s
  std::string session = {};                 // where it shows most
  double rms_um = kNoNumber;
  std::optional<Slip> slip = {};
};

// One change of the model, and the rms of the fit sessions after it.
struct SelectionStep {
  Change change = Change::kAdded;
  std::string name = {};
  double rms_um = kNoNumber;
};

// A session that would tell an effect's class apart.
struct ProposedTest {
  std::string session = {}, test = {}, text = {};
  double correlation_before = kNoNumber, correlation_after = kNoNumber, expected_chi2 = kNoNumber;
  bool needs_next = false;  // tells them together with the next one
  std::string beyond = {};  // how it leaves the measured poses; empty: it does not
};
struct Proposal {
  std::string effect = {};
  std::vector<std::string> separates = {};
  std::optional<ProposedTest> test = {};  // without: no known test tells it
  std::vector<std::string> remaining = {}, same_always = {};
};

struct SessionNoise {
  std::string session = {};
  double stated_sigma_um = kNoNumber, sigma_um = kNoNumber, neighbour_correlation = kNoNumber;
};

struct BeforeAfter {
  Statistics before = {}, after = {};
};
struct Check {
  Statistics before = {}, after = {};
  bool fitted = false;  // the check sessions were fitted too and prove nothing
};

// Root of the expected mean square, and the 95 % interval.
struct VolumetricFigure {
  double rms_um = kNoNumber, low_um = kNoNumber, high_um = kNoNumber;
};
// The tool point's error over the box of measured positions, less work offset, tool length and tool centre
// (core/predict/volumetric.h): of the machine as it is, corrected for the declared errors alone, corrected for all.
struct Volumetric {
  std::vector<AxisRange> box = {};  // axes that moved
  int poses = 0;
  VolumetricFigure uncorrected = {}, before = {}, after = {};
  bool gain_is_held = false;                // the interval of before - after is above zero
  std::vector<std::string> weakest = {};    // errors whose uncertainty makes most of `after`
  std::vector<std::string> undecided = {};  // effects of which the readings do not tell rivals that make as much of it
  std::vector<std::string> unknown = {};    // errors without a number that act over the box: in none of the figures
};

struct Loop {
  Verdict verdict = Verdict::kAdequate;
  std::vector<Effect> effects = {};
  std::vector<Cause> causes = {};
  std::vector<HeldBack> held_back = {};  // in none of `fitted`'s errors
  Fitted fitted = {};
  BeforeAfter fit = {};
  std::optional<Check> check = {};
  std::optional<Volumetric> volumetric = {};
  std::vector<SelectionStep> steps = {};
  std::vector<Unexplained> unexplained = {};
  std::vector<Proposal> next_measurement = {};
  std::vector<SessionNoise> noise = {};
  std::vector<std::string> withdrawn = {};  // effects that did not help on the check sessions
  std::vector<NamedTerm> not_visible = {};  // effects that would leave no trace in the fit sessions
  std::vector<std::string> axes_at_rest = {};
  bool stopped_early = false;  // at the most effects allowed
  int candidates = 0;
};

std::string ToJson(const Loop& report);
// INVALID_ARGUMENT naming line and column, or the member that is wrong.
absl::StatusOr<Loop> ReadLoop(const std::string& text);

}  // namespace axiscal::reports

#endif  // AXISCAL_CORE_REPORTS_LOOP_H_
