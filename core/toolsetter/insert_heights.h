// Zc of one insert over the spindle angle, tabulated exactly on a fine grid where a trigger can happen: from its peak
// down to a depth below it, on both sides.
#ifndef AXISCAL_CORE_TOOLSETTER_INSERT_HEIGHTS_H_
#define AXISCAL_CORE_TOOLSETTER_INSERT_HEIGHTS_H_

#include <vector>

#include "core/toolsetter/cutter.h"

namespace axiscal::toolsetter {

class InsertHeights {
 public:
  // Covers all heights down to `depth_mm` below the peak. INVALID_ARGUMENT when the insert never shades half of the
  // beam, or does not reach across it at that depth.
  static absl::StatusOr<InsertHeights> Create(const Cutter& cutter, const CutterRun& run, double depth_mm);

  // Zc at any angle, and its derivative per rad where asked; -infinity outside the range. Cubic between exact values,
  // within 1e-9 mm.
  double At(double psi_rad, double* slope = nullptr) const;

  double peak_mm() const { return peak_mm_; }
  double peak_rad() const { return peak_rad_; }

 private:
  double first_rad_ = 0.0;  // of heights_mm_[0]
  std::vector<double> heights_mm_;
  double peak_mm_ = 0.0, peak_rad_ = 0.0;
};

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_INSERT_HEIGHTS_H_
