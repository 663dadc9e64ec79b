// What closing the loop found.
#ifndef AXISCAL_CORE_LOOP_REPORT_H_
#define AXISCAL_CORE_LOOP_REPORT_H_

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/identify/identify.h"
#include "core/identify/monte_carlo.h"
#include "core/loop/candidate.h"
#include "core/loop/next_measurement.h"
#include "core/predict/volumetric.h"
#include "core/reports/loop.h"

namespace axiscal::loop {

// A named effect that the declared model lacked.
struct Effect {
  machine::ErrorTerm term;                        // with its fitted amplitude
  double amplitude = 0.0, amplitude_sigma = 0.0;  // mm or rad, of the whole term
  double rms_mm = 0.0;                            // what it does to the readings
  double evidence = 0.0;                          // score when it was found
  std::vector<machine::ErrorTerm> equivalent;     // what this data cannot tell from it
  std::vector<machine::ErrorTerm> same_always;    // of those, the effect by other names: no measurement tells them
  std::vector<int> alias_orders;                  // of a harmonic: orders beyond Nyquist that would read the same
};

// What slipped, and how far: x, y, z in the frame of the table or of the tool, mm. A direction that its session does
// not see has no number.
struct Slipped {
  instruments::Carrier carrier = instruments::Carrier::kTable;
  bool may_be_other = false;  // the readings do not tell table from tool
  std::array<std::optional<double>, 3> moved_mm;
  std::array<double, 3> sigma_mm{};
};

// What is no error of the machine and reads like some: never compensated.
struct Cause {
  enum Kind { kInstrument, kNominal, kNotRepeatable };
  Kind kind = kInstrument;
  std::string subject = {};     // which instrument in which sessions, which entry of machine.json ...
  double evidence = 0.0;        // likelihood ratio beyond the model without it, chi-square units
  std::string correction = {};  // what to do about it, with the values that were found
  std::string subject_german = {}, correction_german = {};
};

// An effect that was found and is not corrected: the machine could be worse for it where the sessions do not tell what
// it does, it does many times of all that the readings show where nothing was read, or no gain is held.
struct HeldBack {
  enum Why { kHarm, kUndecided, kHidden, kNoGain };  // kUndecided: an acceleration could leave it
  machine::ErrorTerm term;
  double evidence = 0.0;  // score when it was found
  double harm = 0.0;      // probability of being worse, with this effect and those that were held back after it
  Why why = kHarm;
};

// Structure that was found but has no name.
struct Unexplained {
  // a local defect along an axis; a slipped artefact or probe; a check session that reads more than chance under the
  // model; readings set aside that cluster along an axis; a fitted session that scatters by more than noise may
  enum Kind { kLocal, kSlip, kCheckSession, kBadReadings, kScatter };
  Kind kind = kLocal;
  std::string variable;         // axis, or "t" for a moment
  double from = 0.0, to = 0.0;  // mm, rad or s
  std::string session;          // where it shows most
  double rms_mm = 0.0;
  std::optional<Slipped> slip = std::nullopt;  // kSlip
};

// One change of the model, in the order in which they were made, and what was left of the residuals after the refit.
struct SelectionStep {
  // dropped: no longer needed; replaced: another of its class fits better by now, or better suits the check sessions;
  // withdrawn: the check sessions speak against it; refused: it promised much and the fit with it is worse
  enum Change { kAdded, kDropped, kReplaced, kWithdrawn, kRefused };
  Change change = kAdded;
  std::string name;
  double rms_mm = 0.0;  // of the fit sessions
};

struct Verdict {
  enum Kind { kAdequate, kExtended, kUnexplained };
};

// A candidate of the first search: what it is worth less what looking for it costs, chi-square units.
struct Ranked {
  Candidate candidate;
  double score = 0.0;
};

// What one session's readings scatter by, judged from themselves.
struct SessionNoise {
  std::string session;
  double stated_mm = 0.0, sigma_mm = 0.0;
  double neighbour_correlation = 0.0;
};

// What each reading of a session deviates by (predicted - measured) under the declared model and under the extended
// one.
struct SessionResiduals {
  std::string session;
  bool is_check = false;
  Eigen::MatrixXd before_mm, after_mm;  // rows of a reading x readings, as in the session's run
};

struct Report {
  Verdict::Kind verdict = Verdict::kAdequate;
  std::vector<Effect> effects;
  std::vector<Cause> causes;
  std::vector<HeldBack> held_back;  // in the order in which they were taken off
  std::vector<Unexplained> unexplained;
  std::vector<std::string> withdrawn;  // effects that did not help on the check sessions
  std::vector<SelectionStep> steps;    // from fit_before to fit_after
  machine::ErrorModel declared;        // as fitted alone
  identify::Result fitted;             // extended model, without what is held back
  identify::FitStatistics fit_before, fit_after, check_before, check_after;
  bool has_check = false;
  // Only the check sessions told the effects apart: all sessions were fitted together, what is said of fit sessions is
  // of all of them, and the check figures prove nothing.
  bool is_check_fitted = false;
  std::vector<SessionNoise> noise;          // of the fit sessions, under the extended model
  std::vector<SessionResiduals> residuals;  // fit sessions, then check sessions, in the order given
  std::vector<Proposal> next_measurement;   // sessions that would tell the effects' classes apart
  std::vector<Ranked> ranking;              // candidates of the first search, best first
  double evidence = 0.0;                    // a score beyond this is more than chance
  int candidates = 0;
  // Effects that would leave no trace in the fit sessions: setup offsets and declared errors take them up. One of each
  // component, shape and variable, crossed variables left out.
  std::vector<machine::ErrorTerm> not_visible;
  std::vector<reports::AxisRange> measured;  // where the readings stand that were fitted
  std::vector<std::string> axes_at_rest;     // that the fit sessions never moved: nothing is known of them
  // Of what the effects leave (objective::DesignEffect): 1 where it is noise, more where structure is left that nothing
  // explains.
  double design_effect = 1.0;
  bool has_stopped_early = false;                         // at the most effects allowed: more may be there
  std::vector<predict::OpenChoice> choices;               // between members of the effects' classes
  std::optional<predict::VolumetricError> volumetric;     // corrected for `fitted`
  std::shared_ptr<const identify::Fit> last_fit;          // of the extended model, with its runs
  std::string budget_json;                                // of the simulation, as it was given
  std::optional<identify::MonteCarloResult> monte_carlo;  // of the fit sessions under the extended model
};

// In the terms and units of the report that is stored, sent and printed.
reports::Loop ReportOf(const machine::Machine& machine, const Report& found);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_REPORT_H_
