// Zc of one insert over the spindle angle, tabulated exactly on a fine grid wherever a trigger can happen, in any
// number of ranges: an insert crosses the beam twice in a turn, on the near and on the far side of the tool's axis, and
// where the offset is well below its reach the two stand far apart. Also where a tool that turns and sinks meets it
// first. With p = feed per turn, over the insert's own angle chi:
//   rise(chi) = Zc(chi) + p chi / 2 pi,   rise(chi + 2 pi) = rise(chi) + p
// A beam that stands at a rise meets the insert at the first chi that has it: a turn before that angle the tool stood p
// higher, so that all of it lies within one turn from Zc's peak.
#ifndef AXISCAL_CORE_TOOLSETTER_INSERT_HEIGHTS_H_
#define AXISCAL_CORE_TOOLSETTER_INSERT_HEIGHTS_H_

#include <vector>

#include "core/toolsetter/cutter.h"

namespace axiscal::toolsetter {

class InsertHeights {
 public:
  // Covers all heights down to `depth_mm` below the peak; depth_mm: what the tool sinks in a turn, or more.
  // INVALID_ARGUMENT when the insert never shades half of the beam; also when it would fire at an angle where its
  // cutting edge does not tell the height: it reaches across a part of the beam only, stands edge-on in it, or its
  // flank stands below the edge. Such angles do no harm where the tool has fired before.
  static absl::StatusOr<InsertHeights> Create(const Cutter& cutter, const CutterRun& run, double depth_mm);

  // Zc at any angle, and its derivative per rad where asked; -infinity outside the ranges. Cubic between exact values,
  // within 1e-9 mm.
  double At(double psi_rad, double* slope = nullptr) const;

  double peak_mm() const { return peak_mm_; }
  double peak_rad() const { return peak_rad_; }

  // The first chi at which the rise is `rise_mm`, and Zc's slope there per rad.
  double FirstAngle(double rise_mm, double* slope) const;
  // The highest rise up to `chi_rad`.
  double HighestRise(double chi_rad) const;
  // Angles within one turn from the peak, ascending and close together wherever the rise is higher than at all before:
  // a trigger happens nowhere else.
  std::vector<double> FiringAngles() const;

 private:
  struct Range {
    double first_rad = 0.0;  // of heights_mm[0], in [0, 2 pi); the range may go on beyond 2 pi
    std::vector<double> heights_mm;
  };
  // An angle at which the cutting edge alone does not tell when the insert fires: no higher than `most_mm`.
  struct Doubt {
    double psi_rad = 0.0, most_mm = 0.0;
    const char* why = "";
  };
  // From the angle `low_rad` to `high_rad` the rise goes up to `rise_mm`, above all before.
  struct Stop {
    double low_rad = 0.0, high_rad = 0.0, rise_mm = 0.0;
  };
  bool Tabulate(const Cutter& cutter, const CutterRun& run, const std::vector<std::pair<double, double>>& spans,
                double depth_mm);
  absl::Status FindStops(const CutterRun& run, const std::vector<Doubt>& doubts);
  double Rise(double chi_rad, double* slope = nullptr) const;

  double step_rad_ = 0.0;
  bool is_whole_turn_ = false;  // one range that goes round
  std::vector<Range> ranges_;   // ascending
  double peak_mm_ = 0.0, peak_rad_ = 0.0;
  double per_rad_mm_ = 0.0;     // p / 2 pi
  std::vector<Stop> stops_;     // ascending, from the peak over one turn
};

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_INSERT_HEIGHTS_H_
