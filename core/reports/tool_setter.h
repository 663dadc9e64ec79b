// The reports of the tool setter (docs/formats.md, "Tool-setter reports"): the beam's reference from measuring rods,
// and length and wear of a round-insert mill. Plain data in the terms and units of the JSON.
#ifndef AXISCAL_CORE_REPORTS_TOOL_SETTER_H_
#define AXISCAL_CORE_REPORTS_TOOL_SETTER_H_

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/base/status.h"
#include "core/reports/fitted.h"

namespace axiscal::reports {

// A parameter of the beam, mm or deg: stated, or estimated, or neither where the rods cannot tell it.
struct BeamParameter {
  std::optional<double> stated = {};
  double estimate = kNoNumber, sigma = kNoNumber;
  bool identifiable = false;
};

struct RodAnswer {
  std::string rod = {};
  int readouts = 0;
  double mean_mm = kNoNumber, range_um = kNoNumber;
  double trigger_height_mm = kNoNumber, reference_mm = kNoNumber, sigma_um = kNoNumber;
  double residual_um = kNoNumber;
};

// Changes that leave all readouts alike; what takes no part is not set.
struct Unseen {
  std::optional<double> z_um = {}, yaw_urad = {}, pitch_urad = {};
};

struct RodProposal {
  std::string rod = {};
  std::vector<double> theta_th_deg = {};
  double sigma_um = kNoNumber, yaw_sigma_deg = kNoNumber, pitch_sigma_deg = kNoNumber;  // expected
};

struct BeamReference {
  std::string session = {};
  BeamParameter reference_mm = {}, yaw_deg = {}, pitch_deg = {};
  double range_um = kNoNumber;         // of the rods' own answers
  double between_rods_um = kNoNumber;  // 1 sigma of what each rod is off by itself
  double chi2 = kNoNumber;
  int degrees_of_freedom = 0;
  double coverage_factor = kNoNumber;  // half of the 95 % interval in sigmas
  std::vector<Warning> warnings = {};
  std::vector<RodAnswer> rods = {};
  std::vector<Unseen> not_told_apart = {};
  std::optional<RodProposal> next_measurement = {};
};

struct InsertWear {
  int insert = 0;  // from 1
  bool identifiable = false;
  double wear_um = kNoNumber, sigma_um = kNoNumber;
  std::optional<double> at_least_um = {};  // where not identifiable
  int readings = 0;                        // at which it fired
  double fires_first_deg = kNoNumber, unseen_from_um = kNoNumber;
};

struct CurveReading {
  double start_deg = kNoNumber, length_mm = kNoNumber, residual_um = kNoNumber;
};

struct FeedProposal {
  double feed_mm_min = kNoNumber, spindle_rpm = kNoNumber;
  double sees_up_to_um = kNoNumber;  // wear that the inserts which were not seen would show there, by the model
};

struct Wear {
  std::string session = {};
  double length_mm = kNoNumber, length_sigma_um = kNoNumber;
  double phase_deg = kNoNumber, phase_sigma_deg = kNoNumber;
  std::vector<InsertWear> inserts = {};
  double rms_um = kNoNumber, chi2 = kNoNumber;
  int degrees_of_freedom = 0;
  double coverage_factor = kNoNumber;  // half of the 95 % interval in sigmas
  std::vector<Warning> warnings = {};
  double longest_reading_mm = kNoNumber;
  std::vector<CurveReading> readings = {};
  std::optional<FeedProposal> next_measurement = {};
};

using ToolSetter = std::variant<BeamReference, Wear>;

std::string ToJson(const BeamReference& report);
std::string ToJson(const Wear& report);
std::string ToJson(const ToolSetter& report);
// A report with inserts is of wear. INVALID_ARGUMENT naming line and column, or the member that is wrong.
absl::StatusOr<ToolSetter> ReadToolSetter(const std::string& text);

}  // namespace axiscal::reports

#endif  // AXISCAL_CORE_REPORTS_TOOL_SETTER_H_
