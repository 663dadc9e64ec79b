// How far the tool point is from where it should be, anywhere in a box of axis positions, before and after a
// calibration. Lengths in um; positions in mm of a linear axis, degrees of a rotary one.
#ifndef AXISCAL_CORE_RECORDS_VOLUMETRIC_H_
#define AXISCAL_CORE_RECORDS_VOLUMETRIC_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/ids.h"
#include "core/records/calibration.h"

namespace axiscal::records {

struct AxisSpan {
  std::string axis;
  double from = 0.0, to = 0.0;
};

// The mean over the errors' uncertainty, and its 95 % interval.
struct VolumetricFigure {
  double expected_um = 0.0, low_um = 0.0, high_um = 0.0;
};

// Of the length of the tool point's error at poses drawn evenly from the box, less the work offset and the tool's
// length and centre that suit all poses best.
struct VolumetricFigures {
  VolumetricFigure rms, median, p95, max;
  std::vector<double> largest_at;  // in the order of VolumetricError::box
};

struct VolumetricError {
  CalibrationId calibration;
  base::UtcTime measured_at;
  CalibrationState state = CalibrationState::kCandidate;
  std::optional<CalibrationId> before_calibration;  // that was in use before, or is where this one never was
  std::vector<AxisSpan> box, measured;              // of all axes of the machine
  int poses = 0;
  double known_share = 0.0;  // of the poses within the measured positions; elsewhere the figures are extrapolated
  VolumetricFigures uncorrected, after;
  std::optional<VolumetricFigures> before;             // corrected for before_calibration
  std::optional<VolumetricFigures> after_where_known;  // of the measured poses alone, where there are others too
  std::vector<std::string> weakest;  // numbers whose uncertainty makes most of `after`, the largest first
  std::vector<std::string> unknown;  // errors without a number that act over the box: in none of the figures
  std::string problem;               // why there are no figures; empty where there are
};

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_VOLUMETRIC_H_
