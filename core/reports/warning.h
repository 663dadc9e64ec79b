// What a reader of numbers must know: a kind and the facts; here alone it is put into words, English and German.
#ifndef AXISCAL_CORE_REPORTS_WARNING_H_
#define AXISCAL_CORE_REPORTS_WARNING_H_

#include <string>
#include <variant>
#include <vector>

namespace axiscal::reports {

// Chi-square per degree of freedom above which a fit is poor: the readings scatter by more than twice their stated
// sigma.
inline constexpr double kPoorFitChi2PerDof = 4.0;

enum class WarningKind {
  kScatter,      // the readings scatter about the fit, beyond the stated sigma
  kSetAside,     // too many readings were
  kInterval,     // errors without one
  kNoNumber,     // errors without a number that the model holds at implausible sizes
  kHeld,         // two stages share what their sigmas take for independent
  kResolution,   // readings are rounded to more than they scatter by
  kSize,         // errors or set-ups beyond what a machine of this size can have
  kQuiet,        // readings scatter by far less than stated
  kDatum,        // sessions disagree by a constant of the commanded positions
  kNoFreedom,    // as many unknowns as readings: nothing is left that would judge the model or the stated sigmas
  kCertificate,  // a certificate was not valid when its session was measured
  kClock,        // sessions do not count their times from one start
  kMoved,        // an instrument moved while it measured; what it did is taken off
  kOther,        // of a newer version; its text says what
};

// As it stands in a report.
struct Warning {
  WarningKind kind = WarningKind::kScatter;
  std::string text;
  std::string german = {};  // the same in German; empty in a report of a version that did not write it
};

// The facts, a struct per kind.
struct Scatter {
  enum class About { kModel, kCutter };
  double times_sigma = 0.0;  // root of chi-square per degree of freedom
  About about = About::kModel;
};
struct SetAside {
  int set_aside = 0, readings = 0;
};
struct NoInterval {
  std::vector<std::string> errors;
};
struct NoNumber {
  struct Size {
    std::string error;
    double size = 0.0;  // in `unit`
    std::string unit;
  };
  std::vector<Size> errors;
};
// An offset of a set-up: "run_out_x" of set-up "mount".
struct OffsetOf {
  std::string name, setup;
};
// `sessions` whose readings gave both stages, else `offsets` that both know to one sigma.
struct SharedStages {
  std::vector<std::string> sessions;
  std::vector<OffsetOf> offsets;
};
struct CoarseReadings {
  std::string session;
  double step_um = 0.0, sigma_um = 0.0, rounding_sigma_um = 0.0;
  double most_sigmas = 0.0;  // a step of at most so many stated sigmas hides nothing
};
// Of a machine about `size_mm` across: errors beyond limit_um or limit_urad, offsets of a set-up beyond any mounting.
struct BeyondSize {
  struct Value {
    std::string name;  // EZ0T, ball_z
    double value = 0.0;
    std::string unit;
    std::string setup = {};  // of an offset
  };
  // A radius that a file states: of the stylus, or of the sphere that is named.
  struct Radius {
    double mm = 0.0;
    std::string sphere = {};
    bool operator==(const Radius&) const = default;
  };
  std::vector<Value> errors, offsets;
  double size_mm = 0.0, limit_um = 0.0, limit_urad = 0.0;
  std::vector<Radius> near;  // those that are about as large
};
struct Quiet {
  std::vector<std::string> sessions;
  double share = 0.0;  // of the stated sigma
};
struct DatumMoved {
  struct Axis {
    std::string name;
    double moved_um = 0.0, sigma_um = 0.0;  // true - commanded position
  };
  struct Group {
    std::vector<std::string> sessions;
    std::vector<Axis> axes;
  };
  std::vector<Group> groups;
  std::vector<std::string> in_place_of;  // effects of the loop that the constants explain as well
};
struct NoFreedom {
  std::string unknowns, readings;  // "Z, yaw, pitch", "3 rods"
  // What has no sigma for it; empty: all sigmas rest on what was stated beforehand.
  std::vector<std::string> without_sigma;
  std::string what_to_do;
};
struct Expired {
  std::string session, of, number;  // "BX", "bar_length", of the certificate
  std::string due, started;         // dates; started is empty where nothing states it
};
// Sessions of which two overlap in time, though no machine is measured twice at a time.
struct TwoClocks {
  std::string session, other;
  std::vector<std::string> errors;  // that need one clock
};
// A tracker moved: its reference targets show it.
struct TrackerMoved {
  std::string session;
  int references = 0, looks = 0;          // targets beside the machine, and how often they were measured
  double moved_um = 0.0, sigma_um = 0.0;  // the farthest that a target in the middle of the readings seemed to go
  double turned_urad = 0.0, turn_sigma_urad = 0.0;  // at the same look
  double at_s = 0.0;                                // t_s of that look
};
using WarningFacts = std::variant<Scatter, SetAside, NoInterval, NoNumber, SharedStages, CoarseReadings, BeyondSize,
                                  Quiet, DatumMoved, NoFreedom, Expired, TwoClocks, TrackerMoved>;

// Whether nothing else of the report is worth reading before it is settled: such warnings stand first.
inline bool ComesFirst(WarningKind kind) { return kind == WarningKind::kSize || kind == WarningKind::kQuiet; }

Warning InWords(const WarningFacts& facts);
// The German half of it.
std::string InGerman(const WarningFacts& facts);

// The same scatter where a stored calibration is shown, with what to do about it: after the loop nothing, for it has
// looked already.
std::string PoorFitText(double chi2_per_dof, bool is_of_loop);

}  // namespace axiscal::reports

#endif  // AXISCAL_CORE_REPORTS_WARNING_H_
