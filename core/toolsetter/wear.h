// Tool length and the wear of each round insert from a few readings of the length curve, by fitting the family of exact
// curves: not by joining readings with straight lines, whose largest reading misses the peaks.
//   reading_i = L_t + Z_t(theta_i + phase; W),   W_k = L_t - L_k,  L_t = max L_k
// Free: the length L_k of each insert and the phase (insert 1's place in the spindle, the start's height and the zero
// of the start angle are one parameter). Absolute wear is not separable from the length: the longest insert counts as
// unworn. An insert that fired at no reading has no number but a bound: it is worn by more than that.
#ifndef AXISCAL_CORE_TOOLSETTER_WEAR_H_
#define AXISCAL_CORE_TOOLSETTER_WEAR_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/reports/tool_setter.h"
#include "core/session/session.h"
#include "core/toolsetter/cutter_keys.h"
#include "core/toolsetter/length_curve.h"

namespace axiscal::toolsetter {

// A `tool-curve` session in core units.
struct CurveSession {
  std::string session;
  double sigma_mm = 0.0;       // of one reading
  double start_sigma_rad = 0;  // of a start angle (`start_sigma_deg`): readings near a jump of the curve weigh less
  Cutter cutter;
  CutterRun run;
  std::vector<double> starts_rad, lengths_mm;
};

inline constexpr double kUsualStartSigmaDeg = 0.1;

// INVALID_ARGUMENT naming session, key and rule; also when there are too few readings: inserts + 2 at different angles
// are the least.
absl::StatusOr<CurveSession> ReadCurveSession(const session::Session& session);
// Its `sigma_um` alone.
absl::StatusOr<double> CurveSigmaMm(const session::Session& session);

struct InsertWear {
  bool is_identifiable = false;
  double wear_mm = 0.0, sigma_mm = 0.0;  // against the longest insert; the longest has 0 +- 0
  double at_least_mm = 0.0;              // where not identifiable: 95 % bound
  int readings = 0;                      // at which it fired
  double share_rad = 0.0;                // of the start angles at which it fires, in the fitted curve
  // From this much more wear than the others it never fires at this feed, speed and offset (UnseenFromMm).
  double unseen_from_mm = 0.0;
};

struct WearReport {
  double length_mm = 0.0, length_sigma_mm = 0.0;  // L_t
  double phase_rad = 0.0, phase_sigma_rad = 0.0;
  std::vector<InsertWear> inserts;
  double rms_mm = 0.0, chi2 = 0.0;
  int degrees_of_freedom = 0;
  double coverage_factor = 1.959964;  // half of the 95 % interval in sigmas: Student's t where sigmas grew
  std::vector<double> residual_mm;    // measured - predicted per reading
  double longest_reading_mm = 0.0;    // usually taken for the length, but too small: it misses the curve's peak
  // Where inserts are not seen: FeedThatSees of what they are worn by at least (or what is unseen now, if that is
  // more). Nothing where no feed does. That they are worn by less than twice that is an assumption: nothing has seen
  // them.
  std::optional<FeedProposal> propose;
};

// INVALID_ARGUMENT as HeightsOf and CheckInsertsApart, and where the readings leave length and phase together.
// Sigmas grow by the root of chi-square over its degrees of freedom where that is above 1.
absl::StatusOr<WearReport> FitWear(const CurveSession& session);

// In the terms and units of the report that is stored, sent and printed.
reports::Wear ReportOf(const CurveSession& session, const WearReport& found);

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_WEAR_H_
