// Whether an error of a machine is unlike those of its peers, machines of the same group:
//   t = (value - mean) / sqrt(s^2 (1 + 1 / n) + sigma^2)
// with mean and standard deviation s of n peers, against Student's t of n - 1 degrees of freedom. Where a peer is
// itself unlike the others, s is larger and less is said.
#ifndef AXISCAL_CORE_DRIFT_PEERS_H_
#define AXISCAL_CORE_DRIFT_PEERS_H_

#include <optional>
#include <vector>

namespace axiscal::drift {

// Fewer do not tell what is usual.
inline constexpr int kLeastPeers = 5;

// In the error's unit.
struct Unlikeness {
  double usual = 0.0;        // the peers' mean
  double spread = 0.0;       // one standard deviation of the peers
  double away = 0.0;         // value - usual
  double sigma = 0.0;        // of `away`, for a machine like the peers
  double probability = 1.0;  // that a machine like the peers is so far away, either way
};

// `sigma`: standard uncertainty of `value`, >= 0. Nothing with fewer peers than kLeastPeers, or where all have one
// value.
std::optional<Unlikeness> UnlikePeers(double value, double sigma, const std::vector<double>& peers);

}  // namespace axiscal::drift

#endif  // AXISCAL_CORE_DRIFT_PEERS_H_
