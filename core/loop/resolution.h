// Whether the sessions that see an effect also sample its variable finely enough for it. A ball-bar circle of X and Y
// resolves the pitch of a screw but shows nothing in Z; an R-test shows Z but has too few places for the pitch.
#ifndef AXISCAL_CORE_LOOP_RESOLUTION_H_
#define AXISCAL_CORE_LOOP_RESOLUTION_H_

#include "core/loop/signatures.h"

namespace axiscal::loop {

class Resolution {
 public:
  explicit Resolution(const Signatures& signatures);

  // Whether sessions with more than two readings per period hold a good part of what is seen of this component
  // (whitened squares of its sensitivity where the axis moves). True for what is not a harmonic.
  bool Resolves(const machine::ErrorTerm& term) const;

 private:
  Eigen::MatrixXd seen_;  // runs x 6 joints
  Eigen::MatrixXd step_;  // runs x axes: median step, 0 where the axis stands still; mm or rad
};

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_RESOLUTION_H_
