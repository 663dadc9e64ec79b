#include "core/predict/taken_up.h"

#include <Eigen/QR>

#include "core/machine/chain.h"

namespace axiscal::predict {

Eigen::MatrixXd TakenUp(const machine::Machine& machine, int poses,
                        const std::function<const double*(int pose)>& positions_of) {
  Eigen::MatrixXd taken(3 * poses, 6);
  for (int k = 0; k < poses; ++k) {
    const machine::ChainPose<double> pose =
        machine::EvaluateChain<double>(machine, positions_of(k), machine::JointErrors<double>());
    taken.block<3, 3>(3 * k, 0).setIdentity();
    taken.block<3, 3>(3 * k, 3) = pose.bed_from_table.rotation.transpose() * pose.bed_from_tool.rotation;
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(taken);
  return qr.householderQ() * Eigen::MatrixXd::Identity(3 * poses, qr.rank());
}

}  // namespace axiscal::predict
