// Harmonics of one axis' own errors at evenly spaced frequencies: hundreds of them, whose products come by
// trigonometric sums, linear in readings instead of readings times frequencies.
#ifndef AXISCAL_CORE_EFFECTS_HARMONIC_SCAN_H_
#define AXISCAL_CORE_EFFECTS_HARMONIC_SCAN_H_

#include <vector>

#include "core/effects/shaped.h"

namespace axiscal::effects {

class HarmonicScan : public Shaped {
 public:
  // Null where the items are no harmonics of one axis at multiples of one step. `linearised` must outlive it.
  static std::unique_ptr<HarmonicScan> Make(const Linearised& linearised, std::vector<ShapedItem> items);

  bool IsScan() const override { return true; }
  // Right to 1e-6 of the sum of magnitudes.
  void AddProducts(int begin, const Eigen::MatrixXd& u, Eigen::Ref<Eigen::MatrixXd> products) const override;
  std::vector<Eigen::MatrixXd> Grams(const objective::Whitening& whitening) const override;

 private:
  HarmonicScan(const Linearised& linearised, std::vector<ShapedItem> items, double first, double step, int count);
  Eigen::ArrayXd Positions(int begin, Eigen::Index count) const;

  int axis_;
  double first_, step_;     // frequencies, rad per unit of the axis
  int count_;               // of frequencies
  std::vector<int> order_;  // per item: which frequency
};

}  // namespace axiscal::effects

#endif  // AXISCAL_CORE_EFFECTS_HARMONIC_SCAN_H_
