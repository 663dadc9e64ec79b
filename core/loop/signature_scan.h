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

// Noise by which signatures have squares that take few sums: whitened_k = weight_k (x_k - correlation_k x_(k-1)). They
// are at most those by the readings' own noise, and times `excess` at least.
struct ScanNoise {
  const Eigen::ArrayXd &weight, &correlation;
  double excess = 1.0;
};

// `by_raw_row`: a raw column's product with it is that of the whitened column with the whitened and projected residual;
// `sensitivity` is raw (rows x 6 joints), `state_of(row)` where the axes are.
std::vector<ScanBounds> Scan(const std::vector<Candidate>& candidates, const ScanNoise& noise,
                             const Eigen::ArrayXd& by_raw_row, const Eigen::MatrixXd& sensitivity,
                             const std::function<shapes::State(int row)>& state_of);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_SIGNATURE_SCAN_H_
