// The scans of the dictionary (frequencies, places): what each member could explain, from sums over readings that need
// no projection.
#ifndef AXISCAL_CORE_LOOP_SIGNATURE_SCAN_H_
#define AXISCAL_CORE_LOOP_SIGNATURE_SCAN_H_

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "core/loop/candidate.h"

namespace axiscal::loop {

// Families that scan: neighbours are alike, hardly any of them is mostly explained by declared errors.
inline bool IsScan(Family family) {
  return family == Family::kFineHarmonic || family == Family::kPitch || family == Family::kBump;
}

// What a scan's member explains of the residual's squares at least, and at most unless nearly all of it is projected
// off. Zero for other families.
struct ScanBounds {
  double least = 0.0, most = 0.0;
};

// Whitened: value_k = weight_k (x_k - correlation_k x_(k-1)); `residual` is whitened and projected, `sensitivity` raw
// (rows x 6 joints), `state_of(row)` where the axes are.
std::vector<ScanBounds> Scan(const std::vector<Candidate>& candidates, const Eigen::ArrayXd& weight,
                             const Eigen::ArrayXd& correlation, const Eigen::VectorXd& residual,
                             const Eigen::MatrixXd& sensitivity, const std::function<shapes::State(int row)>& state_of);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_SIGNATURE_SCAN_H_
