// The Z of a tool setter's beam from the readouts of several rods, and where asked its yaw and pitch.
//   predicted readout: Z'_s = mO_z + L_r + Zd(rod; yaw, pitch)        (Fang 2022, 2.38)
// Generalised least squares over the rods' mean readouts. Covariance: repeatability, the stated uncertainty of rods and
// beam (shared where they share a cause), and a component between rods that is estimated when they disagree more than
// all that explains (Paule and Mandel 1982): rods carry errors of their length and face that repeats do not show. Where
// one rod's readouts alone scatter more than is stated, the covariance grows by chi-square over its degrees of freedom.
#ifndef AXISCAL_CORE_TOOLSETTER_REFERENCE_H_
#define AXISCAL_CORE_TOOLSETTER_REFERENCE_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/information/information.h"
#include "core/reports/tool_setter.h"
#include "core/toolsetter/rod_session.h"

namespace axiscal::toolsetter {

// Yaw and pitch stay as the session states them (weighed by its beam_sigma) unless they are asked for.
struct ReferenceOptions {
  bool fit_yaw = false, fit_pitch = false;
};

struct RodAnswer {
  std::string name;
  Trigger trigger;  // at the fitted beam
  int readouts = 0;
  double mean_mm = 0.0, range_mm = 0.0;       // of its readouts
  double reference_mm = 0.0, sigma_mm = 0.0;  // mO_z by this rod alone; without the component between rods
};

// mO_z, yaw, pitch in this order wherever they stand in rows.
enum ReferenceParameter { kReferenceZ, kReferenceYaw, kReferencePitch, kReferenceParameters };
const char* ParameterName(ReferenceParameter parameter);  // "Z", "yaw", "pitch"

struct Fitted {
  bool is_free = false;                // estimated here, with or without a prior
  bool is_identifiable = true;         // false: the rods cannot tell, estimate and sigma say nothing
  double estimate = 0.0, sigma = 0.0;  // mm or rad
};

// Turning the spindle with a tilted rod tells yaw, pitch and Z apart; of several the one that tells most.
struct RodProposal {
  std::string rod;
  std::vector<double> holder_rad;
  std::array<double, kReferenceParameters> sigma = {};  // expected, mm and rad, without the rod's own length error
};

struct Reference {
  std::vector<RodAnswer> rods;  // measured ones only
  std::array<Fitted, kReferenceParameters> parameters;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // mm and rad; NaN rows where not identifiable
  // Directions along which the rods say nothing: changes of (Z mm, yaw rad, pitch rad) that leave all readouts alike.
  std::vector<Eigen::Vector3d> unseen;
  double range_mm = 0.0;         // of the rods' own answers
  double between_rods_mm = 0.0;  // standard deviation of the rods' own errors, beyond what is stated
  double chi2 = 0.0;             // without that component
  int degrees_of_freedom = 0;    // 0: whether the rods agree cannot be judged
  // Degrees of freedom that are left to judge what each rod is off by itself: its length and face, which no repeat of
  // it shows. 0: nothing does.
  int degrees_between_rods = 0;
  // Which parameters have a sigma that rests on readouts or on what was stated of the rods (`rod_sigma`). Of the others
  // Fitted::sigma is that of repeatability alone, and is in no report.
  std::array<bool, kReferenceParameters> has_interval = {true, true, true};
  double coverage_factor = 1.959964;  // half the 95 % interval, sigmas; Student's t where the rods' scatter counts
  std::optional<RodProposal> next;
};

// What the readouts tell of Z, yaw and pitch (all three free, in the order of ReferenceParameter, mm and rad) in the
// beam as the session states it, by repeatability and what is stated of rods and beam radius; whatever the readouts
// are. It adds up over sessions that share none of those. INVALID_ARGUMENT as FitReference.
absl::StatusOr<information::Information> InformationOf(const RodSession& session);

// INVALID_ARGUMENT when no rod was measured or a rod cannot shade the beam.
absl::StatusOr<Reference> FitReference(const RodSession& session, const ReferenceOptions& options = {});

// In the terms and units of the report that is stored, sent and printed.
reports::BeamReference ReportOf(const RodSession& session, const Reference& reference);

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_REFERENCE_H_
