// The ends of the moves of a short program as poses, for comparisons pose by pose.
#ifndef AXISCAL_CORE_NC_POSES_H_
#define AXISCAL_CORE_NC_POSES_H_

#include <string>
#include <vector>

#include "core/compensate/compensator.h"
#include "core/nc/move_reader.h"
#include "core/nc/options.h"

namespace axiscal::nc {

struct ProgramPose {
  int64_t line = 0;
  compensate::Pose pose;
};

// mm and rad, in the order of machine.axes.
compensate::AxisValues AxisValuesOf(const machine::Machine& machine, const Positions& positions);

// INVALID_ARGUMENT with the line: a block that is no linear move in axis positions, a move before every axis was
// programmed, more than `most` moves; none at all. Errors of the readers.
absl::StatusOr<std::vector<ProgramPose>> ReadPoses(const ByteReader& reader, const machine::Machine& machine,
                                                   const RewriteOptions& options, size_t most);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_POSES_H_
