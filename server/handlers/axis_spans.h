// Boxes of axis positions as the API names them: v1::AxisSpan.
#ifndef AXISCAL_SERVER_HANDLERS_AXIS_SPANS_H_
#define AXISCAL_SERVER_HANDLERS_AXIS_SPANS_H_

#include <google/protobuf/repeated_field.h>

#include "axiscal/v1/volumetric.pb.h"
#include "core/base/status.h"
#include "core/predict/box_poses.h"

namespace axiscal::handlers {

using Spans = google::protobuf::RepeatedPtrField<v1::AxisSpan>;

// What a position of the axis is multiplied with to come from the API's unit (mm, deg) to the engine's (mm, rad).
double UnitOf(const machine::Axis& axis);

// The measured positions, and of axes that are asked those. INVALID_ARGUMENT naming the field `box[i]`.
absl::StatusOr<predict::Box> BoxOf(const machine::Machine& machine, const predict::Box& measured, const Spans& asked);

void SetSpans(const machine::Machine& machine, const predict::Box& box, Spans* spans);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_AXIS_SPANS_H_
