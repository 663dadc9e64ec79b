// What is set anew before a part is cut, and so is no error of the machine at work: the work offset, a shift in the
// table's frame, and the tool's length and centre, a shift in the tool's frame.
#ifndef AXISCAL_CORE_PREDICT_TAKEN_UP_H_
#define AXISCAL_CORE_PREDICT_TAKEN_UP_H_

#include <Eigen/Core>
#include <functional>

#include "core/machine/machine.h"

namespace axiscal::predict {

// Orthonormal basis (3 poses x rank) of what these shifts do to the tool point in the table's frame; rows 3 k .. 3 k +
// 2 belong to pose k, whose axis positions are `positions_of(k)`. Less basis basis' v, errors v are those that remain
// once the offset and the tool suit all poses best.
Eigen::MatrixXd TakenUp(const machine::Machine& machine, int poses,
                        const std::function<const double*(int pose)>& positions_of);

}  // namespace axiscal::predict

#endif  // AXISCAL_CORE_PREDICT_TAKEN_UP_H_
