// The volumetric error on the wire, as clients read it.
#ifndef AXISCAL_PROTO_CONVERT_VOLUMETRIC_H_
#define AXISCAL_PROTO_CONVERT_VOLUMETRIC_H_

#include "axiscal/v1/volumetric.pb.h"
#include "core/base/status.h"
#include "core/records/volumetric.h"

namespace axiscal::convert {

v1::AxisSpan ToProto(const records::AxisSpan& span);
// FIELD_INVALID: no state that is known here.
absl::StatusOr<records::VolumetricError> FromProto(const v1::VolumetricError& message);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_VOLUMETRIC_H_
